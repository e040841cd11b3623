"""What a slide of the window does to everything that has memory."""

import math

import numpy as np
import scipy.fft

from slab_track.assembly import LinearTrack
from slab_track.branches import amplitudes, make_branches, separate
from slab_track.compiled import entry
from slab_track.lateral import LateralTrack
from slab_track.oscillators import copy
from slab_track.slide import SlideOperator, keep_under_wheels, sample_points
from slab_track.state import (
    COMPRESSION_A,
    COMPRESSION_S,
    FASTENER_FORCE,
    LATERAL,
    RAIL_A,
    RAIL_S,
    SLAB_A,
    SLAB_S,
    SLIDE_COUNT,
    SLIDE_RESIDUAL,
    WINDOW_START,
    StateLayout,
    TrackState,
)
from slab_track.waves import samples_per_bay

_SQRT_HALF = math.sqrt(0.5)


class WindowSlide:
    """Slides the window of a track.

    Parameters
    ----------
    track, lateral
        Its vertical, and its lateral and torsional motion.
    operator
        What moves the waves of the rails.
    layout
        Of the states.
    """

    def __init__(
        self,
        track: LinearTrack,
        lateral: LateralTrack,
        operator: SlideOperator,
        layout: StateLayout,
    ) -> None:
        self._track, self._lateral, self._operator = track, lateral, operator
        self._branches, self._aside = make_branches(track.rail), make_branches(lateral.bending)
        slabs = round(operator.shift / track.pitch)
        seats = slabs * track.seat_count
        self._moving = _moving_rows(layout, slabs, seats)
        waves = track.rail.waves
        self._bay = samples_per_bay(waves.wave_number.size, track.fastener_count)
        self._points, points = self._bay * seats, self._bay * track.fastener_count
        self._shapes = waves.shapes(sample_points(track.length, points)) if waves.ring else None
        self._z = np.empty((18, operator.deflection.room[0]))
        self._psi = np.empty((12, operator.rotation.room[0]))
        self._weighed = np.empty((8, waves.wave_number.size if waves.ring else points))

    def __call__(self, state: TrackState) -> TrackState:
        """Return the state after a slide.

        Displacement, velocity and acceleration of the rails move alike; slabs and fasteners move
        by whole rows, and so does what the modes left out add to the fasteners' compression.
        """
        old, operator, view = state.vector, self._operator, state.layout.view
        new, wheels = np.empty(old.size), state.layout.starts[FASTENER_FORCE]
        new[:wheels] = old[:wheels]  # what comes behind all moves
        before = tuple(view(old, part) for part in (RAIL_S, RAIL_A, LATERAL))
        after = tuple(view(new, part) for part in (RAIL_S, RAIL_A, LATERAL))
        first = operator.rotation.room[1]
        _gather(*before, self._branches, self._aside, first, self._z, self._psi)
        z, psi = operator.deflection.move(self._z), operator.rotation.move(self._psi)
        _scatter(z, psi, first, self._branches, self._aside, *after)
        if operator.constrained:
            self._keep_under_wheels(state.motion[:, 0] - state.window_start, before, after)
        _move_rows(old, new, self._moving, operator.ring)
        field = self._vertical_motion(*before[:2], *after[:2])
        compression = view(new, COMPRESSION_S), view(new, COMPRESSION_A)
        new[SLIDE_RESIDUAL] = _settle(field, self._points, self._bay, operator.ring, *compression)
        new[WINDOW_START] += operator.shift
        new[SLIDE_COUNT] += 1.0
        return TrackState(state.layout, new)

    def _keep_under_wheels(
        self, places: np.ndarray, before: tuple[np.ndarray, ...], after: tuple[np.ndarray, ...]
    ) -> None:
        """Give the rails under wheels at ``places`` (w,), m, their old motion back."""
        own = self._track.rail, self._track.participation
        aside = self._lateral.bending, self._lateral.bending.deflection
        for (modes, weight), old, new in zip((own, own, aside), before, after, strict=True):
            new[..., :2, :] = keep_under_wheels(
                modes, weight, places, self._operator.shift, old[..., :2, :], new[..., :2, :]
            )

    def _vertical_motion(self, *rails: np.ndarray) -> np.ndarray:
        """Return twice displacement, m, and velocity, m/s, of ``rails`` at the sample points.

        Four times two rows: both classes before, and both after the slide.
        """
        rows = self._weighed
        _weigh(self._track.participation, *rails, rows)
        if self._shapes is None:
            return np.asarray(scipy.fft.dst(rows, type=3, axis=1, overwrite_x=True))
        return 2.0 * rows @ self._shapes


