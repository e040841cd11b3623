"""Tables with which the step sums waves that look alike at the fasteners.

The sums are in halves (:mod:`slab_track.halves`): first those that are even about the window's
middle, then the odd ones.
"""

import numpy as np

from slab_track.halves import half_size, split_basis
from slab_track.kernels.waves import Aliasing


def make_aliasing(index: np.ndarray, sign: np.ndarray, shapes: np.ndarray) -> Aliasing:
    """Build the tables.

    ``index`` and ``sign`` (N,) as in :func:`slab_track.waves.fold_table`; ``shapes`` (P, P) are
    those of the first P waves at the fasteners.
    """
    count = shapes.shape[0]
    order = sum_order(shapes)
    half = half_size(count)
    home = order[index]
    members = [np.flatnonzero((home == i) & (sign != 0.0)) for i in range(2 * half)]
    terms = max(1, *(len(of) for of in members))
    place, signs = np.zeros((terms, 2 * half), dtype=np.int64), np.zeros((terms, 2 * half))
    for i, of in enumerate(members):
        place[: len(of), i], signs[: len(of), i] = of, sign[of]
    both = np.zeros((2 * half, 2 * half))
    both[order] = shapes @ split_basis(count).T
    matrices = np.stack([both[:half, :half], both[half:, half:]])
    return Aliasing(
        place, signs, home, sign.copy(), matrices, np.ascontiguousarray(matrices.swapaxes(1, 2))
    )


def sum_order(shapes: np.ndarray) -> np.ndarray:
    """Return where each of the P sums stands in the halves, (P,)."""
    half = half_size(shapes.shape[0])
    even = np.sum(shapes * shapes[:, ::-1], axis=1) > 0.0
    order = np.empty(even.size, dtype=np.int64)
    order[even], order[~even] = np.arange(even.sum()), half + np.arange((~even).sum())
    return order
