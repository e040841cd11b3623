"""The compiled step against dense matrices, energy, symmetry, and the slide."""

import numpy as np
import pytest
import scipy.linalg
from dense_track import dense_track, field_energy
from slab_track import TrackModel, TrackParameters
from slab_track.contact import ContactParameters
from slab_track.equilibrium import rails_at_rest
from slab_track.kernel import kernel_table
from slab_track.kernels.distance import between, to_fasteners
from slab_track.parameters import Fastener, Integration, Rail, Slab, SlabSupport, Window
from slab_track.slide import sample_points, slide_operator, slide_rail

SMALL = TrackParameters(
    rail=Rail(mode_count=60, residual_compliance=False),
    slab=Slab(mode_count=12, residual_compliance=False),
    window=Window(slab_count=4, method="moving_mass"),
    interface="applied_force",
    wheelset_count=1,
    static_wheel_load=0.0,
)


def vertical(force):
    """Vertical forces (2,) on both rail heads as the model takes them, (1, 2, 3)."""
    load = np.zeros((1, 2, 3))
    load[0, :, 1] = force
    return load


def deflection(track, q_rail, positions):
    """Deflection of a rail at positions in the window, from its modal coordinates."""
    return track.wave_shapes(positions).T @ np.sum(track.rail.deflection * q_rail, axis=0)


def _motion(x, speed=0.0):
    row = np.zeros((1, 11))
    row[0, 0], row[0, 5] = x, speed
    return row


def _applied(parameters, force, x, steps, dt):
    """Rail deflection under a wheelset whose rails take a force(t) (2,)."""
    model = TrackModel(parameters)
    state = model.initial_state(_motion(x))
    found = []
    for n in range(1, steps + 1):
        state, out = model.step(state, _motion(x), dt, applied_force=vertical(force(n * dt)))
        found.append(out.rail_deflection[0])
    return np.array(found), state


def _dense_response(parameters, force, x, times):
    """Exact response to a force that is linear in time: matrix exponential."""
    dense = dense_track(parameters)
    model = TrackModel(parameters)
    local = x - model.initial_state(_motion(x)).window_start
    rows = dense.wheel_rows(np.array([local]))
    n = dense.stiffness.shape[0]
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-dense.stiffness, -dense.damping]])
    load = np.zeros((2 * n, 2))
    load[n:] = rows.T @ np.stack([force(0.0), force(1.0) - force(0.0)], axis=1)
    augmented = np.zeros((2 * n + 2, 2 * n + 2))
    augmented[: 2 * n, : 2 * n] = system
    augmented[: 2 * n, 2 * n :] = load
    augmented[2 * n + 1, 2 * n] = 1.0  # d(t)/dt = 1
    z = np.zeros(2 * n + 2)
    z[2 * n] = 1.0
    propagate = scipy.linalg.expm(augmented * (times[1] - times[0]))
    found = []
    for _ in times:
        z = propagate @ z
        found.append(rows @ z[:n])
    return np.array(found)


def test_step_solves_the_dense_equations_with_second_order():
    def force(t):
        return np.array([3e4, 5e4]) * 50.0 * t  # unequal ramps: both symmetry classes

    errors = []
    for dt in (2e-4, 1e-4, 5e-5):
        parameters = SMALL.replace(
            integration=Integration(maximum_step=dt), slab=SMALL.slab.replace(damping_ratio=0.3)
        )
        steps = round(0.01 / dt)
        times = dt * np.arange(1, steps + 1)
        found, _ = _applied(parameters, force, 0.4, steps, dt)
        exact = _dense_response(parameters, force, 0.4, times)
        errors.append(np.max(np.abs(found - exact)) / np.max(np.abs(exact)))
    assert errors[-1] < 2e-4
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.15)


def test_long_hold_reaches_the_static_solution_of_the_dense_matrices():
    load = np.array([2e4, 6e4])
    found, _ = _applied(SMALL, lambda _t: load, -0.1, 4000, 1e-3)
    dense = dense_track(SMALL)
    model = TrackModel(SMALL)
    local = -0.1 - model.initial_state(_motion(-0.1)).window_start
    rows = dense.wheel_rows(np.array([local]))
    static = rows @ np.linalg.solve(dense.stiffness, rows.T @ load)
    np.testing.assert_allclose(found[-1], static, rtol=1e-6)


def test_rails_at_rest_are_the_static_solution_of_the_dense_matrices():
    """Under unlike loads on both rails, of which each sinks by its own."""
    load, local = np.array([2e4, 6e4]), 9.3
    force = np.zeros((1, 2, 3))
    force[0, :, 1] = load
    model, dense = TrackModel(SMALL), dense_track(SMALL)
    rows = dense.wheel_rows(np.array([local]))
    static = rows @ np.linalg.solve(dense.stiffness, rows.T @ load)
    found = rails_at_rest(model.linear, None, np.array([local]), force).motion
    np.testing.assert_allclose(found[0, :, 1], static, rtol=1e-9)
    assert static[1] > 2.0 * static[0]


