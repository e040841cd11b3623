r"""Hertz's contact of two elastic bodies of the same material.

The undeformed gap near the contact is ``A x^2 + B y^2`` (x along the rail, y
across; A, B in 1/m). With ``R_e = 1 / (2 sqrt(A B))`` and the contact modulus
``E* = E / (2 (1 - nu^2))``:

.. math:: \sqrt{a b} = \Big(\frac{3 N R_e}{4 E^*}\Big)^{1/3} F_1,\qquad
          \delta = \Big(\frac{9 N^2}{16 E^{*2} R_e}\Big)^{1/3} F_2

where ``F_1, F_2`` depend on ``A/B`` alone through complete elliptic integrals.

References
----------
K. L. Johnson, Contact Mechanics, 1985, eqs. (4.24) to (4.28).
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import root_scalar
from scipy.special import ellipe, ellipkm1


class HertzContact(NamedTuple):
    """An elliptic contact.

    Attributes
    ----------
    semi_axis_a, semi_axis_b
        Semi-axes along and across the rail (m).
    approach
        Approach of the bodies (m).
    peak_pressure
        Largest pressure (Pa).
    stiffness_constant
        ``K`` of ``N = K approach^(3/2)`` (N/m^1.5).
    """

    semi_axis_a: float
    semi_axis_b: float
    approach: float
    peak_pressure: float
    stiffness_constant: float


def contact_modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """Return ``E* = E / (2 (1 - nu^2))`` (Pa) of two bodies of the same material."""
    return youngs_modulus / (2.0 * (1.0 - poisson_ratio**2))


def _integrals(axis_ratio: float) -> tuple[float, float]:
    """Complete elliptic integrals K, E at ``e^2 = 1 - axis_ratio^2``."""
    # The complement keeps its digits for slender ellipses.
    return float(ellipkm1(axis_ratio**2)), float(ellipe(1.0 - axis_ratio**2))


def _curvature_ratio(axis_ratio: float) -> float:
    """Smaller over larger curvature for minor over major semi-axis (Johnson, 4.25)."""
    if axis_ratio > 1.0 - 1e-5:
        return axis_ratio**1.5  # Leading order of the near-circular ellipse.
    k, e = _integrals(axis_ratio)
    return (k - e) / (e / axis_ratio**2 - k)


def _factors(axis_ratio: float) -> tuple[float, float]:
    """Return ``F_1, F_2`` of the module's equations (Johnson, 4.26 and 4.27)."""
    if axis_ratio > 1.0 - 1e-5:
        return 1.0, 1.0
    k, e = _integrals(axis_ratio)
    squared = 1.0 - axis_ratio**2
    cube = 4.0 / (math.pi * squared) * axis_ratio**1.5
    f1 = (cube * math.sqrt((e / axis_ratio**2 - k) * (k - e))) ** (1.0 / 3.0)
    return f1, 2.0 / math.pi * math.sqrt(axis_ratio) * k / f1


def axis_ratio(curvature_a: float, curvature_b: float) -> float:
    """Return ``a / b`` of the ellipse for the half-curvatures A (along) and B (across)."""
    ratio = curvature_a / curvature_b
    if ratio > 1.0:
        return 1.0 / axis_ratio(curvature_b, curvature_a)
    if ratio > 1.0 - 1e-5:
        return ratio ** (-2.0 / 3.0)
    # A < B: a is the major semi-axis.
    minor_over_major = root_scalar(
        lambda k: _curvature_ratio(k) - ratio, bracket=(1e-9, 1.0), xtol=1e-14
    ).root
    return 1.0 / minor_over_major


def hertz_contact(
    normal_force: float, curvature_a: float, curvature_b: float, modulus: float
) -> HertzContact:
    """Return ellipse and approach under a load, from the exact elliptic integrals.

    Parameters
    ----------
    normal_force
        Load (N).
    curvature_a, curvature_b
        Half-curvatures ``A``, ``B`` of the gap along and across the rail (1/m),
        both above 0.
    modulus
        Contact modulus ``E*`` (Pa), see :func:`contact_modulus`.
    """
    ratio = axis_ratio(curvature_a, curvature_b)
    f1, f2 = _factors(min(ratio, 1.0 / ratio))
    radius = 0.5 / math.sqrt(curvature_a * curvature_b)
    mean = (0.75 * normal_force * radius / modulus) ** (1.0 / 3.0) * f1
    a, b = mean * math.sqrt(ratio), mean / math.sqrt(ratio)
    stiffness = 4.0 / 3.0 * modulus * math.sqrt(radius) * f2**-1.5
    return HertzContact(
        semi_axis_a=a,
        semi_axis_b=b,
        approach=(normal_force / stiffness) ** (2.0 / 3.0),
        peak_pressure=1.5 * normal_force / (math.pi * a * b),
        stiffness_constant=stiffness,
    )


@functools.lru_cache(maxsize=4)
def hertz_factors(limit: float, count: int) -> NDArray[np.float64]:
    """Tabulate ``ln(a/b), F_1, F_2`` at equidistant ``ln(A/B)`` in (-limit, limit).

    Returns
    -------
    Array of shape (count, 3), read-only; accurate to 1e-7.
    """
    # Exact values are cheap the other way round, from the axis ratio.
    ratios = np.concatenate([np.geomspace(1e-5, 0.9, 1500), np.linspace(0.9, 0.9999, 300)[1:]])
    logs = np.log([_curvature_ratio(k) for k in ratios])
    columns = np.array([(math.log(k), *_factors(k)) for k in ratios])
    logs, columns = np.append(logs, 0.0), np.vstack([columns, [0.0, 1.0, 1.0]])
    # Odd continuation of the axis ratio and even ones of the factors through A = B.
    signs = np.array([-1.0, 1.0, 1.0])
    nodes = np.concatenate([logs, -logs[-2::-1]])
    values = np.concatenate([columns, signs * columns[-2::-1]])
    values[:, 0] *= -1.0  # A < B gives a > b.
    grid = np.linspace(-limit, limit, count)
    table = CubicSpline(nodes, values)(grid)
    table.setflags(write=False)
    return table
