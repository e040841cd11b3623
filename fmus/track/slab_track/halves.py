r"""Even and odd halves about the window's middle.

The line is its own mirror image about the middle of the window, so its compliance between
fasteners does not mix what is even and what is odd about it. With the orthonormal combinations

.. math:: e_i = (f_i + f_{P+1-i})/\sqrt2,\quad o_i = (f_i - f_{P+1-i})/\sqrt2,\quad i \le P/2

a P x P product falls into two of half the size. If P is odd, the fastener in the middle is even
by itself. Halves are filled up with zeros to a multiple of 16.
"""

import numpy as np

from slab_track.compiled import stream

LANES = 16
_ROOT = float(np.sqrt(0.5))


def half_size(count: int) -> int:
    """Return the length h of a half of ``count`` values, filled up."""
    return -(-((count + 1) // 2) // LANES) * LANES


def split_basis(count: int) -> np.ndarray:
    """Return the combinations as rows, shape (2h, P): even ones, then odd ones."""
    half, basis = half_size(count), np.zeros((2 * half_size(count), count))
    for i in range(count // 2):
        basis[i, [i, count - 1 - i]] = _ROOT
        basis[half + i, [i, count - 1 - i]] = _ROOT, -_ROOT
    if count % 2:
        basis[count // 2, count // 2] = 1.0
    return basis


def split_matrix(matrix: np.ndarray) -> np.ndarray:
    """Return both halves of a matrix between fasteners (P, P), shape (2, h, h)."""
    basis = split_basis(matrix.shape[0])
    both = basis @ matrix @ basis.T
    half = both.shape[0] // 2
    return np.stack([both[:half, :half], both[half:, half:]])


@stream
def split(values, even, odd):
    """Fill the halves ``even`` and ``odd``, (h,), of ``values`` (P,)."""
    count = values.size
    for i in range(count // 2, even.size):
        even[i] = odd[i] = 0.0
    for i in range(count // 2):
        even[i] = _ROOT * (values[i] + values[count - 1 - i])
    for i in range(count // 2):
        odd[i] = _ROOT * (values[i] - values[count - 1 - i])
    if count % 2 == 1:
        even[count // 2] = values[count // 2]


@stream
def join(halves, out):
    """Fill ``out`` (P,) with the values whose ``halves`` (2, h) are given."""
    count = out.size
    for i in range(count // 2):
        out[i] = _ROOT * (halves[0, i] + halves[1, i])
    for i in range(count // 2):
        out[count - 1 - i] = _ROOT * (halves[0, i] - halves[1, i])
    if count % 2 == 1:
        out[count // 2] = halves[0, count // 2]


@stream
def apply(columns, factors, sums):
    """Multiply a half: ``sums`` (h,) from ``factors`` (h,).

    ``columns`` (h, h) holds the transposed matrix: four columns at a time are added up.
    """
    for i in range(sums.size):
        sums[i] = 0.0
    for j in range(0, factors.size, 4):
        a, b, c, d = factors[j], factors[j + 1], factors[j + 2], factors[j + 3]
        m0, m1, m2, m3 = columns[j], columns[j + 1], columns[j + 2], columns[j + 3]
        for i in range(sums.size):
            sums[i] += a * m0[i] + b * m1[i] + c * m2[i] + d * m3[i]
