"""Where the window lies."""

import numpy as np

from slab_track.errors import TrackError
from slab_track.parameters import TrackParameters

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
