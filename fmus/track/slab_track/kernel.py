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
def _weights(fraction):
    """Cubic Lagrange weights at -1, 0, 1, 2 for a fraction in [0, 1)."""
    f = fraction
    return (
        -f * (f - 1.0) * (f - 2.0) / 6.0,
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
        -(f + 1.0) * f * (f - 2.0) / 2.0,
        (f + 1.0) * f * (f - 1.0) / 6.0,
    )


@stream
def _add_line(table, row, w0, w1, w2, w3, column, first, last, out):
    """Add the kernel between four rows to ``out`` from ``first`` to ``last``.

    The columns of the table are neighbours too, the first one is ``column``.
    """
    shift = column - first
    for i in range(first, last):
        out[i] += (
            w0 * table[row, shift + i]
            + w1 * table[row + 1, shift + i]
            + w2 * table[row + 2, shift + i]
            + w3 * table[row + 3, shift + i]
        )


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
    w0, w1, w2, w3 = _weights(phase - row)
    if bay == 0 and period == count:
        bay = count
    for i in range(count):
        out[i] = 0.0
    # Fastener i is fraction - (i + 1 - bay) bays back.
    behind = min(max(bay - 1, 0), count)
    _add_line(table, row, w0, w1, w2, w3, period - behind, 0, behind, out)
    _add_line(table, row, w0, w1, w2, w3, behind + 1 - bay, behind, count, out)
    if period > count:  # K is even: K(fraction + bay + i) = K(1 - fraction - (bay + i + 1)).
        phase = PHASES - phase
        row = int(phase)
        w0, w1, w2, w3 = _weights(phase - row)
        before = min(period - bay - 1, count)
        _add_line(table, row, -w0, -w1, -w2, -w3, bay + 1, 0, before, out)
        _add_line(table, row, -w0, -w1, -w2, -w3, 0, before, count, out)


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
    w0, w1, w2, w3 = _weights(phase - row)
    column = (-bay) % table.shape[1]
    return (
        w0 * table[row, column]
        + w1 * table[row + 1, column]
        + w2 * table[row + 2, column]
        + w3 * table[row + 3, column]
    )
