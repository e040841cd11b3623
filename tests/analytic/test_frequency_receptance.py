"""Receptances against the time domain, statics, closed forms and independent models."""

import numpy as np
import pytest
from dense_lateral import dense_lateral
from dense_track import dense_track
from rail_quantities import ParameterError, with_values
from reference_fe import ReferenceTrack
from reference_fe import receptance as fe_receptance
from scipy.integrate import quad
from slab_track import HD, TrackModel
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, assemble
from slab_track.frequency import middle, receptance
from slab_track.lateral import assemble_lateral, static_rail
from slab_track.statics import static_coordinates

MIDDLE = middle(HD)
LATERAL, ROLL = 0, 1
LEFT, RIGHT = 0, 1


def relative(found, wanted):
    return np.abs(found - wanted) / np.abs(wanted)


# -- the time domain ---------------------------------------------------------------

PLACES = np.array([35.17, 32.6])  # neither mid-bay nor over a fastener
DURATION = 0.2


def impulse_response(step, load):
    """Sequences of force and of the rail heads' motion (lateral, vertical, roll).

    A force acts on the left head of the first wheelset during one step; the rails start at
    rest. Shapes (steps,) and (steps, wheelsets, 2, 3).
    """
    p = with_values(
        HD,
        {
            "interface": "applied_force",
            "static_wheel_load": 0.0,
            "wheelset_count": 2,
            "integration.maximum_step": step,
        },
    )
    model = TrackModel(p)
    motion = np.zeros((2, 11))
    motion[:, 0] = PLACES
    state = model.initial_state(motion)
    places = motion[:, 0] - state.window_start
    steps = round(DURATION / step)
    moved, force = np.empty((steps, 2, 2, 3)), np.zeros(steps)
    force[0] = 1.0
    applied = np.zeros((2, 2, 3))
    for n in range(steps):
        applied[0, LEFT, load] = force[n]
        state, out = model.step(state, motion, step, applied_force=applied)
        moved[n] = np.stack([out.rail_lateral, out.rail_deflection, out.rail_roll], axis=-1)
    # Waves with nodes at all fasteners (above 1 kHz) ring on undamped: they are faded out
    # where all else is over.
    fade = np.clip(2.0 - 2.0 * np.arange(steps) / steps, 0.0, 1.0)
    return places, force, moved * np.sin(0.5 * np.pi * fade)[:, None, None, None] ** 2


def transfer(step, frequency, load):
    places, force, moved = impulse_response(step, load)
    kernel = np.exp(-2j * np.pi * np.outer(frequency, step * np.arange(force.size)))
    spectrum = np.einsum("fn,nwsd->fwsd", kernel, moved)
    return places, spectrum / (kernel @ force)[:, None, None, None]


def columns(found):
    """Vertical response of both rails at both places, (f, places, rails)."""
    return np.stack([found.same_rail[:, :, 0], found.other_rail[:, :, 0]], axis=-1)


def test_equals_the_transform_of_the_vertical_impulse_response():
    frequency = np.array([10.0, 45.0, 90.0, 160.0, 250.0, 400.0])
    errors = []
    for step in (1e-4, 5e-5, 2.5e-5):
        places, found = transfer(step, frequency, 1)
        wanted = columns(receptance(HD, frequency, places[:1], places))
        errors.append(relative(found[..., 1], wanted).max())
    assert errors[2] < 0.01
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.15)
    # The trapezoidal rule is exact at the frequency 2/h tan(omega h/2); of the difference only
    # that of the residual's backward rate remains.
    warped = np.tan(np.pi * frequency * step) / (np.pi * step)
    wanted = columns(receptance(HD, warped, places[:1], places))
    left = relative(found[..., 1], wanted)
    assert left[:, 0, LEFT].max() < 3e-5
    assert left.max() < 8e-4


@pytest.mark.parametrize("load", [LATERAL, ROLL])
def test_equals_the_transform_of_the_lateral_impulse_response(load):
    frequency, step = np.array([10.0, 60.0, 120.0, 250.0, 600.0]), 2.5e-5
    places, found = transfer(step, frequency, 2 * load)
    warped = np.tan(np.pi * frequency * step) / (np.pi * step)
    plain = receptance(HD, frequency, places[:1], places).lateral[:, :, 0, :, load]
    wanted = receptance(HD, warped, places[:1], places).lateral[:, :, 0, :, load]
    found = found[:, :, LEFT][..., [0, 2]]
    scale = np.abs(wanted).max(axis=(0, 1))
    assert (np.abs(found - plain) / scale).max() < 0.01
    # The time domain tabulates the compliance under a wheel between the fasteners.
    assert (np.abs(found - wanted) / scale).max() < 8e-4


