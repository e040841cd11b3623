"""The shift of the window in numpy: for maps that the kernels do not have, and for their tests."""

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.kernels.state import SHIFT_COUNT, SHIFT_RESIDUAL, WINDOW_START
from slab_track.lateral import LateralTrack
from slab_track.slide import SlideOperator, keep_under_wheels, sample_points, slide_rail
from slab_track.state import StateLayout, TrackState
from slab_track.waves import samples_per_bay


class WindowSlide:
    """Shifts the window of a track.

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
        waves = track.rail.waves
        bay = samples_per_bay(track.rail.wave_number.size, track.fastener_count)
        self._bay, self._slabs = bay, round(operator.shift / track.pitch)
        self._shapes = waves.shapes(sample_points(track.length, bay * track.fastener_count))

    def __call__(self, state: TrackState) -> TrackState:
        """Return the state after a shift.

        Displacement, velocity and acceleration of the rails move alike; slabs and fasteners move
        by whole rows, and so does what the truncated modes add to the fasteners' compression.
        """
        operator, new = self._operator, TrackState(state.layout, state.vector.copy())
        before, after = (one.layout.arrays(one.vector) for one in (state, new))
        rail, seats = self._track.rail, self._slabs * self._track.seat_count
        after.vertical.rail[:] = slide_rail(rail, operator, before.vertical.rail)
        bending = self._lateral.bending
        after.lateral[:, :, :2] = slide_rail(bending, operator, before.lateral[:, :, :2])
        twist = before.lateral[:, :, 2].reshape(6, -1)
        after.lateral[:, :, 2] = operator.deflection(twist).reshape(2, 3, -1)
        if operator.constrained:
            self._keep_under_wheels(state.motion[:, 0] - state.window_start, before, after)
        after.vertical.slab[:] = self._moved(before.vertical.slab, self._slabs, axis=2)
        after.vertical.compression[:] = self._moved(before.vertical.compression, seats, axis=2)
        force = self._moved(before.vertical.fastener_force, seats, axis=1)
        after.vertical.fastener_force[:] = force
        after.head[SHIFT_RESIDUAL] = self._settle(before, after, seats)
        after.head[WINDOW_START] += operator.shift
        after.head[SHIFT_COUNT] += 1.0
        return new

    def _moved(self, values: np.ndarray, count: int, axis: int) -> np.ndarray:
        """Move rows back; what is new is at rest, or comes back on a ring."""
        moved = np.roll(values, -count, axis)
        if not self._operator.ring:
            new = [slice(None)] * values.ndim
            new[axis] = slice(-count, None)
            moved[tuple(new)] = 0.0
        return moved

    def _keep_under_wheels(self, places: np.ndarray, before, after) -> None:
        """Give the rails under wheels at ``places`` (w,), m, their old motion back."""
        shift, track = self._operator.shift, self._track
        after.vertical.rail[:] = keep_under_wheels(
            track.rail, track.participation, places, shift, before.vertical.rail,
            after.vertical.rail,
        )  # fmt: skip
        bending = self._lateral.bending
        after.lateral[:, :, :2] = keep_under_wheels(
            bending, bending.deflection, places, shift, before.lateral[:, :, :2],
            after.lateral[:, :, :2],
        )  # fmt: skip

    def _settle(self, before, after, seats: int) -> float:
        """Add what a shift changes at the fasteners to their compression; return how much, m."""
        old, new = (
            np.sum(self._track.participation * of.vertical.rail[:, :2], axis=2) @ self._shapes
            for of in (before, after)
        )
        change = new - self._moved(old, seats * self._bay, axis=2)
        after.vertical.compression[:] += change[..., self._bay // 2 :: self._bay]
        common = change[:, 0, : change.shape[2] - seats * self._bay]
        of_rails = np.stack([common[0] - common[1], common[0] + common[1]])
        return float(np.sqrt(0.5) * np.max(np.abs(of_rails)))
