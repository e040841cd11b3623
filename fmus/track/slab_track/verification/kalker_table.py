"""Kalker's coefficients as printed: Three-Dimensional Elastic Bodies in Rolling Contact, Table E.3.

Written down apart from :mod:`slab_track.contact.kalker`, whose table the computation uses.
"""

from typing import NamedTuple

import numpy as np

# Semi-axes: ratio, then C11, C22, C23, each for nu = 0, 0.25, 0.5.
_SHORT = """
0.1  2.51 3.31 4.85  2.51 2.52 2.53  .334 .473 .731
0.2  2.59 3.37 4.81  2.59 2.63 2.66  .483 .603 .809
0.3  2.68 3.44 4.80  2.68 2.75 2.81  .607 .715 .889
0.4  2.78 3.53 4.82  2.78 2.88 2.98  .720 .823 .977
0.5  2.88 3.62 4.83  2.88 3.01 3.14  .827 .929 1.07
0.6  2.98 3.72 4.91  2.98 3.14 3.31  .930 1.03 1.18
0.7  3.09 3.81 4.97  3.09 3.28 3.48  1.03 1.14 1.29
0.8  3.19 3.91 5.05  3.19 3.41 3.65  1.13 1.25 1.40
0.9  3.29 4.01 5.12  3.29 3.54 3.82  1.23 1.36 1.51
1.0  3.40 4.12 5.20  3.40 3.67 3.98  1.33 1.47 1.63
"""
_LONG = """
0.1  10.7 11.7 12.9  10.7 12.8 16.0  12.2 14.6 18.0
0.2  6.96 7.78 8.82  6.96 8.14 9.79  5.72 6.63 7.89
0.3  5.57 6.34 7.34  5.57 6.40 7.51  3.79 4.32 5.01
0.4  4.84 5.57 6.57  4.84 5.48 6.31  2.88 3.24 3.70
0.5  4.37 5.10 6.11  4.37 4.90 5.56  2.35 2.62 2.96
0.6  4.06 4.78 5.80  4.06 4.50 5.04  2.01 2.23 2.50
0.7  3.82 4.54 5.58  3.82 4.21 4.67  1.76 1.95 2.18
0.8  3.65 4.36 5.42  3.65 3.99 4.39  1.58 1.75 1.94
0.9  3.51 4.22 5.30  3.51 3.81 4.16  1.44 1.59 1.77
"""
POISSON_RATIOS = (0.0, 0.25, 0.5)


class KalkerTable(NamedTuple):
    """The table.

    Attributes
    ----------
    axis_ratio
        a/b, rising, shape (19,).
    coefficients
        C11, C22, C23, shape (19, nu, 3).
    """

    axis_ratio: np.ndarray
    coefficients: np.ndarray


def kalker_table() -> KalkerTable:
    """Return the printed table by rising a/b."""
    short, long = (np.array(text.split(), dtype=float).reshape(-1, 10) for text in (_SHORT, _LONG))
    rows = np.vstack([short, long[::-1]])
    ratio = np.concatenate([short[:, 0], 1.0 / long[::-1, 0]])
    return KalkerTable(ratio, rows[:, 1:].reshape(-1, 3, 3).transpose(0, 2, 1))
