"""Kalker's creepage and spin coefficients of the linear theory of rolling contact.

References
----------
J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990,
Table E.3; for slender ellipses the asymptotic expressions of his linear theory
(1967), scaled to join the table at its ends.
"""

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

_NU = np.array([0.0, 0.25, 0.5])
_RATIO = np.arange(1, 11) / 10.0

# Rows: a/b = 0.1 ... 1.0; for each coefficient nu = 0, 0.25, 0.5.
_C11_SHORT = [(2.51, 3.31, 4.85), (2.59, 3.37, 4.81), (2.68, 3.44, 4.80), (2.78, 3.53, 4.82),
              (2.88, 3.62, 4.83), (2.98, 3.72, 4.91), (3.09, 3.81, 4.97), (3.19, 3.91, 5.05),
              (3.29, 4.01, 5.12), (3.40, 4.12, 5.20)]  # fmt: skip
_C22_SHORT = [(2.51, 2.52, 2.53), (2.59, 2.63, 2.66), (2.68, 2.75, 2.81), (2.78, 2.88, 2.98),
              (2.88, 3.01, 3.14), (2.98, 3.14, 3.31), (3.09, 3.28, 3.48), (3.19, 3.41, 3.65),
              (3.29, 3.54, 3.82), (3.40, 3.67, 3.98)]  # fmt: skip
_C23_SHORT = [(0.334, 0.473, 0.731), (0.483, 0.603, 0.809), (0.607, 0.715, 0.889),
              (0.720, 0.823, 0.977), (0.827, 0.929, 1.07), (0.930, 1.03, 1.18),
              (1.03, 1.14, 1.29), (1.13, 1.25, 1.40), (1.23, 1.36, 1.51),
              (1.33, 1.47, 1.63)]  # fmt: skip
# Rows: b/a = 0.1 ... 0.9; b/a = 1 is the last row above.
_C11_LONG = [(10.7, 11.7, 12.9), (6.96, 7.78, 8.82), (5.57, 6.34, 7.34), (4.84, 5.57, 6.57),
             (4.37, 5.10, 6.11), (4.06, 4.78, 5.80), (3.82, 4.54, 5.58), (3.65, 4.36, 5.42),
             (3.51, 4.22, 5.30)]  # fmt: skip
_C22_LONG = [(10.7, 12.8, 16.0), (6.96, 8.14, 9.79), (5.57, 6.40, 7.51), (4.84, 5.48, 6.31),
             (4.37, 4.90, 5.56), (4.06, 4.50, 5.04), (3.82, 4.21, 4.67), (3.65, 3.99, 4.39),
             (3.51, 3.81, 4.16)]  # fmt: skip
_C23_LONG = [(12.2, 14.6, 18.0), (5.72, 6.63, 7.89), (3.79, 4.32, 5.01), (2.88, 3.24, 3.70),
             (2.35, 2.62, 2.96), (2.01, 2.23, 2.50), (1.76, 1.95, 2.18), (1.58, 1.75, 1.94),
             (1.44, 1.59, 1.77)]  # fmt: skip


def asymptotic_coefficients(axis_ratio: float, poisson_ratio: float) -> NDArray[np.float64]:
    """Return C11, C22, C23 of a slender ellipse, ``a/b`` well below or above 1."""
    nu = poisson_ratio
    g = min(axis_ratio, 1.0 / axis_ratio)
    log = math.log(16.0 / g**2)
    if axis_ratio < 1.0:
        c11 = math.pi**2 / (4.0 * (1.0 - nu))
        c22 = math.pi**2 / 4.0
        spin = 1.0 + nu * (0.5 * log + math.log(4.0) - 5.0)
        c23 = math.pi * math.sqrt(g) / (3.0 * (1.0 - nu)) * spin
        return np.array([c11, c22, c23])
    three = 3.0 - math.log(4.0)
    first, second = log - 2.0 * nu, (1.0 - nu) * log + 2.0 * nu
    c11 = 2.0 * math.pi / (g * first) * (1.0 + three / first)
    c22 = 2.0 * math.pi / (g * second) * (1.0 + (1.0 - nu) * three / second)
    c23 = 2.0 * math.pi / (3.0 * g * math.sqrt(g)) / ((1.0 - nu) * log - 2.0 + 4.0 * nu)
    return np.array([c11, c22, c23])


def _tables() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tables of shape (10, nu, coefficient), for a/b and for b/a = 0.1 ... 1.0."""
    short = np.stack([_C11_SHORT, _C22_SHORT, _C23_SHORT], axis=-1).astype(float)
    long = np.stack([_C11_LONG, _C22_LONG, _C23_LONG], axis=-1).astype(float)
    return short, np.concatenate([long, short[-1:]])


@functools.lru_cache(maxsize=32)
def _spline(poisson_ratio: float) -> CubicSpline:
    """Spline of the logarithms of the coefficients over ``ln(a/b)`` at one Poisson's ratio."""
    short, long = _tables()
    # Quadratic through the three tabulated Poisson's ratios.
    weights = np.array([
        np.prod([(poisson_ratio - other) / (own - other) for other in _NU if other != own])
        for own in _NU
    ])  # fmt: skip
    nodes = np.concatenate([np.log(_RATIO), -np.log(_RATIO[-2::-1])])
    values = np.concatenate([weights @ short, (weights @ long)[-2::-1]])
    return CubicSpline(nodes, np.log(values))


def kalker_coefficients(axis_ratio: float, poisson_ratio: float) -> NDArray[np.float64]:
    """Return C11, C22, C23 for semi-axes ``a`` (rolling direction) and ``b``.

    Parameters
    ----------
    axis_ratio
        ``a / b``, above 0; outside 0.1 to 10 the asymptotic expressions continue the table.
    poisson_ratio
        0 to 0.5, quadratic between the tabulated 0, 0.25 and 0.5.
    """
    spline = _spline(poisson_ratio)
    end = min(max(axis_ratio, 0.1), 10.0)
    inside = np.exp(spline(math.log(end)))
    if end == axis_ratio:
        return inside
    scale = inside / asymptotic_coefficients(end, poisson_ratio)
    return scale * asymptotic_coefficients(axis_ratio, poisson_ratio)
