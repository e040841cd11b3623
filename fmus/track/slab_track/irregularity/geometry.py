"""Irregularity of the two rails from the four kinds of irregularity, and back.

Track frame: y to the right, z down. Arrays of the rails have the last two axes
(side, direction) with side 0 left and 1 right, direction 0 vertical (down
positive) and 1 lateral (right positive). The four kinds are

- level: mean of both rails' vertical positions, down positive;
- alignment: mean of both rails' lateral positions, right positive;
- cross-level: right rail's vertical position less the left one's, so positive
  when the right rail is lower, as a positive roll about x makes it;
- gauge: right rail's lateral position less the left one's, positive when wide.
"""

import numpy as np
from numpy.typing import ArrayLike
from rail_native import kernel

from slab_track.irregularity.spectra import FloatArray


@kernel
def track_to_rails_in_place(values):
    """Turn (level, alignment, cross-level, gauge) into rails' values, one (2, 2) array."""
    level, alignment = values[0, 0], values[0, 1]
    half_cross_level, half_gauge = 0.5 * values[1, 0], 0.5 * values[1, 1]
    values[0, 0] = level - half_cross_level
    values[0, 1] = alignment - half_gauge
    values[1, 0] = level + half_cross_level
    values[1, 1] = alignment + half_gauge


def rails_from_track(track: ArrayLike) -> FloatArray:
    """Return the rails' irregularity, shape (..., 2, 2), of the four kinds, shape (..., 4).

    Works on offsets (m) and on slopes alike.
    """
    level, alignment, cross_level, gauge = np.moveaxis(np.asarray(track, dtype=float), -1, 0)
    rails = np.empty((*level.shape, 2, 2))
    for side, sign in ((0, -0.5), (1, 0.5)):
        rails[..., side, 0] = level + sign * cross_level
        rails[..., side, 1] = alignment + sign * gauge
    return rails


def track_from_rails(rails: ArrayLike) -> FloatArray:
    """Return level, alignment, cross-level and gauge, shape (..., 4), of (..., 2, 2)."""
    values = np.asarray(rails, dtype=float)
    left, right = values[..., 0, :], values[..., 1, :]
    return np.concatenate(((left + right) / 2, right - left), axis=-1)