def _moving_rows(layout: StateLayout, slabs: int, seats: int) -> np.ndarray:
    """Return what moves by whole slabs and fasteners: first number, rows, length, way; (5, 4)."""
    table = []
    for part in (SLAB_S, SLAB_A, FASTENER_FORCE, COMPRESSION_S, COMPRESSION_A):
        rows, *shape = layout.shapes[part]
        of_slabs = len(shape) == 2
        way = slabs * shape[1] if of_slabs else seats
        table.append((layout.starts[part], rows, math.prod(shape), way))
    return np.array(table, dtype=np.int64)


@entry
def _gather(symmetric, antisymmetric, aside, own, other, first, z, psi):
    """Fill in the waves of deflection, twist and rotation of all rails.

    Parameters
    ----------
    symmetric, antisymmetric, aside
        Coordinates, (3, 2, N) and (2, 3, 3, N).
    own, other
        Branches of the vertical and of the lateral motion.
    first
        Where in their rows the waves of rotation begin; the rest is filled up with zeros.
    z, psi
        Receive deflections of both classes and both rails aside, and their twists, (18, n); and
        rotations, (12, n).
    """
    vertical = symmetric, antisymmetric
    count = aside.shape[3]
    last = first + count
    z[:, count:], psi[:, :first], psi[:, last:] = 0.0, 0.0, 0.0
    for turn in range(2):
        for row in range(3):
            here, there = 3 * turn + row, 6 + 3 * turn + row
            amplitudes(own.deflection, vertical[turn][row], z[here, :count])
            amplitudes(own.rotation, vertical[turn][row], psi[here, first:last])
            amplitudes(other.deflection, aside[turn, row], z[there, :count])
            amplitudes(other.rotation, aside[turn, row], psi[there, first:last])
            copy(aside[turn, row, 2], z[there + 6, :count])


@entry
def _scatter(z, psi, first, own, other, symmetric, antisymmetric, aside):
    """Fill in the coordinates of all rails from their waves, as in :func:`_gather`."""
    vertical = symmetric, antisymmetric
    count = aside.shape[3]
    last = first + count
    for turn in range(2):
        for row in range(3):
            here, there = 3 * turn + row, 6 + 3 * turn + row
            turned = psi[here, first:last], psi[there, first:last]
            separate(own, z[here, :count], turned[0], vertical[turn][row])
            separate(other, z[there, :count], turned[1], aside[turn, row])
            copy(z[there + 6, :count], aside[turn, row, 2])


@entry
def _move_rows(old, new, moving, ring):
    """Move rows back by their ways; what is new is at rest, or comes back on a ring."""
    for part in range(moving.shape[0]):
        first, rows, length, way = moving[part]
        for row in range(rows):
            begin = first + row * length
            for i in range(length):
                there = i + way
                if there < length:
                    new[begin + i] = old[begin + there]
                else:
                    new[begin + i] = old[begin + there - length] if ring else 0.0


@entry
def _weigh(weight, symmetric_before, antisymmetric_before, symmetric, antisymmetric, waves):
    """Fill in the waves (8, N or more) of displacement and velocity before and after a slide."""
    rails = symmetric_before, antisymmetric_before, symmetric, antisymmetric
    count = weight.shape[1]
    waves[:, count:] = 0.0
    for turn in range(4):
        for row in range(2):
            amplitudes(weight, rails[turn][row], waves[2 * turn + row, :count])


@entry
def _settle(field, points, bay, ring, symmetric, antisymmetric):
    """Add what a slide changes at the fasteners to their compression; return its residual, m.

    Parameters
    ----------
    field
        What :meth:`WindowSlide._vertical_motion` returns, (8, M).
    points, bay
        Sample points that the window moves by, and in a bay.
    symmetric, antisymmetric
        Compression of the fasteners, m, and its rate, (2, P).
    """
    count, compression = field.shape[1], (symmetric, antisymmetric)
    for fastener in range(symmetric.shape[1]):
        here = fastener * bay + bay // 2
        there = here + points
        if ring:
            there %= count
        for turn in range(2):
            for row in range(2):
                change = field[4 + 2 * turn + row, here]
                if there < count:
                    change -= field[2 * turn + row, there]
                compression[turn][row, fastener] += 0.5 * change
    largest = 0.0
    for i in range(count - points):
        even, odd = field[4, i] - field[0, i + points], field[6, i] - field[2, i + points]
        largest = max(largest, abs(even - odd), abs(even + odd))
    return 0.5 * _SQRT_HALF * largest
