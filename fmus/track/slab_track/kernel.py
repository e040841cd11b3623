r"""Deflection of the rail per unit force as a function of distance.

With :math:`2\sin a\sin b = \cos(a-b)-\cos(a+b)` every sum over rail modes
between two points is a difference of one kernel,

.. math:: \sum_k w_k \sin\tfrac{k\pi x}{l}\sin\tfrac{k\pi x'}{l} = K(x-x') - K(x+x'),
          \quad K(\xi) = \tfrac12\sum_k w_k\cos\tfrac{k\pi\xi}{l},

the second term being the image behind the hinge. On a ring there is no image, and
:math:`\cos a\cos b+\sin a\sin b=\cos(a-b)` gives
:math:`K(\xi) = w_0 + \sum_k w_k\cos\tfrac{2k\pi\xi}{l}`. K is tabulated once per step
size. Fasteners are equidistant, and so are their images: a row of the table
holds the kernel for one place between two fasteners at all fasteners.
"""

import math

import numpy as np

from slab_track.compiled import entry, kernel, stream

PHASES = 256
"""Table points per fastener bay."""


def kernel_table(weights: np.ndarray, fastener_count: int, *, ring: bool = False) -> np.ndarray:
    """Tabulate K for the weights of the waves, shape (PHASES + 4, period in bays).

    Row 1 + j, column o holds K((j/PHASES - o) l_0); one row before and three after are
    added for the interpolation. The period is 2P, and P on a ring, whose weights are
    those of the constant, the first cosine, the first sine, and so on.
    """
    period = fastener_count if ring else 2 * fastener_count
    points = period * PHASES
    coefficients = np.concatenate([2.0 * weights[:1], weights[1::2]]) if ring else weights
    first = 0 if ring else 1
    if coefficients.size >= points // 2:
        raise ValueError("the table is too coarse for so many wave numbers")
    spectrum = np.zeros(points // 2 + 1)
    spectrum[first : coefficients.size + first] = coefficients
    # irfft gives (1/points) (c_0 + 2 sum c_k cos) for real coefficients.
    values = np.fft.irfft(spectrum, points) * ((0.5 if ring else 0.25) * points)
    row, column = np.arange(-1, PHASES + 3), np.arange(period)
    return values[(row[:, None] - PHASES * column) % points]


@kernel
def _weights(fraction, factor):
    """Cubic Lagrange weights at -1, 0, 1, 2 for a fraction in [0, 1), times a factor."""
    f = fraction
    return (
        factor * (-f * (f - 1.0) * (f - 2.0) / 6.0),
        factor * ((f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0),
        factor * (-(f + 1.0) * f * (f - 2.0) / 2.0),
        factor * ((f + 1.0) * f * (f - 1.0) / 6.0),
    )


@stream
def _add_line(table, row, weights, column, out):
    """Add the kernel between four rows, in neighbouring columns from ``column`` on."""
    w0, w1, w2, w3 = weights
    last = column + out.size
    t0, t1 = table[row, column:last], table[row + 1, column:last]
    t2, t3 = table[row + 2, column:last], table[row + 3, column:last]
    for i in range(out.size):
        out[i] += w0 * t0[i] + w1 * t1[i] + w2 * t2[i] + w3 * t3[i]


@entry
def to_fasteners(table, position, out):
    """Fill ``out`` (P,) with the response at all fasteners to a force at ``position``.

    ``position`` is in fastener bays from the window's start.
    """
    count, period = out.size, table.shape[1]
    place = position + 0.5
    bay = math.floor(place)
    phase = (place - bay) * PHASES
    row = int(phase)
    weights = _weights(phase - row, 1.0)
    if bay == 0 and period == count:
        bay = count
    for i in range(count):
        out[i] = 0.0
    # Fastener i is fraction - (i + 1 - bay) bays back.
    behind = min(max(bay - 1, 0), count)
    _add_line(table, row, weights, period - behind, out[:behind])
    _add_line(table, row, weights, behind + 1 - bay, out[behind:])
    if period > count:  # K is even: K(fraction + bay + i) = K(1 - fraction - (bay + i + 1)).
        phase = PHASES - phase
        row = int(phase)
        weights = _weights(phase - row, -1.0)
        before = min(period - bay - 1, count)
        _add_line(table, row, weights, bay + 1, out[:before])
        _add_line(table, row, weights, 0, out[before:])


@entry
def between(table, first, second, ring):
    """Response at ``second`` to a force at ``first``, both in bays from the window's start."""
    direct = _kernel(table, abs(first - second))
    if ring:
        return direct
    return direct - _kernel(table, first + second)


@kernel
def _kernel(table, distance):
    bay = math.floor(distance)
    phase = (distance - bay) * PHASES
    row = int(phase)
    w0, w1, w2, w3 = _weights(phase - row, 1.0)
    column = (-bay) % table.shape[1]
    return (
        w0 * table[row, column]
        + w1 * table[row + 1, column]
        + w2 * table[row + 2, column]
        + w3 * table[row + 3, column]
    )
