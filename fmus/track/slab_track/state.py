"""What the track remembers: one vector of numbers, and its parts by name.

A step makes a new vector from an old one; so a state never changes once it is made, and saving
it is keeping one array. The parts are views.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from slab_track.contact.wheelset import FORCED, LOCATED, NORMAL_FORCE
from slab_track.motion import MOTION, VELOCITY_COLUMNS

ANSWERS = 10
"""Rows of what happens at the wheels, see :attr:`TrackState.answers`."""

(
    TIME,
    POINT_TIME,
    PREVIOUS_TIME,
    WINDOW_START,
    SLIDE_COUNT,
    SLIDE_RESIDUAL,
    DATUM,
) = range(7)
"""Places of the single numbers at the head of the vector."""

_HEAD = 7

(
    STATIC_HEIGHTS,
    PLACES,
    MOTION_NOW,
    MOTION_BEFORE,
    RATES_SEEN,
    ROW,
    RAIL_FORCE,
    EARLIER_FORCE,
    NORMAL,
    CREEP,
    RAIL,
    LOCATED_PATCHES,
    PATCH_FORCES,
    WHEELSET,
    ANSWER,
    FASTENER_FORCE,
    RAIL_S,
    SLAB_S,
    COMPRESSION_S,
    RAIL_A,
    SLAB_A,
    COMPRESSION_A,
    LATERAL,
) = range(23)
"""Numbers of the parts that are arrays, in their order in the vector.

