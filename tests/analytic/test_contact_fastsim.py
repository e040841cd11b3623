"""FASTSIM against its closed form, Kalker's linear theory and Coulomb's limit."""

import math

import numpy as np
import pytest
from slab_track.contact import ContactParameters, fastsim, kalker_coefficients
from slab_track.contact.fastsim import STRIP_WORK, closed_form, creep_forces, fastsim_grid

A, B, G, NU, MU, LOAD = 6.3e-3, 12.6e-3, 82e9, 0.28, 0.33, 106.7e3
C11, C22, C23 = kalker_coefficients(A / B, NU)
COLUMNS, STRIPS = ContactParameters().fastsim_columns, ContactParameters().fastsim_strips
REFERENCE = [(0.25, 0.22899), (0.5, 0.41867), (1.0, 0.69620), (1.5, 0.86423), (2.0, 0.95288),
             (3.0, 0.99941)]  # fmt: skip


def creep(xi, eta=0.0, phi=0.0, columns=COLUMNS, strips=STRIPS):
    return np.array(fastsim(LOAD, A, B, C11, C22, C23, G, MU, xi, eta, phi, columns, strips))


def creepage_of(tau):
    return tau * MU * LOAD / (G * A * B * C11)


@pytest.mark.parametrize(("tau", "share"), REFERENCE)
def test_closed_form_has_its_known_values(tau, share):
    assert closed_form(tau) == pytest.approx(share, abs=5e-6)


@pytest.mark.parametrize("tau", [0.05, 0.1, *(tau for tau, _ in REFERENCE), 5.0])
def test_production_grid_is_within_one_per_cent_of_the_closed_form(tau):
    force = -creep(creepage_of(tau))[0] / (MU * LOAD)
    assert force == pytest.approx(closed_form(tau), rel=0.01)


def test_error_falls_with_the_grid():
    taus = np.linspace(0.1, 3.0, 30)
    errors = []
    for cells in (12, 48):
        found = [-creep(creepage_of(t), columns=cells, strips=cells)[0] / (MU * LOAD) for t in taus]
        errors.append(max(abs(f / closed_form(t) - 1.0) for f, t in zip(found, taus, strict=True)))
    assert errors[1] < errors[0] / 6.0  # Between first and second order: the slip border moves.


def test_linear_theory_for_small_creepages():
    tiny = 1e-9
    unit = G * A * B
    assert creep(tiny, columns=40, strips=40)[0] == pytest.approx(-unit * C11 * tiny, rel=2e-3)
    assert creep(0.0, tiny, columns=40, strips=40)[1] == pytest.approx(-unit * C22 * tiny, rel=2e-3)
    spin = creep(0.0, 0.0, tiny, columns=40, strips=40)
    assert spin[1] == pytest.approx(-unit * math.sqrt(A * B) * C23 * tiny, rel=2e-3)
    assert abs(spin[0]) < 1e-9 * abs(spin[1])


def test_large_creepage_gives_coulomb_friction_against_the_slip():
    force = creep(3.0e-1, -4.0e-1, columns=100, strips=40)
    assert force[:2] == pytest.approx(MU * LOAD * np.array([-0.6, 0.8]), rel=2e-3)


def test_pure_large_spin_gives_the_frictional_torque():
    # Full slip about the centre: the moment of a Hertzian ellipse is mu N (3/8) times an
    # elliptic mean of the semi-axes; here by quadrature.
    moment = creep(0.0, 0.0, 1e4, columns=200, strips=200)[2]
    r, t = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(400) + 0.5) * math.tau / 400)
    arm = np.hypot(A * r * np.cos(t), B * r * np.sin(t))
    pressure = 1.0 - r**2  # parabolic bound, r dr dt
    exact = -MU * LOAD * np.sum(arm * pressure * r) / np.sum(pressure * r)
    # The three flexibilities of the simplified theory differ for x and y only through
    # xi and eta; in pure spin they are one, so the direction of slip is exact.
    assert moment == pytest.approx(exact, rel=0.02)


def test_mirror_image_in_the_rolling_direction():
    force, image = creep(4e-4, 3e-4, 0.2), creep(4e-4, -3e-4, -0.2)
    assert image == pytest.approx(force * np.array([1.0, -1.0, -1.0]), rel=1e-12)


def test_no_load_or_no_friction_gives_no_force():
    assert fastsim(0.0, A, B, C11, C22, C23, G, MU, 1e-3, 0.0, 0.0, 10, 8) == (0.0, 0.0, 0.0)
    assert fastsim(LOAD, A, B, C11, C22, C23, G, 0.0, 1e-3, 0.0, 0.0, 10, 8) == (0.0, 0.0, 0.0)


def test_adhering_particles_bound_the_slope():
    """The force's fall with lateral creepage lies between their part of Kalker's slope and it."""
    rng, step = np.random.default_rng(5), 1e-8
    grid = fastsim_grid(10, 8), np.zeros(STRIP_WORK)
    for _ in range(2000):
        a, b = 6e-3 * np.exp(0.3 * rng.normal(size=2))
        xi, eta = rng.normal(size=2) * 10.0 ** rng.uniform(-5.0, -2.3, size=2)
        phi = rng.normal() * 10.0 ** rng.uniform(-3.0, 0.8)
        patch = (71733.0, a, b, 4.1, 3.6, 1.5, 8e10, 0.3)
        here = creep_forces(*grid, *patch, xi, eta, phi)
        there = creep_forces(*grid, *patch, xi, eta + step, phi)
        slope = (here[1] - there[1]) / step / (8e10 * a * b * 3.6)
        assert here[3] - 1e-5 < slope < 1.0
    # Without slip all particles adhere.
    assert creep_forces(*grid, *patch, 1e-9, 1e-9, 0.0)[3] == pytest.approx(1.0, abs=1e-3)
