"""Shapes of the rails' waves under the wheels."""

import math

import numpy as np

from slab_track.compiled import kernel, stream

_LANES = 8
_BACK, _TWICE_BACK = np.uint64(_LANES), np.uint64(2 * _LANES)


@kernel
def wheel_shapes(wave_number, positions, shapes):
    """Fill the waves' shapes at every wheel, (wheels, N), by recurrence in k.

    The first wave number is 0 on a ring, which has cosines and sines in turn. Eight rows
    ahead the angle has grown by a constant, so f(k+8) = 2 cos f(k) - f(k-8).
    """
    count = wave_number.size
    first = 1 if wave_number[0] == 0.0 else 0
    start = min(2 * _LANES + first, count)
    for wheel in range(positions.size):
        row, angle = shapes[wheel], wave_number[first] * positions[wheel]
        cosine, sine = math.cos(angle), math.sin(angle)
        c, s, twice = cosine, sine, 0.0
        if first == 1:
            row[0] = 1.0
        for k in range(first, start):
            if first == 0:
                row[k] = s
                turn = True
            else:
                row[k] = c if k % 2 == 1 else s
                turn = k % 2 == 0
            if k - first == _LANES - 1:
                twice = 2.0 * c
            if turn:
                c, s = c * cosine - s * sine, s * cosine + c * sine
        _go_on(twice, np.uint64(start), row)


@stream
def _go_on(twice, start, row):
    """Fill the rest of a row; unsigned places are never negative, so vectors can be used."""
    for k in range(start, np.uint64(row.size)):
        row[k] = twice * row[k - _BACK] - row[k - _TWICE_BACK]
