"""Columns of the wheelsets' motion, in the order of the contract's terminal."""

from rail_quantities import terminals

VELOCITY_COLUMNS = slice(5, 10)
"""Rates of x, y, z, roll, yaw in a motion row (see :data:`MOTION`)."""

MOTION = tuple(member.name for member in terminals.MOTION)
"""Columns of a motion array, shape (wheelsets, 11); SI units."""
