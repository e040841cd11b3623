"""A measured irregularity as a smooth function of distance that fades out beyond its ends."""

import numpy as np
from scipy.interpolate import CubicSpline

from slab_track.irregularity.files import RAIL_COLUMNS
from slab_track.irregularity.geometry import rails_from_track
from slab_track.irregularity.spectra import CHANNELS, FloatArray

_SLOPE_INTERVALS = 4.0
"""Intervals of the file over which the slope at its end fades out."""


def rails_of_columns(columns: dict[str, FloatArray]) -> FloatArray:
    """Return the rails' irregularity, shape (rows, 4), flattened (side, direction), m.

    What the file does not give is zero.
    """
    zero = np.zeros_like(columns["distance"])
    track = np.stack([columns.get(name, zero) for name in CHANNELS], axis=-1)
    rails = np.stack([columns.get(name, zero) for name in RAIL_COLUMNS], axis=-1)
    return rails + rails_from_track(track).reshape(-1, 4)


def knots_of_columns(
    columns: dict[str, FloatArray], position: float, fade_length: float
) -> tuple[FloatArray, FloatArray]:
    """Return knots along the line (n,), m, and value and slope of the rails there, (n, 4, 2).

    Inside the file a cubic spline (two continuous derivatives) goes through its
    values; the cubic Hermite interpolation of the knots is that spline. Beyond each
    end, value and slope go to zero without jump: the value over ``fade_length``, the
    slope over four intervals of the file at most, so that it does not lead far away.
    """
    distance = columns["distance"] + position
    values = rails_of_columns(columns)
    slopes = CubicSpline(distance, values, axis=0)(distance, 1)
    inside = np.stack((values, slopes), axis=-1)
    interval = np.diff(distance)[[0, -1]]
    before, before_values = _tail(inside[0], -interval[0], -fade_length)
    after, after_values = _tail(inside[-1], interval[-1], fade_length)
    knots = np.concatenate((distance[0] + before[::-1], distance, distance[-1] + after))
    return knots, np.concatenate((before_values[::-1], inside, after_values))


def _tail(end: FloatArray, interval: float, fade: float) -> tuple[FloatArray, FloatArray]:
    """Return knots (distance from the end, outwards) and values beyond one end.

    ``end`` holds value and slope, shape (4, 2); interval and fade are signed.
    """
    nothing = np.zeros_like(end)
    slope_fade = _SLOPE_INTERVALS * interval
    if abs(slope_fade) >= abs(fade):
        return np.array([fade]), nothing[None]
    t = slope_fade / fade
    value = end[:, 0] * (1 - t) ** 2 * (1 + 2 * t)
    slope = end[:, 0] * -6 * t * (1 - t) / fade
    return np.array([slope_fade, fade]), np.stack((np.stack((value, slope), axis=-1), nothing))
