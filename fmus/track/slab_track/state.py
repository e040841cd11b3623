"""What the track remembers: one vector of numbers, and its parts by name.

A step makes a new vector from an old one; so a state never changes once it is made, and saving
it is keeping one array. The parts are views.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from slab_track.contact.interaction import Wheels
from slab_track.contact.wheelset import FORCED, LOCATED, NORMAL_FORCE
from slab_track.kernels.motion import COLUMNS
from slab_track.kernels.state import (
    DATUM,
    HEAD,
    POINT_TIME,
    PREVIOUS_TIME,
    SHIFT_COUNT,
    SHIFT_RESIDUAL,
    TIME,
    WHEEL_OUTPUTS,
    WINDOW_START,
    StateArrays,
)
from slab_track.kernels.vertical import VerticalFields
from slab_track.motion import VELOCITY_COLUMNS

_PARTS = (
    "head",
    "static_heights",
    "places",
    "motion_now",
    "motion_before",
    "rates_seen",
    "row",
    "rail_force",
    "earlier_force",
    "normal",
    "creep",
    "rail",
    "located",
    "forces",
    "wheelset",
    "outputs",
    "rail_fields",
    "slab_fields",
    "compression",
    "fastener_force",
    "lateral",
)
"""The parts in their order in the vector; what is given to the partner lies side by side."""

_FIELDS = "rail_fields"


class FieldState(NamedTuple):
    """Coordinates of one symmetry class: displacement, velocity, acceleration.

    Attributes
    ----------
    rail
        Shape (3, 2, N): derivative, branch, wave number.
    slab
        Shape (3, S, n): derivative, slab, mode.
    compression
        Of the fasteners, modes and residual together, m, and its rate, m/s, shape (2, P).
    """

    rail: np.ndarray
    slab: np.ndarray
    compression: np.ndarray


def no_wheel_forces(wheelsets: int) -> Wheels:
    """Return :class:`slab_track.contact.interaction.Wheels` without any force."""
    w = wheelsets
    shapes = ((w, 2, 3), (w, 2, 3), (w, 2, 2), (w, 2, 2), (w, 2, 6), (w, 6))
    return Wheels(
        *(np.zeros(shape) for shape in shapes),
        located=np.zeros((w, 2, 2, LOCATED)),
        forces=np.zeros((w, 2, 2, FORCED)),
    )


class StateLayout:
    """Where the parts of a state lie in its vector.

    Attributes
    ----------
    shapes, slices
        Of the parts, by name.
    slab_modes
        Modes of a slab in the symmetric and in the antisymmetric class.
    size
        Length of the vector.
    """

    def __init__(
        self, *, wheelsets: int, waves: int, fasteners: int, slabs: int, slab_modes: Sequence[int]
    ) -> None:
        w, self.slab_modes = wheelsets, tuple(slab_modes)
        shapes: tuple[tuple[int, ...], ...] = (
            (HEAD,),
            (w,),
            (w,),
            (w, COLUMNS),
            (w, COLUMNS),
            (5,),
            (w, COLUMNS),
            (w, 2, 3),
            (w, 2, 3),
            (w, 2, 2),
            (w, 2, 2),
            (w, 2, 6),
            (w, 2, 2, LOCATED),
            (w, 2, 2, FORCED),
            (w, 6),
            (WHEEL_OUTPUTS, w, 2),
            (2, 3, 2, waves),
            (2, 3, slabs, max(slab_modes)),
            (2, 2, fasteners),
            (2, fasteners),
            (2, 3, 3, waves),
        )
        self.shapes = dict(zip(_PARTS, shapes, strict=True))
        ends = np.cumsum([0, *(math.prod(shape) for shape in shapes)]).tolist()
        self.slices = {
            name: slice(start, stop)
            for name, start, stop in zip(_PARTS, ends[:-1], ends[1:], strict=True)
        }
        self.size = int(ends[-1])

    def places(self, part: str) -> np.ndarray:
        """Return the places of a part's numbers in the vector, in its shape."""
        here = self.slices[part]
        return np.arange(here.start, here.stop).reshape(self.shapes[part])

    def view(self, vector: np.ndarray, part: str) -> np.ndarray:
        """Return a part of the state as a view of its vector."""
        return vector[self.slices[part]].reshape(self.shapes[part])

    def arrays(self, vector: np.ndarray) -> StateArrays:
        """Return all parts as the kernels see them; views of the vector."""
        of = {name: self.view(vector, name) for name in _PARTS}
        fields = self.slices[_FIELDS].start
        return StateArrays(
            small=vector[:fields],
            fields=vector[fields:],
            wheels=Wheels(**{name: of.pop(name) for name in Wheels._fields}),
            vertical=VerticalFields(
                rail=of.pop("rail_fields"),
                slab=of.pop("slab_fields"),
                compression=of.pop("compression"),
                fastener_force=of.pop("fastener_force"),
            ),
            **of,
        )


def _number(place: int) -> Any:
    return property(lambda self: float(self.vector[place]))


