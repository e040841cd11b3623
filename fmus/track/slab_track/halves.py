r"""Even and odd halves about the window's middle.

The line is its own mirror image about the middle of the window, so its compliance between
fasteners does not mix what is even and what is odd about it. With the orthonormal combinations

.. math:: e_i = (f_i + f_{P+1-i})/\sqrt2,\quad o_i = (f_i - f_{P+1-i})/\sqrt2,\quad i \le P/2

a P x P product falls into two of half the size. If P is odd, the fastener in the middle is even
by itself. Halves are filled up with zeros to a multiple of 16.
"""

import numpy as np

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
