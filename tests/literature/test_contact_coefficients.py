"""Hertz, Kalker and FASTSIM against CONTACT's and Kalker's published values."""

import numpy as np
import pytest
from scipy.optimize import brentq
from slab_track.contact import fastsim, hertz_contact, kalker_coefficients
from slab_track.contact.hertz import axis_ratio

G, NU = 82e9, 0.28
LOAD = 106.7e3


@pytest.fixture(scope="module")
def ellipse():
    """CONTACT's half-space case: A = 0.8 /m and B such that a/b = 0.5."""
    curvature_b = brentq(lambda b: axis_ratio(0.8, b) - 0.5, 1e-3, 0.8)
    return hertz_contact(LOAD, 0.8, float(curvature_b), G / (1.0 - NU))


def test_hertzian_ellipse_of_contact(ellipse):
    assert ellipse.semi_axis_a == pytest.approx(6.304e-3, rel=2e-4)
    assert ellipse.semi_axis_b == pytest.approx(12.61e-3, rel=3e-4)
    assert ellipse.approach == pytest.approx(76.51e-6, rel=2e-4)
    assert ellipse.peak_pressure == pytest.approx(640.7e6, rel=1e-3)


@pytest.mark.parametrize(
    ("xi", "share"), [(0.4e-3, 0.2588), (1.2e-3, 0.6482), (2.0e-3, 0.8816), (3.6e-3, 0.9991)]
)
def test_creep_curve_of_contact(ellipse, xi, share):
    a, b = ellipse.semi_axis_a, ellipse.semi_axis_b
    coefficients = kalker_coefficients(a / b, NU)
    force, *_ = fastsim(LOAD, a, b, *coefficients, G, 0.33, xi, 0.0, 0.0, 12, 10)
    assert -force / (0.33 * LOAD) == pytest.approx(share, rel=0.06)


# A selection over the whole of Kalker's Table E.3, nu = 0.25: a/b, C11, C22, C23.
@pytest.mark.parametrize(
    ("ratio", "values"),
    [
        (0.1, (3.31, 2.52, 0.473)),
        (0.6, (3.72, 3.14, 1.03)),
        (1.0, (4.12, 3.67, 1.47)),
        (1.0 / 0.7, (4.54, 4.21, 1.95)),
        (1.0 / 0.3, (6.34, 6.40, 4.32)),
        (10.0, (11.7, 12.8, 14.6)),
    ],
)
def test_kalker_table_is_reproduced(ratio, values):
    assert kalker_coefficients(ratio, 0.25) == pytest.approx(values, rel=1e-9)


@pytest.mark.parametrize(("nu", "c11"), [(0.0, 3.40), (0.5, 5.20)])
def test_kalker_table_at_the_ends_of_poissons_ratio(nu, c11):
    assert kalker_coefficients(1.0, nu)[0] == pytest.approx(c11, rel=1e-9)


def test_kalker_interpolates_in_poissons_ratio():
    low, mean, high = (kalker_coefficients(0.5, nu)[0] for nu in (0.25, 0.303, 0.5))
    linear = low + (high - low) * 0.053 / 0.25
    assert low < mean < linear  # C11 is convex in nu: below the chord, by 1 %
    assert mean == pytest.approx(linear, rel=0.02)


@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_kalker_continues_into_the_asymptotic_limits(ratio):
    inside, outside = kalker_coefficients(ratio, 0.3), kalker_coefficients(ratio**1.001, 0.3)
    assert outside == pytest.approx(inside, rel=5e-3)
    # C11 and C22 of a strip lying across the rolling direction tend to fixed limits.
    slender = kalker_coefficients(1e-3, 0.3)
    limits = np.array([np.pi**2 / 4 / 0.7, np.pi**2 / 4])
    assert slender[:2] == pytest.approx(limits, rel=0.03)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.5])
def test_no_number_of_kalkers_table_stands_out(nu):
    """Each is within 0.9 % of what its neighbours let expect: a misprint shows."""
    ratios = np.concatenate([np.arange(1, 11) / 10.0, 10.0 / np.arange(9, 0, -1)])
    x = np.log(ratios)
    table = np.log([kalker_coefficients(ratio, nu) for ratio in ratios])
    for i in range(1, ratios.size - 1):
        near = [j for j in range(max(0, i - 2), min(ratios.size, i + 3)) if j != i]
        for values in table.T:
            expected = np.polyval(np.polyfit(x[near], values[near], len(near) - 1), x[i])
            assert values[i] == pytest.approx(expected, abs=0.009)
