"""Parts of a state's vector as compiled code sees them (see :mod:`slab_track.state`)."""

import math

from rail_quantities.uncounted import shaped

from slab_track.compiled import kernel, view
from slab_track.contact.wheelset import FORCED, LOCATED
from slab_track.interaction import Wheels
from slab_track.state import (
    CREEP,
    EARLIER_FORCE,
    FASTENER_FORCE,
    LOCATED_PATCHES,
    NORMAL,
    PATCH_FORCES,
    RAIL,
    RAIL_A,
    RAIL_FORCE,
    RAIL_S,
    WHEELSET,
)
from slab_track.vertical import ClassFields

_SQRT_HALF = math.sqrt(0.5)


@view
def part(vector, starts, number):
    """Return a part of a state's vector, flat."""
    return shaped(vector, starts[number], (starts[number + 1] - starts[number],))


@view
def rows_of(vector, starts, number, rows):
    """Return a part of a state's vector in rows of equal length."""
    length = (starts[number + 1] - starts[number]) // rows
    return shaped(vector, starts[number], (rows, length))


@kernel
def wheels_of(new, starts, count):
    """Return the :class:`slab_track.interaction.Wheels` of a state's vector."""
    return Wheels(
        shaped(new, starts[RAIL_FORCE], (count, 2, 3)),
        shaped(new, starts[EARLIER_FORCE], (count, 2, 3)),
        shaped(new, starts[NORMAL], (count, 2, 2)),
        shaped(new, starts[CREEP], (count, 2, 2)),
        shaped(new, starts[RAIL], (count, 2, 6)),
        shaped(new, starts[WHEELSET], (count, 6)),
        shaped(new, starts[LOCATED_PATCHES], (count, 2, 2, LOCATED)),
        shaped(new, starts[PATCH_FORCES], (count, 2, 2, FORCED)),
    )


@kernel
def class_fields(old, new, starts, symmetry, fasteners):
    """Return the :class:`slab_track.vertical.ClassFields` of two states' vectors."""
    first = RAIL_S if symmetry == 0 else RAIL_A
    begin = starts[FASTENER_FORCE] + symmetry * fasteners
    return ClassFields(
        rows_of(old, starts, first, 3),
        rows_of(old, starts, first + 1, 3),
        shaped(old, starts[first + 2], (2, fasteners)),
        rows_of(new, starts, first, 3),
        rows_of(new, starts, first + 1, 3),
        shaped(new, starts[first + 2], (2, fasteners)),
        shaped(new, begin, (fasteners,)),
    )


@kernel
def class_force(force, sign, own):
    """Fill wheel forces (w,) of a symmetry class from those of the rails (w, 2, 3)."""
    for wheel in range(own.size):
        own[wheel] = _SQRT_HALF * (force[wheel, 1, 1] + sign * force[wheel, 0, 1])


@kernel
def side_force(force, side, own):
    """Fill lateral force and roll moment on one rail, (2, w), from the forces (w, 2, 3)."""
    for wheel in range(force.shape[0]):
        own[0, wheel], own[1, wheel] = force[wheel, side, 0], force[wheel, side, 2]
