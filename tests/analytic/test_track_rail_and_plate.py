"""Rail modes, plate modes and static deflections against closed forms."""

import numpy as np
import pytest
from slab_track.assembly import assemble
from slab_track.contact import ContactParameters
from slab_track.parameters import (
    Fastener,
    Rail,
    Slab,
    SlabSupport,
    TrackParameters,
    Window,
)
from slab_track.plate import free_plate_modes, seat_compliance
from slab_track.rail import static_flexibility, timoshenko_modes, vertical_modes
from slab_track.statics import static_coordinates
from slab_track.waves import waves

RAIL = Rail()
EI = RAIL.youngs_modulus * RAIL.vertical_second_moment
KGA = RAIL.vertical_shear_coefficient * RAIL.shear_modulus * RAIL.area


@pytest.mark.parametrize(
    ("mode", "hertz"), [(1, 0.1211), (10, 12.0743), (50, 283.68), (100, 977.27), (200, 2787.25)]
)
def test_frequencies_of_a_hinged_timoshenko_rail(mode, hertz):
    modes = vertical_modes(RAIL, 65.416)
    assert np.sqrt(modes.omega_squared[0, mode - 1]) / 2 / np.pi == pytest.approx(hertz, rel=5e-4)


def test_shear_branch_starts_at_its_cut_off():
    cut_off = np.sqrt(KGA / (RAIL.density * RAIL.vertical_second_moment)) / 2 / np.pi
    first = np.sqrt(vertical_modes(RAIL, 65.416).omega_squared[1, 0]) / 2 / np.pi
    assert cut_off == pytest.approx(5715.0, rel=1e-4)
    assert first == pytest.approx(cut_off, rel=1e-4)


def test_branches_solve_equations_6a_and_6b():
    modes = vertical_modes(Rail(mode_count=300), 65.416)
    rho_a, rho_i = RAIL.density * RAIL.area, RAIL.density * RAIL.vertical_second_moment
    kappa = modes.wave_number
    for branch in (0, 1):
        z, psi = modes.deflection[branch], modes.rotation[branch]
        omega2 = modes.omega_squared[branch]
        # Equations (2) and (3), corrected, for z sin(kx), psi cos(kx).
        force = KGA * (kappa**2 * z - kappa * psi) - omega2 * rho_a * z
        moment = KGA * (psi - kappa * z) + EI * kappa**2 * psi - omega2 * rho_i * psi
        assert np.max(np.abs(force)) < 1e-9 * np.max(np.abs(omega2 * rho_a * z))
        assert np.max(np.abs(moment)) < 1e-9 * np.max(np.abs(KGA * kappa * z))


def test_euler_limit():
    modes = timoshenko_modes(
        waves(10.0, 3),
        bending_stiffness=1e6,
        shear_stiffness=1e13,
        mass_per_length=50.0,
        rotary_inertia=1e-6,
    )
    expected = (np.arange(1, 4) * np.pi / 10.0) ** 4 * 1e6 / 50.0
    np.testing.assert_allclose(modes.omega_squared[0], expected, rtol=1e-5)


def test_both_branches_make_up_the_static_flexibility():
    modes = vertical_modes(RAIL, 65.416)
    series = np.sum(modes.deflection**2 / modes.omega_squared, axis=0)
    closed = static_flexibility(RAIL, 65.416, modes.wave_number)
    np.testing.assert_allclose(series, closed, rtol=1e-9)


@pytest.mark.parametrize(
    ("aspect", "parameters"),
    [
        (0.4, (3.4326, 5.2782, 9.5406)),
        (1.0, (13.468, 19.596, 24.270)),
        (2.5, (21.454, 32.989, 59.629)),
    ],
)
def test_free_plate_frequency_parameters(aspect, parameters):
    """Converged Ritz values; Leissa's table lies up to 1.2 % above them."""
    plate = free_plate_modes(
        length=1.0,
        width=1.0 / aspect,
        thickness=0.01,
        youngs_modulus=1e10,
        poisson_ratio=0.3,
        density=1000.0,
        count=10,
    )
    stiffness = 1e10 * 0.01**3 / (12 * (1 - 0.3**2))
    found = np.sqrt(plate.omega_squared[3:6] * 1000.0 * 0.01 / stiffness)
    np.testing.assert_allclose(found, parameters, rtol=2e-4)


@pytest.mark.parametrize(
    ("length", "thickness", "hertz"),
    [
        (4.962, 0.17, (25.52, 32.61, 70.59, 71.11)),
        (5.6, 0.20, (23.57, 33.88, 65.22, 72.88)),
    ],
)
def test_slab_frequencies_of_both_lines(length, thickness, hertz):
    plate = free_plate_modes(
        length=length,
        width=2.5,
        thickness=thickness,
        youngs_modulus=3.6e10,
        poisson_ratio=0.2,
        density=2800.0,
        count=30,
    )
    frequencies = np.sqrt(plate.omega_squared) / 2 / np.pi
    np.testing.assert_allclose(frequencies[3:7], hertz, rtol=5e-4)
    assert np.count_nonzero(frequencies[3:] < 450.0) == 21


