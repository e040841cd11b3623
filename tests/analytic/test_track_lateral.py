"""Lateral bending and torsion of the rails: closed forms, dense matrices, energy."""

import numpy as np
import pytest
import scipy.linalg
from dense_lateral import dense_lateral
from slab_track import TrackModel, TrackParameters
from slab_track.equilibrium import rails_at_rest, unit_compliance
from slab_track.kernels.lateral import wheel_compliance
from slab_track.lateral import assemble_lateral, lateral_operator, static_rail
from slab_track.parameters import Fastener, Integration, Rail, Slab, Window

RAIL = Rail()
EI = RAIL.youngs_modulus * RAIL.lateral_second_moment
KGA = RAIL.lateral_shear_coefficient * RAIL.shear_modulus * RAIL.area
GK = RAIL.torsional_stiffness
LATERAL, VERTICAL, MOMENT = range(3)

SMALL = TrackParameters(
    rail=Rail(mode_count=40, residual_compliance=False),
    slab=Slab(mode_count=12, residual_compliance=False),
    window=Window(slab_count=4, method="moving_mass"),
    interface="applied_force",
    wheelset_count=1,
    static_wheel_load=0.0,
)
UNDAMPED = SMALL.replace(fastener=Fastener(vertical_damping=0.0, lateral_damping=0.0))
LOOSE = SMALL.replace(
    fastener=Fastener(
        vertical_stiffness=1e-3, lateral_stiffness=1e-3, vertical_damping=0.0, lateral_damping=0.0
    ),
    integration=Integration(maximum_step=1e-3),
)


def motion_at(x):
    row = np.zeros((1, 11))
    row[0, 0] = x
    return row


def head_forces(left, right):
    """Return forces on both heads (lateral, vertical, roll moment) as the model takes them."""
    return np.array([[left, right]], dtype=float)


def run(parameters, force, x, steps, dt):
    """Head displacement and roll (steps, 2 rails, 2), and the last state."""
    model = TrackModel(parameters)
    state = model.initial_state(motion_at(x))
    found = []
    for n in range(1, steps + 1):
        state, out = model.step(state, motion_at(x), dt, applied_force=force(n * dt))
        found.append(np.stack([out.rail_lateral[0], out.rail_roll[0]], axis=1))
    return np.array(found), state, model


# -- free rail ---------------------------------------------------------------


def bending_roots(k):
    """Both squared frequencies of a hinged Timoshenko beam, from its frequency equation."""
    e, g = RAIL.youngs_modulus / RAIL.density, RAIL.lateral_shear_coefficient * RAIL.shear_modulus
    g /= RAIL.density
    b = g * (k**2 + RAIL.area / RAIL.lateral_second_moment) + e * k**2
    return np.sort(np.roots([1.0, -b, e * g * k**4]).real)


def test_frequencies_of_a_free_hinged_rail():
    lateral = assemble_lateral(LOOSE)
    k = np.pi / LOOSE.window_length * np.arange(1, 41)
    roots = np.array([bending_roots(x) for x in k]).T
    np.testing.assert_allclose(lateral.bending.omega_squared, roots, rtol=1e-6)
    torsion = k * np.sqrt(GK / (RAIL.density * RAIL.polar_second_moment))
    np.testing.assert_allclose(np.sqrt(lateral.torsion_omega_squared), torsion, rtol=1e-12)


@pytest.mark.parametrize(("branch", "wave"), [(0, 5), (0, 24), (1, 3), (2, 2), (2, 17)])
def test_loose_rail_rings_at_the_closed_frequency(branch, wave):
    """The compiled step on fasteners without any stiffness, one wave set free from rest."""
    model = TrackModel(LOOSE)
    k = np.pi / LOOSE.window_length * wave
    if branch == 2:
        omega = k * np.sqrt(GK / (RAIL.density * RAIL.polar_second_moment))
    else:
        omega = np.sqrt(bending_roots(k)[branch])
    step = 2.0 * np.pi / omega / 200
    x = 0.37
    state = model.initial_state(motion_at(x))
    state.rails[1, 0, branch, wave - 1] = 1.0
    state.rails[1, 2, branch, wave - 1] = -(omega**2)
    # The trapezoidal rule lengthens the period by its known amount.
    expected = 2.0 / step * np.arctan(0.5 * omega * step)
    steps = 1000
    found = []
    for _ in range(steps):
        state, out = model.step(
            state, motion_at(x), step, applied_force=head_forces([0, 0, 0], [0, 0, 0])
        )
        found.append((out.rail_roll if branch == 2 else out.rail_lateral)[0, 1])
    assert np.all(out.rail_lateral[0, 0] == 0.0)
    time = step * np.arange(1, steps + 1)
    wave_form = np.stack([np.cos(expected * time), np.sin(expected * time)], axis=1)
    part, *_ = np.linalg.lstsq(wave_form, np.array(found))
    np.testing.assert_allclose(wave_form @ part, found, atol=2e-5 * np.max(np.abs(found)), rtol=0.0)
    assert abs(part[1]) < 1e-4 * abs(part[0])


