"""The evaluation in compiled loops: irregularity and slope at any place, in any order.

:func:`evaluate_into` may be called from other numba functions. The random part
keeps the filtered samples that it last used, block by block; a block is a pure
function of its number, so what is kept changes the speed and never the result.
"""

import math
from typing import NamedTuple

import numpy as np
from rail_native import Array3, IndexMatrix, Indices, Matrix, Vector, kernel

from slab_track.core import core
from slab_track.irregularity.geometry import track_to_rails_in_place
from slab_track.irregularity.noise import stream_key, white

BLOCK = 32
"""Grid cells in a block of kept samples."""
STORED = BLOCK + 3
"""Samples that the cubic splines of a block's cells need."""
EMPTY = np.iinfo(np.int64).min
"""Number of the block in a slot that holds none."""
FARTHEST = 1e12
"""Largest distance (m); beyond, the result is not a number."""


class IrregularityData(NamedTuple):
    """What the compiled loops need; made by :class:`slab_track.irregularity.Irregularity`.

    Attributes
    ----------
    seed, start, ramp_length
        As in the parameters; without a ramp minus infinity and 1.
    inverse_spacing
        Grid points per metre of each band, shape (bands,), 1/m.
    layout
        First slot, number of slots (a power of 2), first tap and number of taps of
        each band, shape (bands, 4).
    filters
        Taps of all bands behind each other, shape (4 channels, taps), m.
    kept_blocks, kept_samples
        The kept blocks: their numbers, shape (slots,), and samples, shape
        (slots, STORED, 4 channels).
    noise
        Memory for the noise that a block is filtered from, shape (STORED + most taps - 1,).
    cosines
        Rows of position, length, depth, repeat distance, and weights on left
        vertical, left lateral, right vertical, right lateral, shape (cosines, 8).
    knots, knot_values
        The user's file: distances, shape (knots,), and value and slope of left
        vertical, left lateral, right vertical, right lateral, shape (knots, 4, 2).
    """

    seed: int
    start: float
    ramp_length: float
    inverse_spacing: Vector
    layout: IndexMatrix
    filters: Matrix
    kept_blocks: Indices
    kept_samples: Array3
    noise: Vector
    cosines: Matrix
    knots: Vector
    knot_values: Array3


@core.entry
def evaluate_into(x: Vector, data: IrregularityData, offsets: Array3, slopes: Array3) -> None:
    """Write the irregularity at the places ``x`` and its derivative along the line.

    Parameters
    ----------
    x : array (n,)
        Places along the line, m.
    data : IrregularityData
        See there.
    offsets, slopes : arrays (n, 2, 2), written
        [place, side, direction]: vertical down and lateral right, m and m/m.
    """
    for i in range(x.size):
        offset, slope = offsets[i], slopes[i]
        _fill(offset, 0.0)
        _fill(slope, 0.0)
        if not abs(x[i]) <= FARTHEST:
            _fill(offset, math.nan)
            _fill(slope, math.nan)
            continue
        if x[i] > data.start and (data.inverse_spacing.size > 0 or data.knots.size > 0):
            _add_random(x[i], data, offset, slope)
            track_to_rails_in_place(offset)
            track_to_rails_in_place(slope)
            _add_table(x[i], data.knots, data.knot_values, offset, slope)
            _fade_in((x[i] - data.start) / data.ramp_length, data.ramp_length, offset, slope)
        _add_cosines(x[i], data.cosines, offset, slope)


@kernel
def _fill(pair, value):
    for side in range(2):
        for direction in range(2):
            pair[side, direction] = value