def test_plate_modes_are_orthonormal_and_rigid_modes_exact():
    plate = free_plate_modes(
        length=4.962,
        width=2.5,
        thickness=0.17,
        youngs_modulus=3.6e10,
        poisson_ratio=0.2,
        density=2800.0,
        count=40,
    )
    gx, wx = np.polynomial.legendre.leggauss(40)
    x, y = (a.ravel() for a in np.meshgrid(2.481 * gx, 1.25 * gx, indexing="ij"))
    weight = np.outer(2.481 * wx, 1.25 * wx).ravel() * 2800.0 * 0.17
    shapes = plate.shapes(x, y)
    np.testing.assert_allclose((shapes * weight) @ shapes.T, np.eye(40), atol=1e-9)
    mass = 2800.0 * 0.17 * 4.962 * 2.5
    bounce = plate.shapes(np.array([0.3]), np.array([0.2]))[:3, 0]
    assert np.min(np.abs(np.abs(bounce) - 1 / np.sqrt(mass))) < 1e-12


def test_seat_compliance_of_a_wide_plate_is_westergaards():
    """Far from edges: w = F / (8 sqrt(k D)) under the load, for an endless plate."""
    stiffness = 3.6e10 * 0.17**3 / (12 * (1 - 0.2**2))
    symmetric, antisymmetric = seat_compliance(
        length=4.0,
        width=4.0,
        thickness=0.17,
        youngs_modulus=3.6e10,
        poisson_ratio=0.2,
        foundation=3.18e9,
        seats=np.array([0.0]),
        offset=0.7,
    )
    direct = 0.5 * (symmetric[0, 0] + antisymmetric[0, 0])
    assert direct == pytest.approx(1 / (8 * np.sqrt(3.18e9 * stiffness)), rel=1e-2)


def _rigid_base(**changes):
    return TrackParameters(
        slab_support=SlabSupport(vertical_stiffness=1e16, vertical_damping=0.0), **changes
    )


def _deflection(parameters, x, load=69.21e3):
    track = assemble(parameters)
    static = static_coordinates(track, np.array([x]), np.array([np.sqrt(2.0) * load]), 0)
    return static.deflection[0] / np.sqrt(2.0), static


def test_point_load_on_winkler_support():
    """Closely spaced soft fasteners: the Timoshenko value, 0.7089 mm; Euler is 0.6773 mm."""
    spacing = 0.1
    parameters = _rigid_base(
        fastener=Fastener(
            spacing=spacing, count_per_slab=40, vertical_stiffness=40e6 * spacing / 0.629
        ),
        slab=Slab(gap=0.05),
        window=Window(slab_count=16),
    )
    found, _ = _deflection(parameters, 32.0)
    k = 40e6 / 0.629
    # Roots of EI w'''' - (EI k/KGA) w'' + k w = P delta with the shear term.
    a, b = EI * k / KGA, k
    s = np.sqrt(np.roots([EI, 0, -a, 0, b]).astype(complex))
    wave = np.linspace(0, 4000, 4_000_001)
    integrand = (1 + EI * wave**2 / KGA) / (EI * wave**4 + a * wave**2 + b)
    closed = 69.21e3 / np.pi * np.trapezoid(integrand, wave)
    assert s.size == 4
    assert closed == pytest.approx(0.7089e-3, rel=1e-3)
    assert found == pytest.approx(closed, rel=1e-3)


def test_euler_limit_of_the_winkler_deflection():
    spacing = 0.1
    parameters = _rigid_base(
        rail=Rail(shear_modulus=7.9e14),
        contact=ContactParameters(model="vertical"),
        fastener=Fastener(
            spacing=spacing, count_per_slab=40, vertical_stiffness=40e6 * spacing / 0.629
        ),
        slab=Slab(gap=0.05),
        window=Window(slab_count=16),
    )
    found, _ = _deflection(parameters, 32.0)
    assert found == pytest.approx(0.6773e-3, rel=1e-3)


def test_fasteners_carry_the_load():
    _, static = _deflection(TrackParameters(), 32.7)
    assert np.sum(static.fastener) / np.sqrt(2.0) == pytest.approx(69.21e3, rel=1e-6)


def test_residual_compliance_makes_few_modes_as_stiff_as_many():
    def deflection(count, residual):
        rail = Rail(mode_count=count, residual_compliance=residual)
        return _deflection(TrackParameters(rail=rail), 32.7)[0]

    exact = deflection(4000, True)
    assert deflection(150, True) == pytest.approx(exact, rel=2e-4)
    assert deflection(150, False) < 0.97 * exact


def test_support_basis_only_changes_the_reference_area():
    def per_area(basis, stiffness):
        support = SlabSupport(vertical_stiffness=stiffness, vertical_damping=1.0, basis=basis)
        return TrackParameters(slab_support=support).support_per_area[0]

    per_bay = per_area("per_bay", 5e9)
    assert per_bay == pytest.approx(5e9 / (0.629 * 2.5))
    assert per_area("per_seat", 2.5e9) == pytest.approx(per_bay)
    assert per_area("per_slab", 5e9 * 4.962 / 0.629) == pytest.approx(per_bay)
    assert per_area("per_metre", 5e9 / 0.629) == pytest.approx(per_bay)
    assert per_area("per_square_metre", 5e9 / 0.629 / 2.5) == pytest.approx(per_bay)


def test_hertz_constant_of_a_worn_tread():
    assert ContactParameters().hertz_constant_used == pytest.approx(4.221e-8, rel=1e-3)
    assert ContactParameters(hertz_constant=5.131e-8).hertz_constant_used == 5.131e-8
    force = (71.1e-6 / ContactParameters().hertz_constant_used) ** 1.5
    assert force == pytest.approx(69.21e3, rel=2e-3)
