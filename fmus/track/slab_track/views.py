"""Parts of a state's vector as compiled code sees them (see :mod:`slab_track.state`)."""

import math

import numpy as np

from slab_track.compiled import kernel
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


@kernel
def part(vector, starts, number):
    """Return a part of a state's vector, flat."""
    return vector[starts[number] : starts[number + 1]]


@kernel
def wheels_of(new, starts, count):
    """Return the :class:`slab_track.interaction.Wheels` of a state's vector."""
    return Wheels(
        part(new, starts, RAIL_FORCE).reshape((count, 2, 3)),
        part(new, starts, EARLIER_FORCE).reshape((count, 2, 3)),
        part(new, starts, NORMAL).reshape((count, 2, 2)),
        part(new, starts, CREEP).reshape((count, 2, 2)),
        part(new, starts, RAIL).reshape((count, 2, 6)),
        part(new, starts, WHEELSET).reshape((count, 6)),
        part(new, starts, LOCATED_PATCHES).reshape((count, 2, 2, LOCATED)),
        part(new, starts, PATCH_FORCES).reshape((count, 2, 2, FORCED)),
    )


@kernel
def class_fields(old, new, starts, symmetry, fasteners):
    """Return the :class:`slab_track.vertical.ClassFields` of two states' vectors."""
    first = RAIL_S if symmetry == 0 else RAIL_A
    begin = starts[FASTENER_FORCE] + symmetry * fasteners
    return ClassFields(
        part(old, starts, first).reshape((3, -1)),
        part(old, starts, first + 1).reshape((3, -1)),
        part(old, starts, first + 2).reshape((2, fasteners)),
        part(new, starts, first).reshape((3, -1)),
        part(new, starts, first + 1).reshape((3, -1)),
        part(new, starts, first + 2).reshape((2, fasteners)),
        new[begin : begin + fasteners],
    )


@kernel
def class_force(force, sign):
    """Wheel forces (w,) of a symmetry class from those of the rails (w, 2, 3)."""
    own = np.empty(force.shape[0])
    for wheel in range(own.size):
        own[wheel] = _SQRT_HALF * (force[wheel, 1, 1] + sign * force[wheel, 0, 1])
    return own


@kernel
def side_force(force, side):
    """Lateral force and roll moment on one rail, (2, w), from the forces (w, 2, 3)."""
    own = np.empty((2, force.shape[0]))
    for wheel in range(force.shape[0]):
        own[0, wheel], own[1, wheel] = force[wheel, side, 0], force[wheel, side, 2]
    return own