# -- static ------------------------------------------------------------------


def continuous_flexibility(count=400_001):
    """Displacement and roll of the axis per force and moment there, (2, 2), infinite rail.

    Timoshenko beam and torsion bar on a continuous bedding at the foot, by Fourier integral.
    """
    lateral, turn = 15e6 / 0.629, 40e6 * 0.150**2 / 4.0 / 0.629
    foot, k = RAIL.axis_height, np.linspace(1e-6, 400.0, count)
    beam = 1.0 / (1.0 / (EI * k**4) + 1.0 / (KGA * k**2))
    a, b, c = beam + lateral, -foot * lateral, GK * k**2 + turn + foot**2 * lateral
    det = a * c - b * b
    yy, yr, rr = (np.trapezoid(v, k) / np.pi for v in (c / det, -b / det, a / det))
    # Beyond the last wave number only shear and torsion answer, with 1/k^2.
    return np.array([[yy + 1.0 / (np.pi * KGA * 400.0), yr], [yr, rr + 1 / (np.pi * GK * 400.0)]])


CLOSE_SEATS = TrackParameters(
    fastener=Fastener(
        spacing=0.1,
        count_per_slab=40,
        vertical_stiffness=40e6 * 0.1 / 0.629,
        lateral_stiffness=15e6 * 0.1 / 0.629,
    ),
    slab=Slab(gap=0.05, mode_count=12),
    window=Window(slab_count=10, method="moving_mass"),
    wheelset_count=1,
)


def test_rail_roll_under_an_eccentric_load():
    """Wheel load 12 mm off the rail's axis and 20 kN lateral force at the head."""
    model = TrackModel(CLOSE_SEATS)
    vertical, force, eccentric = 69.21e3, 20e3, 0.012
    axis = np.zeros((1, 2, 3))
    axis[0, 1] = force, vertical, vertical * eccentric + force * RAIL.axis_depth
    rest = rails_at_rest(model.linear, model.lateral, np.array([20.03]), axis)
    expected = continuous_flexibility() @ axis[0, 1, [LATERAL, MOMENT]]
    np.testing.assert_allclose(rest.motion[0, 1, [0, 2]], expected, rtol=1e-3)
    head = rest.motion[0, 1, 0] + RAIL.axis_depth * rest.motion[0, 1, 2]
    assert head == pytest.approx(expected[0] + RAIL.axis_depth * expected[1], rel=1e-3)
    assert 0.5e-3 < head < 3e-3
    assert np.all(rest.motion[0, 0, [0, 2]] == 0.0)
    # Vertical load and lateral motion do not mix.
    axis[0, 1, [LATERAL, MOMENT]] = 0.0
    upright = rails_at_rest(model.linear, model.lateral, np.array([20.03]), axis)
    assert upright.motion[0, 1, 1] == rest.motion[0, 1, 1]
    assert np.all(upright.motion[0, 1, [0, 2]] == 0.0)


def test_static_flexibility_is_symmetric():
    """Maxwell and Betti over both rails, all directions and two wheelsets."""
    model = TrackModel(TrackParameters(wheelset_count=2))
    places = np.array([31.3, 33.8])

    def rest(force):
        return rails_at_rest(model.linear, model.lateral, places, force).motion

    matrix = unit_compliance(rest, 2).reshape(12, 12)
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-9 * np.max(np.abs(matrix)))
    assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_static_rail_is_the_dense_solution_without_residual():
    dense = dense_lateral(SMALL)
    for x in (9.41, 10.0):
        rows, force = dense.rows(x), np.array([20e3, -3e3])
        _, found = static_rail(assemble_lateral(SMALL), np.array([x]), force[None])
        exact = rows @ np.linalg.solve(dense.stiffness, rows.T @ force)
        np.testing.assert_allclose(found[0], exact, rtol=1e-9)


def test_residual_compliance_makes_few_modes_as_soft_as_many():
    places, force = np.array([31.3]), np.array([[20e3, 2e3]])
    _, few = static_rail(
        assemble_lateral(TrackParameters(rail=Rail(mode_count=600))), places, force
    )
    many = Rail(mode_count=4000, residual_compliance=False)
    _, exact = static_rail(assemble_lateral(TrackParameters(rail=many)), places, force)
    np.testing.assert_allclose(few, exact, rtol=5e-3)


