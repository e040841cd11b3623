"""Where the window lies, and what its slide does to everything that has memory."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.errors import TrackError
from slab_track.lateral import LateralTrack
from slab_track.parameters import TrackParameters
from slab_track.rail import RailModes
from slab_track.slide import SlideOperator, both_branches, keep_under_wheels, slide_rails
from slab_track.state import FieldState

END_MARGIN = 3.0
"""Nearest that a wheel may come to an end of the window, m; there the hinge is felt."""


def place_window(p: TrackParameters, positions: np.ndarray) -> float:
    """Return the window's start for wheelsets at ``positions`` (wheelsets,), m.

    Slabs lie at whole multiples of the pitch on the line. In a window that follows them the
    wheels are as far from both ends as they can be at the worst instant between two slides, but
    for ``window.vehicle_offset``. With ``moving_irregularity`` they stand in the middle, with
    ``moving_mass`` 15 m from the rear end or a pitch more.

    Raises
    ------
    TrackError
        If the wheelsets do not fit.
    """
    rear, front = float(np.min(positions)), float(np.max(positions))
    spare = p.window_length - (front - rear) - p.slide_length
    offset = p.window.vehicle_offset if p.moves else 0.0
    if spare < 2.0 * (END_MARGIN + abs(offset)):
        longest = p.window_length - p.slide_length - 2.0 * (END_MARGIN + abs(offset))
        raise TrackError(
            f"the wheelsets stand {front - rear:g} m apart, but a window of "
            f"{p.window_length:g} m takes at most {longest:g} m; raise window.slab_count"
            + (" or reduce window.vehicle_offset" if offset else "")
        )
    if p.window.method == "moving_irregularity":
        return float(np.rint((rear - 0.5 * (spare + p.slide_length)) / p.pitch) * p.pitch)
    if not p.moves:
        return float(np.floor((rear - min(0.5 * spare, 15.0)) / p.pitch) * p.pitch)
    # A nanometre on: wheels that come to the place of a slide exactly must not be left to rounding.
    return float(np.floor((rear - 0.5 * spare - offset + 1e-9) / p.slide_length) * p.slide_length)


def near_the_end(p: TrackParameters, start: float, time: float, x: np.ndarray) -> str:
    """Say that a wheel at ``x`` (any shape, m) comes too near to an end of the window."""
    rear, front, end = float(x.min()), float(x.max()), start + p.window_length
    wheel = front if front > end - END_MARGIN else rear
    return (
        f"at t = {time:g} s a wheel at {wheel:g} m comes within {END_MARGIN:g} m of the ends "
        f"of the window, {start:g} m to {end:g} m (window.method = {p.window.method}); "
        "take window.method = sliding for a long run, or raise window.slab_count"
    )


def slide_fields(
    track: LinearTrack, lateral: LateralTrack, operator: SlideOperator, state: Any
) -> tuple[dict[str, Any], float]:
    """Return the fields of a track state moved by one slide, and the residual in m.

    Displacement, velocity and acceleration move alike; slabs, fastener forces and
    what the modes left out add to the fasteners' compression move by whole rows.
    """
    slabs = round(operator.shift / track.pitch)
    seats = slabs * track.seat_count
    places = state.motion[:, 0] - state.window_start

    def kept(modes: RailModes, weight: np.ndarray, old: np.ndarray, new: np.ndarray) -> np.ndarray:
        if not operator.constrained:
            return new
        return keep_under_wheels(modes, weight, places, operator.shift, old, new)

    bending = lateral.bending
    old = np.stack([state.symmetric.rail, state.antisymmetric.rail])
    aside = state.rails[:, :, :2]
    (new, new_aside), (turned,) = slide_rails(
        operator, [(track.rail, old), (bending, aside)], [state.rails[:, :, 2]]
    )
    new = kept(track.rail, track.participation, old, new)
    fields = (state.symmetric, state.antisymmetric)
    left_out = np.stack([field.compression for field in fields])
    left_out -= modal_parts(track, old, [field.slab for field in fields])
    left_out = operator.rows(left_out.T, seats).T
    slabs_moved = [
        np.ascontiguousarray(operator.rows(field.slab.swapaxes(0, 1), slabs).swapaxes(0, 1))
        for field in fields
    ]
    compression = left_out + modal_parts(track, new, slabs_moved)
    changes: dict[str, Any] = {
        name: FieldState(new[i], slabs_moved[i], compression[i])
        for i, name in enumerate(("symmetric", "antisymmetric"))
    }
    rails = np.empty_like(state.rails)
    rails[:, :, :2] = kept(bending, bending.deflection, aside, new_aside)
    rails[:, :, 2] = turned
    changes["rails"] = rails
    changes["fastener_force"] = np.ascontiguousarray(operator.rows(state.fastener_force.T, seats).T)
    return changes, _residual(track, operator, old[:, 0], new[:, 0])


def modal_parts(track: LinearTrack, rails: np.ndarray, slabs: Sequence[np.ndarray]) -> np.ndarray:
    """Return the fasteners' compression by the modes, m, and its rate, for both symmetries.

    Parameters
    ----------
    rails
        Modal coordinates of both symmetries, (2, 2 or more, 2, N).
    slabs
        Of the slabs, for each symmetry (2 or more, slabs, modes).

    Returns
    -------
    ndarray
        Shape (2, 2, P).
    """
    waves = both_branches(track.participation, rails[:, :2]).reshape(4, -1) * track.fold_sign
    count = track.fastener_count
    sums = np.array([np.bincount(track.fold_index, row, count) for row in waves])
    under = [
        (slab[:2] @ system.seats).reshape(2, -1)
        for slab, system in zip(slabs, track.slabs, strict=True)
    ]
    return (sums @ track.fastener_sines).reshape(2, 2, -1) - np.stack(under)


def _residual(
    track: LinearTrack, operator: SlideOperator, old: np.ndarray, new: np.ndarray
) -> float:
    """Largest change of either rail's deflection over the common part of the windows."""
    weight = track.participation
    jump = both_branches(weight, new) @ operator.after
    jump -= both_branches(weight, old) @ operator.before
    rails = np.sqrt(0.5) * np.array([jump[0] - jump[1], jump[0] + jump[1]])
    return float(np.max(np.abs(rails)))
