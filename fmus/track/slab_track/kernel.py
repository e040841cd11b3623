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