@kernel
def _add_random(x, data, offset, slope):
    """Add the random level, alignment, cross-level and gauge."""
    for band in range(data.inverse_spacing.size):
        scale = data.inverse_spacing[band]
        position = x * scale
        cell = math.floor(position)
        t = position - cell
        index = int(cell)
        block = index >> 5  # 2**5 = BLOCK
        slot = data.layout[band, 0] + (block & (data.layout[band, 1] - 1))
        if data.kept_blocks[slot] != block:
            _filter_block(band, block, slot, data)
        samples = data.kept_samples[slot]
        first = index & (BLOCK - 1)
        r = 1.0 - t
        b0 = r * r * r / 6.0
        b1 = 2.0 / 3.0 - t * t * (1.0 - 0.5 * t)
        b2 = 2.0 / 3.0 - r * r * (1.0 - 0.5 * r)
        b3 = t * t * t / 6.0
        d0 = -0.5 * r * r * scale
        d1 = t * (1.5 * t - 2.0) * scale
        d2 = -r * (1.5 * r - 2.0) * scale
        d3 = 0.5 * t * t * scale
        for channel in range(4):
            y0, y1 = samples[first, channel], samples[first + 1, channel]
            y2, y3 = samples[first + 2, channel], samples[first + 3, channel]
            row, column = channel >> 1, channel & 1
            offset[row, column] += b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3
            slope[row, column] += d0 * y0 + d1 * y1 + d2 * y2 + d3 * y3


@kernel
def _filter_block(band, block, slot, data):
    """Filter the samples of a block: numbers BLOCK * block - 1 and on, into a slot."""
    first_tap, taps = data.layout[band, 2], data.layout[band, 3]
    first_number = BLOCK * block - 1 - (taps >> 1)
    for channel in range(4):
        key = stream_key(data.seed, band, channel)
        for i in range(STORED + taps - 1):
            data.noise[i] = white(key, first_number + i)
        for i in range(STORED):
            total = 0.0
            for tap in range(taps):
                total += data.filters[channel, first_tap + tap] * data.noise[i + tap]
            data.kept_samples[slot, i, channel] = total
    data.kept_blocks[slot] = block


@kernel
def _interval(knots, x):
    """Return the last knot at or before ``x``, which is not before the first one."""
    low, high = 0, knots.size
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@kernel
def _add_table(x, knots, knot_values, offset, slope):
    """Add the cubic Hermite interpolation of the user's file; zero beyond its knots."""
    if knots.size == 0 or not knots[0] <= x < knots[-1]:
        return
    k = _interval(knots, x)
    length = knots[k + 1] - knots[k]
    t = (x - knots[k]) / length
    r = 1.0 - t
    left, right = r * r * (1.0 + 2.0 * t), t * t * (1.0 + 2.0 * r)
    left_slope, right_slope = t * r * r * length, -t * t * r * length
    d_value = 6.0 * t * r / length
    d_left_slope, d_right_slope = r * (1.0 - 3.0 * t), t * (1.0 - 3.0 * r)
    for j in range(4):
        this, following = knot_values[k, j], knot_values[k + 1, j]
        row, column = j >> 1, j & 1
        offset[row, column] += (
            left * this[0]
            + right * following[0]
            + left_slope * this[1]
            + right_slope * following[1]
        )
        slope[row, column] += (
            d_value * (following[0] - this[0])
            + d_left_slope * this[1]
            + d_right_slope * following[1]
        )


@kernel
def _fade_in(t, length, offset, slope):
    """Multiply by a quintic ramp from 0 (t <= 0) to 1 (t >= 1) of a length (m)."""
    if t >= 1.0:
        return
    ramp = t * t * t * (10.0 + t * (6.0 * t - 15.0))
    gradient = 30.0 * (t * (1.0 - t)) ** 2 / length
    for row in range(2):
        for column in range(2):
            slope[row, column] = ramp * slope[row, column] + gradient * offset[row, column]
            offset[row, column] *= ramp


@kernel
def _add_cosines(x, cosines, offset, slope):
    """Add the dips ``depth / 2 * (1 + cos(2 pi (x - position) / length))``."""
    for i in range(cosines.shape[0]):
        position, length = cosines[i, 0], cosines[i, 1]
        depth, repeat = cosines[i, 2], cosines[i, 3]
        distance = x - position
        if repeat > 0.0 and distance > 0.5 * length:
            distance -= repeat * math.floor(distance / repeat + 0.5)
        if abs(distance) >= 0.5 * length:
            continue
        wavenumber = 2.0 * math.pi / length
        value = 0.5 * depth * (1.0 + math.cos(wavenumber * distance))
        gradient = -0.5 * depth * wavenumber * math.sin(wavenumber * distance)
        for j in range(4):
            weight = cosines[i, 4 + j]
            offset[j >> 1, j & 1] += weight * value
            slope[j >> 1, j & 1] += weight * gradient