def _array(part: str) -> Any:
    return property(lambda self: self.layout.view(self.vector, part))


class TrackState:
    """Everything that the track remembers.

    Attributes
    ----------
    layout, vector
        The numbers and how they are arranged.
    time
        s.
    symmetric, antisymmetric
        Vertical coordinates of both symmetry classes.
    rails
        Lateral and torsional coordinates, (2, 3, 3, N): rail, derivative, branch, wave number.
    motion
        Wheelset motion at the last communication point, (wheelsets, 11).
    wheels
        Forces and rail motions at the wheels.
    wheel_outputs
        What happens at the wheels, (WHEEL_OUTPUTS, wheelsets, 2), left first. Rows: normal,
        longitudinal and lateral creep force, N; penetration, m, and contact angle, rad, of the
        patch that carries most; vertical displacement of the rail's axis and lateral one of its
        head, m; roll, rad; lateral and vertical force of the wheel on the rail, Y and Q, N.
    contact
        Contact force and moment on each wheelset, (wheelsets, 6), N and N.m.
    fastener_force
        Vertical, (2, P), N, symmetric and antisymmetric class, compression positive.
    window_start
        Position of the window's rear end on the line, m.
    slide_count
        Shifts of the window since the start.
    slide_residual
        Largest deviation of the rails' vertical deflection over the common part of the old
        and the new window at the last shift, m.
    datum
        Height of the wheelsets above first touch at zero vertical displacement, m.
    static_heights
        Each wheelset's equilibrium height above the datum, (wheelsets,), m.
    places
        Places of the wheelsets in the window at the start, (wheelsets,), m.
    """

    __slots__ = ("layout", "vector")

    def __init__(self, layout: StateLayout, vector: np.ndarray) -> None:
        self.layout, self.vector = layout, vector

    time = _number(TIME)
    window_start = _number(WINDOW_START)
    slide_residual = _number(SHIFT_RESIDUAL)
    datum = _number(DATUM)
    static_heights = _array("static_heights")
    places = _array("places")
    motion = _array("motion_now")
    wheel_outputs = _array("outputs")
    contact = _array("wheelset")
    fastener_force = _array("fastener_force")
    rails = _array("lateral")
    rail_force = _array("rail_force")

    @property
    def wheels(self) -> Wheels:
        """Forces and rail motions at the wheels."""
        return Wheels(*(self.layout.view(self.vector, name) for name in Wheels._fields))

    def _field(self, symmetry: int) -> FieldState:
        rail, slab, compression = (
            self.layout.view(self.vector, name)[symmetry]
            for name in ("rail_fields", "slab_fields", "compression")
        )
        return FieldState(rail, slab[..., : self.layout.slab_modes[symmetry]], compression)

    @property
    def symmetric(self) -> FieldState:
        """Vertical coordinates of the symmetric class."""
        return self._field(0)

    @property
    def antisymmetric(self) -> FieldState:
        """Vertical coordinates of the antisymmetric class."""
        return self._field(1)

    @property
    def slide_count(self) -> int:
        """Shifts of the window since the start."""
        return int(self.vector[SHIFT_COUNT])

    @property
    def wheel_positions(self) -> np.ndarray:
        """Positions of the wheelsets on the line at :attr:`time`, (wheelsets,), m."""
        return self.layout.view(self.vector, "row")[:, 0]

    @property
    def normal_force(self) -> np.ndarray:
        """Normal force of each wheel, (wheelsets, 2), N, left first."""
        return self.layout.view(self.vector, "forces")[..., NORMAL_FORCE].sum(axis=2)

    @property
    def rail_deflection(self) -> np.ndarray:
        """Vertical displacement of the rails under the wheels, (wheelsets, 2), m."""
        return self.layout.view(self.vector, "rail")[:, :, 1]

    def replace(self, **changes: Any) -> "TrackState":
        """Return a state with some ``changes``: numbers, arrays or tuples of arrays by name."""
        changed = TrackState(self.layout, self.vector.copy())
        for name, value in changes.items():
            if name in _NUMBERS:
                changed.vector[_NUMBERS[name]] = value
                continue
            here = getattr(changed, name)
            pairs = zip(here, value, strict=True) if isinstance(here, tuple) else ((here, value),)
            for place, values in pairs:
                place[...] = values
        return changed


_NUMBERS = {
    "time": TIME,
    "window_start": WINDOW_START,
    "slide_count": SHIFT_COUNT,
    "slide_residual": SHIFT_RESIDUAL,
    "datum": DATUM,
}


def begin_motion(state: TrackState, time: float, motion: np.ndarray) -> None:
    """Write a single communication point into a new state: there is none before it."""
    arrays = state.layout.arrays(state.vector)
    arrays.head[[TIME, POINT_TIME]], arrays.head[PREVIOUS_TIME] = time, np.nan
    arrays.motion_now[:] = arrays.motion_before[:] = motion
    arrays.row[:, 0] = motion[:, 0]
    arrays.rates_seen[:] = np.any(motion[:, VELOCITY_COLUMNS] != 0.0, axis=0)