What is given to the partner, WHEELSET and ANSWER, lies side by side."""


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


class WheelState(NamedTuple):
    """What happens at the wheels; left first.

    Attributes
    ----------
    rail_force, earlier_force
        Force on the rail's axis: lateral, vertical, roll moment, (wheels, 2, 3); that of an
        internal step before.
    normal, creep
        Normal and lateral creep force of the patches (tread, flange), (wheels, 2, 2), N.
    rail
        Motion of the rail's axis: y, z, roll and rates, (wheels, 2, 6).
    wheelset
        Contact force and moment on each wheelset, (wheels, 6).
    located, forces
        Patches, columns as in :mod:`slab_track.contact.wheelset`.
    """

    rail_force: np.ndarray
    earlier_force: np.ndarray
    normal: np.ndarray
    creep: np.ndarray
    rail: np.ndarray
    wheelset: np.ndarray
    located: np.ndarray
    forces: np.ndarray

    @classmethod
    def empty(cls, wheels: int) -> "WheelState":
        """Return wheels without any force."""
        return cls(
            rail_force=np.zeros((wheels, 2, 3)),
            earlier_force=np.zeros((wheels, 2, 3)),
            normal=np.zeros((wheels, 2, 2)),
            creep=np.zeros((wheels, 2, 2)),
            rail=np.zeros((wheels, 2, 6)),
            wheelset=np.zeros((wheels, 6)),
            located=np.zeros((wheels, 2, 2, LOCATED)),
            forces=np.zeros((wheels, 2, 2, FORCED)),
        )


class StateLayout:
    """Where the parts of a state lie in its vector.

    Attributes
    ----------
    shapes
        Of the arrays, by their numbers.
    starts
        Of the arrays in the vector, and its end, shape (arrays + 1,).
    """

    def __init__(
        self, *, wheelsets: int, waves: int, fasteners: int, slabs: int, slab_modes: Sequence[int]
    ) -> None:
        w = wheelsets
        fields = [
            shape
            for count in slab_modes
            for shape in ((3, 2, waves), (3, slabs, count), (2, fasteners))
        ]
        self.shapes: tuple[tuple[int, ...], ...] = (
            (w,),
            (w,),
            (w, len(MOTION)),
            (w, len(MOTION)),
            (5,),
            (w, len(MOTION)),
            (w, 2, 3),
            (w, 2, 3),
            (w, 2, 2),
            (w, 2, 2),
            (w, 2, 6),
            (w, 2, 2, LOCATED),
            (w, 2, 2, FORCED),
            (w, 6),
            (ANSWERS, w, 2),
            (2, fasteners),
            *fields,
            (2, 3, 3, waves),
        )
        sizes = [math.prod(shape) for shape in self.shapes]
        self.starts = np.cumsum([_HEAD, *sizes])

    @property
    def size(self) -> int:
        """Length of the vector."""
        return int(self.starts[-1])

    def places(self, part: int) -> np.ndarray:
        """Return the places of an array's numbers in the vector, in the array's shape."""
        return np.arange(*self.starts[part : part + 2]).reshape(self.shapes[part])

    def view(self, vector: np.ndarray, part: int) -> np.ndarray:
        """Return an array of the state as a view of its vector."""
        return vector[self.starts[part] : self.starts[part + 1]].reshape(self.shapes[part])


def _number(place: int) -> Any:
    return property(lambda self: float(self.vector[place]))


def _array(part: int) -> Any:
    return property(lambda self: self.layout.view(self.vector, part))


def _arrays(kind: Any, parts: tuple[int, ...]) -> Any:
    return property(lambda self: kind(*(self.layout.view(self.vector, part) for part in parts)))


_WHEEL_PARTS = (
    RAIL_FORCE,
    EARLIER_FORCE,
    NORMAL,
    CREEP,
    RAIL,
    WHEELSET,
    LOCATED_PATCHES,
    PATCH_FORCES,
)


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
    answers
        What happens at the wheels, (ANSWERS, wheelsets, 2), left first. Rows: normal,
        longitudinal and lateral creep force, N; penetration, m, and contact angle, rad, of the
        patch that carries most; vertical displacement of the rail's axis and lateral one of its
        head, m; roll, rad; lateral (guiding) and vertical force of the wheel on the rail, N.
    contact
        Contact force and moment on each wheelset, (wheelsets, 6), N and N.m.
    fastener_force
        Vertical, (2, P), N, symmetric and antisymmetric class, compression positive.
    window_start
        Position of the window's rear end on the line, m.
    slide_count
        Slides since the start.
    slide_residual
        Largest deviation of the rails' vertical deflection over the common part of the old
        and the new window at the last slide, m.
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
    slide_residual = _number(SLIDE_RESIDUAL)
    datum = _number(DATUM)
    static_heights = _array(STATIC_HEIGHTS)
    places = _array(PLACES)
    motion = _array(MOTION_NOW)
    answers = _array(ANSWER)
    contact = _array(WHEELSET)
    fastener_force = _array(FASTENER_FORCE)
    rails = _array(LATERAL)
    symmetric = _arrays(FieldState, (RAIL_S, SLAB_S, COMPRESSION_S))
    antisymmetric = _arrays(FieldState, (RAIL_A, SLAB_A, COMPRESSION_A))
    wheels = _arrays(WheelState, _WHEEL_PARTS)

    @property
    def slide_count(self) -> int:
        """Slides since the start."""
        return int(self.vector[SLIDE_COUNT])

    @property
    def rail_force(self) -> np.ndarray:
        """Force of the wheels on the rails' axes: lateral, vertical, roll moment, (w, 2, 3)."""
        return self.layout.view(self.vector, RAIL_FORCE)

    @property
    def wheel_positions(self) -> np.ndarray:
        """Positions of the wheelsets on the line at :attr:`time`, (wheelsets,), m."""
        return self.layout.view(self.vector, ROW)[:, 0]

    @property
    def normal_force(self) -> np.ndarray:
        """Normal force of each wheel, (wheelsets, 2), N, left first."""
        return self.layout.view(self.vector, PATCH_FORCES)[..., NORMAL_FORCE].sum(axis=2)

    @property
    def rail_deflection(self) -> np.ndarray:
        """Vertical displacement of the rails under the wheels, (wheelsets, 2), m."""
        return self.layout.view(self.vector, RAIL)[:, :, 1]

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
    "slide_count": SLIDE_COUNT,
    "slide_residual": SLIDE_RESIDUAL,
    "datum": DATUM,
}


def begin_motion(state: TrackState, time: float, motion: np.ndarray) -> None:
    """Write a single communication point into a new state: there is none before it."""
    vector, view = state.vector, state.layout.view
    vector[[TIME, POINT_TIME]], vector[PREVIOUS_TIME] = time, np.nan
    view(vector, MOTION_NOW)[:] = view(vector, MOTION_BEFORE)[:] = motion
    view(vector, ROW)[:, 0] = motion[:, 0]
    view(vector, RATES_SEEN)[:] = np.any(motion[:, VELOCITY_COLUMNS] != 0.0, axis=0)
