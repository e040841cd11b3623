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

import numba
import numpy as np

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


@numba.njit(cache=True)
def _weights(fraction):
    """Cubic Lagrange weights at -1, 0, 1, 2 for a fraction in [0, 1)."""
    f = fraction
    return (
        -f * (f - 1.0) * (f - 2.0) / 6.0,
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
        -(f + 1.0) * f * (f - 2.0) / 2.0,
        (f + 1.0) * f * (f - 1.0) / 6.0,
    )


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _add_line(table, fraction, first, sign, out):
    """Add the kernel at a fraction of a bay, in neighbouring columns from ``first`` on."""
    phase = fraction * PHASES
    row = int(phase)
    w0, w1, w2, w3 = _weights(phase - row)
    last = first + out.size
    t0, t1 = table[row, first:last], table[row + 1, first:last]
    t2, t3 = table[row + 2, first:last], table[row + 3, first:last]
    w0, w1, w2, w3 = sign * w0, sign * w1, sign * w2, sign * w3
    for i in range(out.size):
        out[i] += w0 * t0[i] + w1 * t1[i] + w2 * t2[i] + w3 * t3[i]


@numba.njit(cache=True)
def to_fasteners(table, position, out):
    """Fill ``out`` (P,) with the response at all fasteners to a force at ``position``.

    ``position`` is in fastener bays from the window's start.
    """
    count, period = out.size, table.shape[1]
    place = position + 0.5
    bay = int(np.floor(place))
    fraction = place - bay
    if bay == 0 and period == count:
        bay = count
    out[:] = 0.0
    # Fastener i is fraction - (i + 1 - bay) bays back.
    behind = min(max(bay - 1, 0), count)
    _add_line(table, fraction, period - behind, 1.0, out[:behind])
    _add_line(table, fraction, behind + 1 - bay, 1.0, out[behind:])
    if period > count:  # K is even: K(fraction + bay + i) = K(1 - fraction - (bay + i + 1)).
        before = min(period - bay - 1, count)
        _add_line(table, 1.0 - fraction, bay + 1, -1.0, out[:before])
        _add_line(table, 1.0 - fraction, 0, -1.0, out[before:])


@numba.njit(cache=True)
def between(table, first, second, ring=False):
    """Response at ``second`` to a force at ``first``, both in bays from the window's start."""
    direct = _kernel(table, abs(first - second))
    if ring:
        return direct
    return direct - _kernel(table, first + second)


@numba.njit(cache=True)
def _kernel(table, distance):
    bay = int(np.floor(distance))
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