# -- statics -----------------------------------------------------------------------


def test_zero_frequency_is_the_static_equilibrium():
    x = np.array([MIDDLE.mid_bay, MIDDLE.fastener, MIDDLE.mid_bay + 2.5])
    found = receptance(HD, 0.0, x)
    track = assemble(HD)
    for j, unit in enumerate(np.eye(3)):
        symmetric, antisymmetric = (
            static_coordinates(track, x, unit, c).deflection for c in (SYMMETRIC, ANTISYMMETRIC)
        )
        assert found.same_rail[0, :, j] == pytest.approx(0.5 * (symmetric + antisymmetric))
        assert found.other_rail[0, :, j] == pytest.approx(0.5 * (symmetric - antisymmetric))
        lateral = assemble_lateral(HD)
        _, axis = static_rail(lateral, x, np.outer(unit, [1.0, HD.rail.axis_depth]))
        head = axis[j, 0] + HD.rail.axis_depth * axis[j, 1]
        assert found.lateral[0, j, j, LATERAL, LATERAL] == pytest.approx(head, rel=1e-9)


def test_reciprocal_and_passive():
    x = np.array([30.1, MIDDLE.fastener, 34.0])
    found = receptance(HD, [5.0, 70.0, 300.0, 1200.0], x)
    for matrix in (found.same_rail, found.other_rail):
        assert matrix == pytest.approx(np.swapaxes(matrix, 1, 2), rel=1e-8)
    swapped = found.lateral.transpose(0, 2, 1, 4, 3)
    assert found.lateral == pytest.approx(swapped, rel=1e-8, abs=1e-16)
    # Fasteners and CAM layer dissipate under every load of both rails.
    both = np.block([[found.same_rail, found.other_rail], [found.other_rail, found.same_rail]])
    assert np.all(np.linalg.eigvalsh(both.imag) < 0.0)


def test_rate_and_acceleration():
    f = np.array([12.0, 130.0])
    found = receptance(HD, f, [MIDDLE.mid_bay])
    omega = (2.0 * np.pi * f)[:, None, None]
    assert found.mobility().same_rail == pytest.approx(1j * omega * found.same_rail)
    assert found.accelerance().other_rail == pytest.approx(-(omega**2) * found.other_rail)
    roll = found.lateral[..., ROLL, ROLL]
    assert found.accelerance().lateral[..., ROLL, ROLL] == pytest.approx(-(omega**2) * roll)


# -- other models ------------------------------------------------------------------

SMALL = {
    "window.slab_count": 3,
    "rail.mode_count": 40,
    "slab.mode_count": 14,
    "rail.residual_compliance": False,
    "slab.residual_compliance": False,
}


def test_agrees_with_the_dense_track():
    p, x, omega = with_values(HD, SMALL), np.array([6.9, 8.1]), 2.0 * np.pi * 75.0
    dense = dense_track(p)
    rows = dense.wheel_rows(x)
    matrix = dense.stiffness + 1j * omega * dense.damping - omega**2 * np.eye(rows.shape[1])
    wanted = rows @ np.linalg.solve(matrix, rows.T)
    found = receptance(p, 75.0, x)
    assert found.same_rail[0] == pytest.approx(wanted[:2, :2], rel=1e-8)
    assert found.other_rail[0] == pytest.approx(wanted[2:, :2], rel=1e-8)


def test_agrees_with_the_dense_lateral_rail():
    p, places, omega = with_values(HD, SMALL), np.array([6.9, 8.1]), 2.0 * np.pi * 140.0
    dense = dense_lateral(p)
    # Motion of the head, and load on it: the same rows.
    rows = []
    for x in places:
        axis, roll = dense.rows(x)
        rows.append([axis + p.rail.axis_depth * roll, roll])
    rows = np.array(rows)
    matrix = dense.stiffness + 1j * omega * dense.damping - omega**2 * dense.mass
    for j in (0, 1):
        wanted = rows @ np.linalg.solve(matrix, rows[j].T)
        found = receptance(p, 140.0, places[j : j + 1], places).lateral[0, :, 0]
        assert found == pytest.approx(wanted, rel=1e-8)


