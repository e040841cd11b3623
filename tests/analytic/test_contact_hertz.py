"""Hertz: the sphere, the similarity laws, the symmetry, and the table of factors."""

import math

import numpy as np
import pytest
from slab_track.contact.hertz import contact_modulus, hertz_contact, hertz_factors

MODULUS = contact_modulus(2.1e11, 0.3)


def test_sphere_on_plane():
    radius, load = 0.5, 5e4
    found = hertz_contact(load, 0.5 / radius, 0.5 / radius, MODULUS)
    a = (0.75 * load * radius / MODULUS) ** (1 / 3)
    assert found.semi_axis_a == pytest.approx(a, rel=1e-9)
    assert found.semi_axis_b == pytest.approx(a, rel=1e-9)
    assert found.approach == pytest.approx(a**2 / radius, rel=1e-9)
    assert found.peak_pressure == pytest.approx(1.5 * load / (math.pi * a**2), rel=1e-9)


@pytest.mark.parametrize("ratio", [1e-3, 0.05, 0.5, 0.999, 1.0 - 2e-6, 3.0, 400.0])
def test_semi_axes_satisfy_the_gap_that_they_close(ratio):
    # Independent of the elliptic-integral formulas: the potential of the ellipsoidal pressure,
    # u(0) - u(x) = A x^2 + B y^2 with integrals over the confocal parameter.
    curvature_b = 1.2
    curvature_a = ratio * curvature_b
    load = 7e4
    c = hertz_contact(load, curvature_a, curvature_b, MODULUS)
    a, b = c.semi_axis_a, c.semi_axis_b
    # Substitution t = (a b) tan^2(theta / 2)-like: equidistant in ln t converges exponentially.
    log = np.linspace(-60.0, 60.0, 60001)
    t = a * b * np.exp(log)
    weight = (log[1] - log[0]) * t
    root = np.sqrt((a**2 + t) * (b**2 + t) * t)
    factor = 0.75 * load / (math.pi * MODULUS)
    assert factor * np.sum(weight / ((a**2 + t) * root)) == pytest.approx(curvature_a, rel=1e-6)
    assert factor * np.sum(weight / ((b**2 + t) * root)) == pytest.approx(curvature_b, rel=1e-6)
    assert factor * np.sum(weight / root) == pytest.approx(c.approach, rel=1e-6)


def test_force_grows_with_the_power_three_halves():
    one = hertz_contact(1e4, 1.0, 0.3, MODULUS)
    eight = hertz_contact(8e4, 1.0, 0.3, MODULUS)
    assert eight.approach == pytest.approx(4.0 * one.approach, rel=1e-12)
    assert one.stiffness_constant * one.approach**1.5 == pytest.approx(1e4, rel=1e-12)


def test_exchange_of_the_curvatures_exchanges_the_axes():
    one, other = hertz_contact(1e4, 1.0, 0.2, MODULUS), hertz_contact(1e4, 0.2, 1.0, MODULUS)
    assert one.semi_axis_a == pytest.approx(other.semi_axis_b, rel=1e-10)
    assert one.approach == pytest.approx(other.approach, rel=1e-10)


def test_table_of_factors_against_the_exact_integrals():
    limit, count = 9.0, 361
    table = hertz_factors(limit, count)
    for row in (3, 90, 179, 180, 181, 300):
        ratio = math.exp(-limit + row * 2.0 * limit / (count - 1))
        exact = hertz_contact(1.0, ratio, 1.0, 1.0)
        radius = 0.5 / math.sqrt(ratio)
        f1 = math.sqrt(exact.semi_axis_a * exact.semi_axis_b) / (0.75 * radius) ** (1 / 3)
        f2 = exact.approach / (9.0 / (16.0 * radius)) ** (1 / 3)
        log = math.log(exact.semi_axis_a / exact.semi_axis_b)
        assert table[row] == pytest.approx([log, f1, f2], abs=2e-6)
