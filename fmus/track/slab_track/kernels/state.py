"""What the track remembers, as the kernels see it (see :class:`slab_track.state.StateLayout`)."""

from typing import NamedTuple

from rail_native import Array3, Array4, Matrix, Vector

from slab_track.contact.interaction import Wheels
from slab_track.kernels.vertical import VerticalFields

(
    TIME,
    POINT_TIME,
    PREVIOUS_TIME,
    WINDOW_START,
    SHIFT_COUNT,
    SHIFT_RESIDUAL,
    DATUM,
) = range(7)
"""Places of the single numbers at the head."""

HEAD = 7

WHEEL_OUTPUTS = 10
"""Rows of what happens at the wheels, see :attr:`slab_track.state.TrackState.wheel_outputs`."""


class StateArrays(NamedTuple):
    """One vector, and its parts by name.

    Attributes
    ----------
    small, fields
        All that comes before the fields, and these: rails, slabs, fasteners.
    head
        Single numbers: TIME, ..., (HEAD,).
    static_heights, places
        Of the wheelsets at the start, (w,), m.
    motion_now, motion_before, rates_seen
        The last two communication points, (w, 11) each, and which rates were seen, (5,).
    row
        Motion at the end of the internal step, heights from first touch, (w, 11).
    wheels
        Forces and motions at the wheels.
    outputs
        What happens at the wheels, (WHEEL_OUTPUTS, w, 2).
    vertical
        Rails, slabs and fasteners.
    lateral
        Lateral and torsional coordinates, (2, 3, 3, N): rail; displacement, velocity,
        acceleration; branch; wave.
    """

    small: Vector
    fields: Vector
    head: Vector
    static_heights: Vector
    places: Vector
    motion_now: Matrix
    motion_before: Matrix
    rates_seen: Vector
    row: Matrix
    wheels: Wheels
    outputs: Array3
    vertical: VerticalFields
    lateral: Array4