def test_agrees_with_the_reference_finite_elements():
    f = np.array([8.0, 47.0, 90.0, 170.0, 420.0])
    reference = ReferenceTrack(rail_elements_per_bay=16)
    for offset, place in ((4.0, MIDDLE.mid_bay), (4.5, MIDDLE.fastener)):
        x = 12 * HD.pitch + offset * HD.fastener.spacing
        at = np.array([x, x + 2.5])
        wanted = fe_receptance(reference, x, f, response_positions=at)
        found = receptance(HD, f, [place], [place, place + 2.5]).same_rail[:, :, 0]
        assert np.abs(found - wanted).max(axis=0) / np.abs(wanted).max(axis=0) == pytest.approx(
            [0.0, 0.0], abs=2e-3
        )
        assert relative(found[:, 0], wanted[:, 0]).max() < 2.5e-3


def test_ring_and_hinged_window_agree_far_from_the_hinges():
    f, x = np.array([1.0, 60.0, 150.0, 400.0]), np.array([MIDDLE.mid_bay, MIDDLE.fastener + 2.5])
    hinged = receptance(HD, f, x)
    ring = receptance(with_values(HD, {"window.method": "cyclic"}), f, x)
    for name in ("same_rail", "other_rail", "lateral"):
        found, wanted = getattr(ring, name), getattr(hinged, name)
        scale = np.abs(wanted).max(axis=(0, 1, 2))
        assert (np.abs(found - wanted) / scale).max() < 2e-3, name


# -- closed forms ------------------------------------------------------------------


def winkler(p, frequency):
    """Receptance of an endless Timoshenko rail on a uniform viscoelastic base.

    Integral over all wave numbers of the response to a harmonic wave.
    """
    omega = 2.0 * np.pi * frequency
    rail, bay = p.rail, p.fastener.spacing
    bending = rail.youngs_modulus * rail.vertical_second_moment
    shear = rail.vertical_shear_coefficient * rail.shear_modulus * rail.area
    base = (p.fastener.vertical_stiffness + 1j * omega * p.fastener.vertical_damping) / bay
    mass, rotary = rail.density * rail.area, rail.density * rail.vertical_second_moment

    def response(k):
        turn = shear + bending * k**2 - rotary * omega**2
        return 1.0 / (base - mass * omega**2 + shear * k**2 - (shear * k) ** 2 / turn) / np.pi

    def integral(part):
        near = quad(lambda k: part(response(k)), 0.0, 8.0, limit=400, epsrel=1e-10)[0]
        return near + quad(lambda k: part(response(k)), 8.0, np.inf, limit=400, epsrel=1e-10)[0]

    return integral(np.real) + 1j * integral(np.imag)


def test_winkler_limit_with_close_fasteners_on_rigid_slabs():
    bay = 0.1
    p = with_values(
        HD,
        {
            "fastener.spacing": bay,
            "fastener.count_per_slab": 40,
            "fastener.vertical_stiffness": 40e6 * bay / 0.629,
            "fastener.vertical_damping": 52e3 * bay / 0.629,
            "window.slab_count": 7,
            "rail.mode_count": 400,
            "slab_support.vertical_stiffness": 1e16,
        },
    )
    f = np.array([0.0, 40.0, 120.0, 165.0, 400.0])
    found = receptance(p, f, [middle(p).mid_bay])
    wanted = np.array([winkler(p, value) for value in f])
    # At rest: P/(8 E I beta^3) with the shear's share, 0.7089 mm under 69.21 kN.
    assert 69.21e3 * wanted[0].real == pytest.approx(0.7089e-3, rel=2e-4)
    assert relative(found.same_rail[:, 0, 0], wanted).max() < 1e-3
    # On rigid slabs the other rail does not know of it.
    assert np.abs(found.other_rail).max() < 1e-4 * np.abs(wanted).min()


# -- refusals ----------------------------------------------------------------------


def test_places_outside_the_window_are_refused():
    with pytest.raises(ParameterError, match=r"receivers = 90.*from 0 to 80.512 m.*slab_count"):
        receptance(HD, 50.0, [30.0], [90.0])


def test_negative_frequencies_are_refused():
    with pytest.raises(ParameterError, match=r"frequency = -1.*at least 0 Hz"):
        receptance(HD, [5.0, -1.0], [30.0])


def test_a_ring_has_no_static_compliance():
    p = with_values(HD, {"window.method": "cyclic"})
    with pytest.raises(ParameterError, match=r"frequency = 0.*above 0 Hz.*cyclic"):
        receptance(p, 0.0, [30.0])


def test_held_rails_do_not_move_sideways():
    p = with_values(HD, {"rail.motion": "vertical"})
    assert not receptance(p, 50.0, [30.0]).lateral.any()
