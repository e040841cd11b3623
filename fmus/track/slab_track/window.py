"""Where the window lies, and what its slide does to everything that has memory."""

from typing import Any

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.errors import TrackError
from slab_track.lateral import LateralTrack
from slab_track.parameters import TrackParameters
from slab_track.slide import SlideOperator, slide_rail
from slab_track.vertical import FieldState

END_MARGIN = 3.0
"""Nearest that a wheel may come to an end of the window, m; there the hinge is felt."""


def place_window(p: TrackParameters, positions: np.ndarray) -> float:
    """Return the window's start for wheelsets at ``positions`` (wheelsets,), m.

    Slabs lie at whole multiples of the pitch on the line. The wheels are as far
    from both ends as they can be at the worst instant between two slides; with
    ``moving_mass`` they start 15 m from the rear end or a pitch more.

    Raises
    ------
    TrackError
        If the wheelsets do not fit.
    """
    rear, front = float(np.min(positions)), float(np.max(positions))
    spare = p.window_length - (front - rear) - p.pitch
    if spare < 2.0 * END_MARGIN:
        raise TrackError(
            f"the wheelsets stand {front - rear:g} m apart, but a window of "
            f"{p.window_length:g} m takes at most "
            f"{p.window_length - p.pitch - 2.0 * END_MARGIN:g} m; "
            "raise window.slab_count"
        )
    margin = 0.5 * spare if p.moves else min(0.5 * spare, 15.0)
    return float(np.floor((rear - margin) / p.pitch) * p.pitch)


def check_margins(p: TrackParameters, start: float, time: float, x: np.ndarray) -> None:
    """Raise :class:`TrackError` if a wheel at ``x`` (any shape, m) comes too near to an end."""
    rear, front, end = float(x.min()), float(x.max()), start + p.window_length
    if rear < start + END_MARGIN or front > end - END_MARGIN:
        wheel = front if front > end - END_MARGIN else rear
        raise TrackError(
            f"at t = {time:g} s a wheel at {wheel:g} m comes within {END_MARGIN:g} m of the ends "
            f"of the window, {start:g} m to {end:g} m (window.method = {p.window.method}); "
            "take window.method = sliding for a long run, or raise window.slab_count"
        )


def slide_fields(
    track: LinearTrack, lateral: LateralTrack, operator: SlideOperator, state: Any
) -> tuple[dict[str, Any], float]:
    """Return the fields of a track state moved by one pitch, and the residual in m.

    Displacement, velocity and acceleration move alike; slabs, fastener forces and
    residual compressions move by whole rows.
    """
    changes: dict[str, Any] = {
        name: _slide_field(track, operator, getattr(state, name))
        for name in ("symmetric", "antisymmetric")
    }
    rails = np.empty_like(state.rails)
    for side, derivative in np.ndindex(2, 3):
        old = state.rails[side, derivative]
        rails[side, derivative, :2] = slide_rail(lateral.bending, operator, old[:2])
        rails[side, derivative, 2] = operator.deflection @ old[2]
    changes["rails"] = rails
    changes["fastener_force"] = operator.rows(state.fastener_force, track.seat_count)
    old = [state.symmetric.rail[0], state.antisymmetric.rail[0]]
    new = [changes["symmetric"].rail[0], changes["antisymmetric"].rail[0]]
    return changes, _residual(track, old, new)


def _slide_field(track: LinearTrack, operator: SlideOperator, field: FieldState) -> FieldState:
    return FieldState(
        rail=np.array([slide_rail(track.rail, operator, level) for level in field.rail]),
        slab=np.array([operator.rows(level, 1) for level in field.slab]),
        residual=np.ascontiguousarray(operator.rows(field.residual.T, track.seat_count).T),
    )


def _residual(track: LinearTrack, old: list[np.ndarray], new: list[np.ndarray]) -> float:
    """Largest change of either rail's deflection over the common part of the windows."""
    pitch = track.length / track.slab_count
    points = np.arange(pitch, track.length, 0.5 * track.length / track.fastener_count)
    before, after = track.wave_shapes(points), track.wave_shapes(points - pitch)
    weight = track.rail.deflection
    jumps = [
        np.sum(weight * b, axis=0) @ after - np.sum(weight * a, axis=0) @ before
        for a, b in zip(old, new, strict=True)
    ]
    rails = np.sqrt(0.5) * np.array([jumps[0] - jumps[1], jumps[0] + jumps[1]])
    return float(np.max(np.abs(rails)))
