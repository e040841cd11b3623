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
    """Tabulate K for the weights of the waves, shape (PHASES + 3, period in bays).

    Row 1 + j, column o holds K((o + j/PHASES) l_0); one row before and two after are
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
    table = values.reshape(period, PHASES).T
    before = np.roll(table[-1], 1)
    after = np.roll(table[:2], -1, axis=1)
    return np.ascontiguousarray(np.vstack([before[None], table, after]))


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


@numba.njit(cache=True)
def to_fasteners(table, position, out):
    """Fill ``out`` (P,) with the response at all fasteners to a force at ``position``.

    ``position`` is in fastener bays from the window's start.
    """
    count = out.size
    place = position + 0.5
    bay = int(np.floor(place))
    phase = (place - bay) * PHASES
    row = int(phase)
    w0, w1, w2, w3 = _weights(phase - row)
    period = table.shape[1]
    line = np.empty(period)
    for column in range(period):
        line[column] = (
            w0 * table[row, column]
            + w1 * table[row + 1, column]
            + w2 * table[row + 2, column]
            + w3 * table[row + 3, column]
        )
    image = period > count
    for i in range(count):
        out[i] = line[(bay - i - 1) % period]
        if image:
            out[i] -= line[(bay + i) % period]


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
    column = bay % table.shape[1]
    return (
        w0 * table[row, column]
        + w1 * table[row + 1, column]
        + w2 * table[row + 2, column]
        + w3 * table[row + 3, column]
    )