def test_the_unloaded_rail_is_moved_by_the_slabs_within_the_step():
    """What is told of it is what its modes say, from the first step on."""
    model = TrackModel(SMALL)
    state = model.initial_state(_motion(0.4))
    for _ in range(4):
        push = vertical(np.array([0.0, 5e4]))
        state, out = model.step(state, _motion(0.4), 1e-4, applied_force=push)
        left = np.sqrt(0.5) * (state.symmetric.rail[0] - state.antisymmetric.rail[0])
        place = np.array([0.4 - state.window_start])
        told, wanted = out.rail_deflection[0, 0], deflection(model.linear, left, place)[0]
        assert wanted != 0.0
        assert told == pytest.approx(wanted, rel=0.02)


def test_energy_of_the_undamped_track_is_kept_by_free_vibration():
    parameters = SMALL.replace(
        fastener=Fastener(vertical_damping=0.0),
        slab_support=SlabSupport(vertical_damping=0.0),
    )
    model = TrackModel(parameters)
    state = model.initial_state(_motion(0.0))
    for n in range(60):
        push = vertical(np.array([4e4, 1e4]) if n < 20 else np.zeros(2))
        state, _ = model.step(state, _motion(0.0), 1e-4, applied_force=push)
        if n == 20:
            energy = field_energy(model.linear, state)
    for _ in range(2000):
        state, _ = model.step(state, _motion(0.0), 1e-4, applied_force=vertical(0.0))
    assert energy > 1.0
    assert field_energy(model.linear, state) == pytest.approx(energy, rel=1e-9)


def test_work_of_the_force_is_the_energy_of_the_undamped_track():
    parameters = SMALL.replace(
        fastener=Fastener(vertical_damping=0.0),
        slab_support=SlabSupport(vertical_damping=0.0),
        integration=Integration(maximum_step=1e-5),
    )
    model = TrackModel(parameters)
    state = model.initial_state(_motion(0.0))
    work, before, force = 0.0, np.zeros(2), np.zeros(2)
    for n in range(1, 400):
        new = np.array([4e4, 1e4]) * np.sin(np.pi * n / 400) ** 2
        state, out = model.step(state, _motion(0.0), 1e-5, applied_force=vertical(new))
        work += float(np.sum(0.5 * (force + new) * (out.rail_deflection[0] - before)))
        before, force = out.rail_deflection[0], new
    assert work > 1.0
    assert field_energy(model.linear, state) == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("at_end", [False, True])
def test_wheels_are_where_their_motion_leads_at_the_end_of_a_step(at_end):
    """Extrapolated over both internal steps, or given for the end."""
    model, dt = TrackModel(SMALL), 2e-4
    state = model.initial_state(_motion(0.1, speed=50.0))
    for n in range(1, 4):
        motion = _motion(0.1 + 50.0 * dt * (n if at_end else n - 1), speed=50.0)
        state, _ = model.step(state, motion, dt, at_end=at_end, applied_force=vertical(np.zeros(2)))
        assert state.time == pytest.approx(n * dt, rel=1e-12)
        assert state.wheel_positions == pytest.approx([0.1 + 50.0 * n * dt], rel=1e-12)


def test_damping_only_takes_energy():
    model = TrackModel(SMALL)
    state = model.initial_state(_motion(0.0))
    energies = []
    for n in range(400):
        push = vertical(np.array([4e4, 1e4]) if n < 20 else np.zeros(2))
        state, _ = model.step(state, _motion(0.0), 1e-4, applied_force=push)
        if n >= 20:
            energies.append(field_energy(model.linear, state))
    assert np.all(np.diff(energies) < 1e-12 * energies[0])
    assert energies[-1] < 0.5 * energies[0]


def test_mirrored_forces_give_mirrored_motion():
    def force(t):
        return np.array([5e4, 1e4]) * np.sin(300 * t)

    left, _ = _applied(SMALL, force, 0.2, 200, 1e-4)
    right, _ = _applied(SMALL, lambda t: force(t)[::-1], 0.2, 200, 1e-4)
    np.testing.assert_allclose(left, right[:, ::-1], rtol=0, atol=1e-12 * np.max(np.abs(left)))


def test_kernel_equals_the_sum_over_modes():
    track = TrackModel(SMALL).linear
    bays, length = track.fastener_count, track.length
    weights = 1.0 / np.arange(1, 301) ** 2
    table = kernel_table(weights, bays)
    wave = np.pi * np.arange(1, 301) / length
    fasteners = (np.arange(bays) + 0.5) * length / bays
    for x in (3.21, 10.0, 17.777):
        found = np.empty(bays)
        to_fasteners(table, x / length * bays, found)
        exact = np.sin(np.outer(fasteners, wave)) @ (weights * np.sin(wave * x))
        np.testing.assert_allclose(found, exact, atol=1e-6)
        other = np.sum(weights * np.sin(wave * x) * np.sin(wave * 9.5))
        assert between(table, x / length * bays, 9.5 / length * bays, False) == pytest.approx(
            other, abs=1e-6
        )