# -- step --------------------------------------------------------------------


def ramp(time):
    """Unequal ramps of lateral force and roll moment on both heads; no vertical force."""
    return 50.0 * time * head_forces([2e4, 0.0, -1.5e3], [-1e4, 0.0, 2.5e3])


def dense_response(parameters, x, steps, dt):
    """Exact answer of both heads to :func:`ramp`, (steps, 2 rails, 2): matrix exponential."""
    dense, model = dense_lateral(parameters), TrackModel(parameters)
    rows = dense.rows(x - model.initial_state(motion_at(x)).window_start)
    n, depth = dense.mass.shape[0], parameters.rail.axis_depth
    to_head = np.array([[1.0, depth], [0.0, 1.0]])
    inverse = 1.0 / np.diag(dense.mass)[:, None]
    system = np.zeros((2 * n + 2, 2 * n + 2))
    system[:n, n : 2 * n] = np.eye(n)
    system[n : 2 * n, :n], system[n : 2 * n, n : 2 * n] = (
        -inverse * dense.stiffness, -inverse * dense.damping,
    )  # fmt: skip
    system[2 * n + 1, 2 * n] = 1.0
    found = np.empty((steps, 2, 2))
    for side in (0, 1):
        load = rows.T @ (to_head.T @ ramp(1.0)[0, side, [LATERAL, MOMENT]])
        system[n : 2 * n, 2 * n + 1] = inverse[:, 0] * load
        propagate = scipy.linalg.expm(system * dt)
        z = np.zeros(2 * n + 2)
        z[2 * n] = 1.0
        for i in range(steps):
            z = propagate @ z
            found[i, side] = to_head @ rows @ z[:n]
    return found


def test_lateral_step_solves_the_dense_equations_with_second_order():
    errors = []
    for dt in (2e-4, 1e-4, 5e-5):
        parameters = SMALL.replace(integration=Integration(maximum_step=dt))
        steps = round(0.01 / dt)
        found, *_ = run(parameters, ramp, 0.4, steps, dt)
        exact = dense_response(parameters, 0.4, steps, dt)
        scale = np.max(np.abs(exact), axis=(0, 1))
        errors.append(np.max(np.abs(found - exact) / scale, axis=(0, 1)))
    assert np.all(errors[-1] < 1e-3)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.3)


def test_rates_under_a_standing_wheel_are_those_of_the_displacements():
    """By the trapezoidal rule: the mean of two rates is the difference of the displacements."""
    model, dt = TrackModel(SMALL), 1e-4
    state = model.initial_state(motion_at(0.4))
    before = state.wheels.rail.copy()
    for n in range(1, 60):
        force = ramp(n * dt) + head_forces([0.0, 2e6 * n * dt, 0.0], [0.0, 1e6 * n * dt, 0.0])
        state, _ = model.step(state, motion_at(0.4), dt, applied_force=force)
        now = state.wheels.rail
        mean, scale = 0.5 * (now + before)[..., 3:], np.abs(now[..., 3:]).max(axis=(0, 1))
        assert np.all(scale > 0.0)
        difference = (now - before)[..., :3] / dt
        np.testing.assert_allclose(mean / scale, difference / scale, rtol=0, atol=1e-3)
        before = now.copy()


def test_long_hold_reaches_the_dense_static_solution():
    load = head_forces([2e4, 0.0, 1e3], [0.0, 0.0, -4e3])
    found, state, model = run(SMALL, lambda _t: load, 0.1, 1600, 1e-3)
    dense = dense_lateral(SMALL)
    rows = dense.rows(0.1 - state.window_start)
    to_head = np.array([[1.0, RAIL.axis_depth], [0.0, 1.0]])
    matrix = to_head @ rows @ np.linalg.solve(dense.stiffness, rows.T @ to_head.T)
    for side in (0, 1):
        exact = matrix @ load[0, side, [LATERAL, MOMENT]]
        inside = to_head @ rows @ dense.amplitudes(model.lateral, state.rails[side, 0])
        np.testing.assert_allclose(inside, exact, rtol=1e-5)
        # What is told adds the last step's wheel force through the table.
        np.testing.assert_allclose(found[-1, side], exact, rtol=3e-4)


def rail_energy(parameters, model, state):
    dense = dense_lateral(parameters)
    return sum(
        dense.energy(*(dense.amplitudes(model.lateral, rail[i]) for i in (0, 1)))
        for rail in state.rails
    )


