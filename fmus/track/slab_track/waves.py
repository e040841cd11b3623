r"""The waves that the rails' motion is made of: sines of a hinged window, or both of a ring.

A hinged window of length l has :math:`\sin(k\pi x/l)`, k = 1, 2, ... . A ring has the
constant and, for each wave number :math:`2\pi k/l`, a cosine and a sine: rows 0; 1, 2;
3, 4; ... . Both are :math:`\cos(\kappa x - \theta)` with a phase of 0 or :math:`\pi/2`, and
the rotation that belongs to it is :math:`-\sin(\kappa x - \theta)`.

Fasteners are equidistant, at :math:`x_i=(i-1/2)l_0`. There the shapes of all waves repeat
those of P = l/l_0 of them (up to a sign): a sum over all waves at all fasteners folds to a
P x P product.
"""

import math
from typing import NamedTuple

import numpy as np


class Waves(NamedTuple):
    """Wave functions along a rail.

    Attributes
    ----------
    wave_number, phase
        kappa in rad/m and theta in rad, shape (N,).
    length
        Of the window or the ring, m.
    ring
        True if the rail closes on itself.
    """

    wave_number: np.ndarray
    phase: np.ndarray
    length: float
    ring: bool

    @property
    def mean_square(self) -> np.ndarray:
        """Mean of the squared shapes over the length: 1/2, and 1 for the constant, (N,)."""
        return np.where(self.wave_number == 0.0, 1.0, 0.5)

    def shapes(self, x: np.ndarray) -> np.ndarray:
        """Return the shapes of the deflection at positions ``x`` in m, shape (N, points)."""
        return np.cos(np.outer(self.wave_number, x) - self.phase[:, None])

    def rotation_shapes(self, x: np.ndarray) -> np.ndarray:
        """Return the shapes of the rotation at positions ``x`` in m, shape (N, points)."""
        return -np.sin(np.outer(self.wave_number, x) - self.phase[:, None])


def waves(length: float, count: int, *, ring: bool = False) -> Waves:
    """Return the first ``count`` waves; on a ring one more if that is even.

    On a ring ``count`` waves end at the same wavelength as in a hinged window.
    """
    if not ring:
        numbers = np.pi / length * np.arange(1, count + 1)
        return Waves(numbers, np.full(count, 0.5 * np.pi), length, ring=False)
    row = np.arange(2 * (count // 2) + 1)
    phase = np.where((row % 2 == 0) & (row > 0), 0.5 * np.pi, 0.0)
    return Waves(2.0 * np.pi / length * ((row + 1) // 2), phase, length, ring=True)


def fastener_shapes(count: int, *, ring: bool = False) -> np.ndarray:
    """Return the shapes of the first P waves at the P = ``count`` fasteners, (P, P).

    On an even ring the last cosine vanishes at all fasteners and its sine stands instead.
    """
    place = np.arange(count) + 0.5
    if not ring:
        return np.sin(np.pi / count * np.outer(np.arange(1, count + 1), place))
    shapes = waves(count, count, ring=True).shapes(place)
    return np.vstack([shapes[: count - 1], shapes[-1]])


def samples_per_bay(waves: int, fasteners: int) -> int:
    """Return how many sample points a bay has, so that a fifth more than waves lie in the window.

    An odd number: at the middle of equal segments the fasteners are among them.
    """
    return 2 * math.ceil(0.5 * (1.2 * waves / fasteners - 1.0)) + 1


def fold_table(mode_count: int, fastener_count: int, *, ring: bool = False):
    """Row of :func:`fastener_shapes` that each wave repeats, and its sign (0: it vanishes).

    Shapes (N,), for the waves of ``waves(length, mode_count, ring=ring)``.
    """
    if ring:
        return _fold_ring(2 * (mode_count // 2) + 1, fastener_count)
    k = np.arange(1, mode_count + 1)
    turn, rest = np.divmod(k, 2 * fastener_count)
    mirrored = np.where(rest > fastener_count, 2 * fastener_count - rest, rest)
    sign = np.where(turn % 2 == 0, 1.0, -1.0) * (mirrored > 0)
    return np.maximum(mirrored - 1, 0), sign


def _fold_ring(rows: int, fastener_count: int) -> tuple[np.ndarray, np.ndarray]:
    row = np.arange(rows)
    is_sine = (row % 2 == 0) & (row > 0)
    turn, rest = np.divmod((row + 1) // 2, fastener_count)
    mirrored = 2 * rest > fastener_count
    base = np.where(mirrored, fastener_count - rest, rest)
    sign = np.where(turn % 2 == 0, 1.0, -1.0) * np.where(mirrored & ~is_sine, -1.0, 1.0)
    # At base 0 there is no sine, and at half the fasteners' number no cosine.
    sign *= np.where(is_sine, base > 0, 2 * base != fastener_count)
    index = np.where(base == 0, 0, 2 * base - np.where(is_sine, 0, 1))
    return np.minimum(index, fastener_count - 1), sign