@pytest.mark.parametrize("count", [200, 400])
def test_slide_moves_a_compact_field_and_its_rotation(count):
    parameters = TrackParameters(rail=Rail(mode_count=count))
    model = TrackModel(parameters)
    rail, length, pitch = model.linear.rail, parameters.window_length, parameters.pitch
    bump = np.exp(-0.5 * ((np.linspace(0, length, 40001) - 30.0) / 0.6) ** 2)
    x = np.linspace(0, length, 40001)
    wave = np.sin(np.outer(rail.wave_number, x)) @ bump * (2 / length) * (x[1] - x[0])
    # A pure bending field: coordinates of the lower branch.
    q = np.zeros((2, count))
    q[0] = wave / rail.deflection[0]
    moved = slide_rail(rail, model.slide, q)
    points = np.linspace(8.0, 55.0, 200)
    np.testing.assert_allclose(
        deflection(model.linear, moved, points),
        deflection(model.linear, q, points + pitch),
        atol=1e-6,
    )
    psi_old = np.cos(np.outer(points + pitch, rail.wave_number)) @ np.sum(rail.rotation * q, axis=0)
    psi_new = np.cos(np.outer(points, rail.wave_number)) @ np.sum(rail.rotation * moved, axis=0)
    np.testing.assert_allclose(psi_new, psi_old, atol=1e-5 * np.max(np.abs(psi_old)))


def test_least_squares_slide_is_the_minimum_of_equation_11():
    rail = TrackModel(SMALL).linear.rail
    length, shift = SMALL.window_length, SMALL.pitch
    operator = slide_operator(
        rail, length=length, shift=shift, sample_count=90, solver="least_squares"
    )
    points = sample_points(length, 90)
    phi = np.sin(np.outer(points, rail.wave_number))
    target = (
        np.sin(np.outer(points + shift, rail.wave_number)) * (points + shift <= length)[:, None]
    )
    expected = np.linalg.lstsq(phi, target, rcond=None)[0]
    np.testing.assert_allclose(operator.deflection(np.eye(60)).T, expected, atol=1e-9)


def test_a_resting_pair_of_rails_stays_at_rest():
    """Static equilibrium is an equilibrium of the step as well, with residual compliance."""
    model = TrackModel(TrackParameters(wheelset_count=1, interface="applied_force"))
    state = model.initial_state(_motion(0.13))
    before = state.rail_deflection.copy()
    load = vertical(model.parameters.static_wheel_load)
    for _ in range(50):
        state, out = model.step(state, _motion(0.13), 1e-4, applied_force=load)
    np.testing.assert_allclose(out.rail_deflection, before, rtol=1e-6)


@pytest.mark.parametrize("residual", [False, True])
def test_level_contact_obeys_hertz_s_law_on_unequally_loaded_rails(residual):
    """Eq. (1) between the forces and the rails' motion of the same instant, rails far from alike.

    Forces are found before the rails are moved by them: what both do to each other within the step
    must be in the solution, for the two rails of a rolled wheelset too.
    """
    parameters = SMALL.replace(
        rail=Rail(mode_count=60, residual_compliance=residual),
        interface="contact",
        contact=ContactParameters(model="vertical"),
        wheelset_count=2,
        static_wheel_load=7e4,
    )
    model = TrackModel(parameters)
    motion = np.zeros((2, 11))
    motion[:, 0], motion[:, 5] = (3.0, 0.5), 50.0
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    state = model.with_motion(state, motion)
    lever = 0.5 * parameters.contact.rolling_circle_distance * np.array([-1.0, 1.0])
    constant = parameters.contact.hertz_constant_used
    resting = motion[:, 2, None] + state.datum - state.rail_deflection
    np.testing.assert_allclose(state.normal_force, (resting / constant) ** 1.5, rtol=1e-9)
    motion[:, 3] = 4e-5, -2e-5
    for _ in range(5):
        motion[:, 0] += 50.0 * 1e-4
        state, out = model.step(state, motion, 1e-4, at_end=True)
        height = motion[:, 2, None] + state.datum + lever * motion[:, 3, None]
        penetration = height - out.rail_deflection
        assert np.ptp(out.normal_force[0]) > 5e3
        np.testing.assert_allclose(out.normal_force, (penetration / constant) ** 1.5, rtol=1e-9)
        np.testing.assert_allclose(out.contact[:, 2], -out.normal_force.sum(axis=1), rtol=1e-12)
        np.testing.assert_allclose(out.contact[:, 3], -out.normal_force @ lever, rtol=1e-12)