def test_work_of_head_forces_is_the_energy_of_the_undamped_rails():
    parameters = UNDAMPED.replace(integration=Integration(maximum_step=1e-5))
    model = TrackModel(parameters)
    state = model.initial_state(motion_at(0.2))
    work, before, last = 0.0, np.zeros((2, 2)), np.zeros((2, 2))
    for n in range(1, 401):
        pulse = np.sin(np.pi * n / 400) ** 2
        force = pulse * head_forces([2e4, 0.0, 1e3], [-1e4, 0.0, 3e3])
        state, out = model.step(state, motion_at(0.2), 1e-5, applied_force=force)
        place = np.stack([out.rail_lateral[0], out.rail_roll[0]], axis=1)
        new = force[0][:, [LATERAL, MOMENT]]
        work += float(np.sum(0.5 * (new + last) * (place - before)))
        before, last = place, new
    stored = rail_energy(parameters, model, state)
    assert stored == pytest.approx(work, rel=1e-4)
    assert work > 0.1
    for _ in range(2000):
        state, _ = model.step(state, motion_at(0.2), 1e-5, applied_force=np.zeros((1, 2, 3)))
    assert rail_energy(parameters, model, state) == pytest.approx(stored, rel=1e-9)


def test_fastener_damping_only_takes_energy():
    _, state, model = run(SMALL, ramp, 0.2, 40, 1e-4)
    energies = []
    # In the step in which the force ends, half of it still works.
    for _ in range(201):
        state, _ = model.step(state, motion_at(0.2), 1e-4, applied_force=np.zeros((1, 2, 3)))
        energies.append(rail_energy(SMALL, model, state))
    assert np.all(np.diff(energies) < 1e-12 * energies[0])
    assert energies[-1] < 0.5 * energies[0]


@pytest.mark.parametrize(
    ("x", "tolerance"),
    [
        (33.0225 + 0.629 * 19 / 64, 1e-8),  # a place of the table, in the middle
        (33.0225 + 0.629 * 30.4 / 64, 1e-4),  # between two places
        (31.27, 3e-3),  # elsewhere: the truncated series has ripples of 1/N
        (12.0, 3e-3),
    ],
)
def test_tabulated_wheel_compliance_is_that_of_the_dense_step(x, tolerance):
    """Trapezoidal rule: h^2/4 (M + h/2 C + h^2/4 K)^-1 under the wheel, at any phase."""
    parameters = TrackParameters(rail=Rail(mode_count=300), window=Window(slab_count=13))
    step = 5e-5
    dense = dense_lateral(parameters)
    rows = dense.rows(x)
    system = dense.mass + 0.5 * step * dense.damping + 0.25 * step**2 * dense.stiffness
    exact = 0.25 * step**2 * rows @ scipy.linalg.solve(system, rows.T, assume_a="pos")
    found = np.empty(3)
    operator = lateral_operator(assemble_lateral(parameters), step)
    wheel_compliance(operator.compliance, operator.spacing, x, found)
    np.testing.assert_allclose(found[[0, 2]], exact[[0, 1], [0, 1]], rtol=tolerance)
    # Only the fasteners couple y and roll: within one step far below the geometric mean.
    scale = np.sqrt(exact[0, 0] * exact[1, 1])
    assert found[1] == pytest.approx(exact[0, 1], abs=tolerance * scale)
    assert abs(exact[0, 1]) > 1e-3 * scale


def test_held_rails_do_not_move_sideways():
    held = SMALL.replace(rail=Rail(mode_count=40, residual_compliance=False, motion="vertical"))
    found, state, _ = run(held, ramp, 0.2, 20, 1e-4)
    assert np.all(found == 0.0)
    assert np.all(state.rails == 0.0)


def test_slide_carries_lateral_and_torsional_waves_along():
    """A rail pushed sideways in a sliding window answers as in a fixed one, past slides."""
    speed, dt = 60.0, 1e-4
    found = []
    for method, slabs in (("moving_mass", 20), ("sliding", 13)):
        p = TrackParameters(
            rail=Rail(mode_count=50 * slabs),
            window=Window(slab_count=slabs, method=method),
            interface="applied_force",
            wheelset_count=1,
            static_wheel_load=0.0,
        )
        model = TrackModel(p)
        state = model.initial_state(motion_at(0.0))
        rows = []
        for n in range(round(12.0 / speed / dt)):
            motion = motion_at(speed * n * dt)
            motion[0, 5] = speed
            load = head_forces([2e4, 0, 1e3], [-1e4, 0, 2e3]) * min(1.0, n * dt * 20.0)
            state, out = model.step(state, motion, dt, applied_force=load)
            rows.append(np.r_[out.rail_lateral[0], out.rail_roll[0]])
        found.append(np.array(rows))
    assert state.slide_count >= 2
    scale = np.max(np.abs(found[0]), axis=0)
    assert np.max(np.abs(found[1] - found[0]) / scale) < 0.01
