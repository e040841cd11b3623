"""Free motion of the vehicle: frequencies, balances and symmetries against theory."""

import numpy as np
import pytest
from rail_vehicle import PAPER, SOFT_PRIMARY, VehicleModel
from rail_vehicle.coordinates import FREE, WHEELSET_COORDINATES
from vehicle_reference import mirror, state_with

UNDAMPED = PAPER.replace(
    primary_suspension=PAPER.primary_suspension.replace(
        vertical_damping=0.0, longitudinal_damping=0.0, lateral_damping=0.0
    ),
    secondary_suspension=PAPER.secondary_suspension.replace(
        vertical_damping=0.0, longitudinal_damping=0.0, lateral_damping=0.0
    ),
    lateral_damper=PAPER.lateral_damper.replace(damping=0.0),
    yaw_damper=PAPER.yaw_damper.replace(damping=0.0),
)


def frequencies_on_held_wheelsets(parameters, pattern):
    """Eigenfrequencies in Hz of modes that a load pattern (50,) can excite, wheelsets held."""
    system = VehicleModel(parameters).linear_system()
    loose = np.setdiff1d(FREE, WHEELSET_COORDINATES.ravel())
    root_mass = np.sqrt(np.diag(system.mass)[loose])
    scaled = system.stiffness[np.ix_(loose, loose)] / np.outer(root_mass, root_mass)
    squares, shapes = np.linalg.eigh(scaled)
    share = np.abs(shapes.T @ (pattern[loose] / root_mass))
    return np.sqrt(squares[share > 1e-3 * share.max()]) / (2.0 * np.pi)


def two_mass_frequencies(mass, stiffness):
    squares = np.linalg.eigvals(np.linalg.solve(np.array(mass), np.array(stiffness)))
    return np.sort(np.sqrt(squares)) / (2.0 * np.pi)


@pytest.mark.parametrize(("parameters", "about"), [(PAPER, 19.6), (SOFT_PRIMARY, 6.46)])
def test_bounce_of_car_body_and_bogies(parameters, about):
    pattern = np.zeros(50)
    pattern[2] = 1.0
    primary = 8.0 * parameters.primary_suspension.vertical_stiffness
    secondary = 4.0 * parameters.secondary_suspension.vertical_stiffness
    expected = two_mass_frequencies(
        [[parameters.car_body.mass, 0.0], [0.0, 2.0 * parameters.bogie.mass]],
        [[secondary, -secondary], [-secondary, primary + secondary]],
    )
    found = frequencies_on_held_wheelsets(parameters, pattern)
    assert found[[0, -1]] == pytest.approx(expected, rel=1e-9)
    assert found[-1] == pytest.approx(about, rel=0.01)


def test_pitch_of_the_car_body():
    # By hand without the 1 % that longitudinal stiffness and toppling weight make together.
    pattern = np.zeros(50)
    pattern[4] = 1.0
    half, car = PAPER.car_body.half_bogie_spacing, PAPER.car_body.pitch_inertia
    primary, secondary = 8.0 * 9.0e6 * half**2, 4.0 * 0.24e6 * half**2
    expected = two_mass_frequencies(
        [[car, 0.0], [0.0, 2.0 * PAPER.bogie.mass * half**2]],
        [[secondary, -secondary], [-secondary, primary + secondary]],
    )[0]
    found = frequencies_on_held_wheelsets(PAPER, pattern)[0]
    assert found == pytest.approx(expected, rel=0.015)


def test_pitch_of_the_bogie_with_its_axle_boxes():
    pattern = np.zeros(50)
    pattern[[10, 16]] = 1.0, -1.0
    springs = 4.0 * 9.0e6
    expected = two_mass_frequencies(
        [[1846.0, 0.0], [0.0, 4.0 * 3.9]],
        [[springs * (1.25**2 + 0.2**2), -springs * 0.2**2], [-springs * 0.2**2, springs * 0.2**2]],
    )
    found = frequencies_on_held_wheelsets(PAPER, pattern)
    for frequency in expected:
        assert np.abs(found / frequency - 1.0).min() < 0.005


def test_momentum_follows_the_contact_forces():
    model = VehicleModel(PAPER)
    rng = np.random.default_rng(1)
    state = state_with(model, rng.normal(size=50) * 1e-3, rng.normal(size=50) * 1e-2)
    mass = np.diag(model.linear_system().mass)
    start, steps, dt = state, 50, 1e-3
    impulse = np.zeros(3)
    for _ in range(steps):
        forces = model.static_forces + rng.normal(size=(4, 6)) * 1e3
        impulse += dt * (forces - model.static_forces)[:, :3].sum(axis=0)
        state, _ = model.step(state, forces, forces, dt)
    change = mass * (state.rates - start.rates)
    assert change[1:42:6].sum() == pytest.approx(impulse[1], rel=1e-9)
    assert change[2:42:6].sum() == pytest.approx(impulse[2], rel=1e-9)


def test_yaw_momentum_of_a_vehicle_without_weight_is_kept():
    parameters = PAPER.replace(gravity=0.0, speed=0.0)
    model = VehicleModel(parameters)
    rng = np.random.default_rng(2)
    state = state_with(model, rng.normal(size=50) * 1e-3, rng.normal(size=50) * 1e-2)
    mass = np.diag(model.linear_system().mass)
    x = np.array([0.0, 8.9, -8.9, 10.15, 7.65, -7.65, -10.15])

    def yaw_momentum(state):
        momentum = mass * state.rates
        return momentum[5:42:6].sum() + x @ momentum[1:42:6]

    before = yaw_momentum(state)
    for _ in range(100):
        state, _ = model.step(state, np.zeros((4, 6)), np.zeros((4, 6)), 1e-3)
    # The held car body takes longitudinal forces in its middle, which make no yaw moment.
    assert yaw_momentum(state) == pytest.approx(before, rel=1e-9)


def energy(model, state):
    system, stop = model.linear_system(), model.parameters.lateral_bump_stop
    q = state.coordinates * np.isin(np.arange(50), FREE)
    v = state.rates * np.isin(np.arange(50), FREE)
    elongation = np.abs(system.element_matrix.T @ q)[6:8]
    depth = np.maximum(elongation - stop.clearance, 0.0)
    stored = 0.5 * stop.stiffness * depth**2 + 0.25 * stop.cubic_stiffness * depth**4
    return 0.5 * v @ system.mass @ v + 0.5 * q @ system.stiffness @ q + stored.sum()


def drift_of_energy(parameters, dt, duration):
    """Largest change of energy as a share of the first, wheelsets rolling at 300 km/h."""
    model = VehicleModel(parameters)
    rates = np.zeros(50)
    rates[1], rates[5], rates[7], rates[20], rates[25], rates[33] = 0.25, 0.03, -0.2, 0.3, 0.1, 0.1
    state = state_with(model, None, rates)
    first, forces, worst, deepest = energy(model, state), model.static_forces, 0.0, 0.0
    for _ in range(round(duration / dt)):
        state, outputs = model.step(state, forces, forces, dt)
        worst = max(worst, abs(energy(model, state) / first - 1.0))
        deepest = max(deepest, abs(outputs["lateral_bump_stop[1].force"]))
    return worst, deepest


def test_energy_is_kept_without_damping():
    apart = UNDAMPED.replace(lateral_bump_stop=PAPER.lateral_bump_stop.replace(clearance=1.0))
    worst, force = drift_of_energy(apart, 1e-3, 0.3)
    assert force == 0.0
    assert worst < 1e-10


def test_energy_is_kept_by_the_stops_to_second_order():
    parameters = UNDAMPED.replace(
        lateral_bump_stop=PAPER.lateral_bump_stop.replace(clearance=0.002, stiffness=2.0e6)
    )
    coarse, force = drift_of_energy(parameters, 1e-3, 0.3)
    fine, _ = drift_of_energy(parameters, 2.5e-4, 0.3)
    assert force > 5.0e3
    assert fine < 2e-5
    assert fine < coarse / 8.0


def test_dampers_only_take_energy_out():
    model = VehicleModel(PAPER)
    rates = np.zeros(50)
    rates[[8, 13, 15]] = 0.2, 0.1, -0.2
    state = state_with(model, None, rates)
    energies = [energy(model, state)]
    for _ in range(200):
        state, _ = model.step(state, model.static_forces, model.static_forces, 1e-3)
        spring = 0.5 * np.sum(state.yaw_damper_forces**2) / PAPER.yaw_damper.series_stiffness
        energies.append(energy(model, state) + spring)
    assert np.diff(energies).max() < 1e-6 * energies[0]
    assert energies[-1] < 0.6 * energies[0]


def test_left_and_right_are_alike():
    model, swap = VehicleModel(PAPER), mirror()
    rng = np.random.default_rng(3)
    q, v = rng.normal(size=50) * 2e-3, rng.normal(size=50) * 5e-2
    q[0] = v[0] = 0.0
    one, other = state_with(model, q, v), state_with(model, swap @ q, swap @ v)
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    for _ in range(50):
        forces = model.static_forces + rng.normal(size=(4, 6)) * 2e3
        one, _ = model.step(one, forces, forces, 1e-3)
        other, _ = model.step(other, forces * signs, forces * signs, 1e-3)
    assert other.coordinates == pytest.approx(swap @ one.coordinates, abs=1e-12)
    assert other.yaw_damper_forces == pytest.approx(one.yaw_damper_forces[[1, 0, 3, 2]], abs=1e-6)


def test_spinning_wheelset_nutates():
    """A wheelset all but free of its bogie precesses at I_wy * spin / I_wx, roll leading yaw.

    With the spin -V/R the axle's tip circles so that yaw follows roll: yaw' = +n roll'.
    """
    soft = PAPER.primary_suspension.replace(
        vertical_stiffness=1e-3,
        vertical_damping=0.0,
        longitudinal_stiffness=1e-3,
        longitudinal_damping=0.0,
        lateral_stiffness=1e-3,
        lateral_damping=0.0,
    )
    parameters = PAPER.replace(primary_suspension=soft, gravity=0.0)
    model = VehicleModel(parameters)
    rates = np.zeros(50)
    roll, yaw = WHEELSET_COORDINATES[0, 3], WHEELSET_COORDINATES[0, 5]
    rates[roll] = 0.01
    state = state_with(model, None, rates)
    duration = 0.02
    for _ in range(200):
        state, _ = model.step(state, np.zeros((4, 6)), np.zeros((4, 6)), duration / 200)
    # I roll'' = H yaw', I yaw'' = -H roll' with H = I_wy * spin < 0.
    angle = 146.0 * (300.0 / 3.6 / 0.46) / 923.0 * duration
    assert state.rates[roll] == pytest.approx(0.01 * np.cos(angle), rel=1e-9)
    assert state.rates[yaw] == pytest.approx(0.01 * np.sin(angle), rel=1e-9)


def test_gyroscopic_moments_follow_the_true_spin():
    """The same vehicle at 300 km/h, its matrices built for 300 and for 180 km/h."""
    fast = VehicleModel(PAPER)
    slow = VehicleModel(PAPER.replace(speed=50.0))
    rng = np.random.default_rng(4)
    q, v = rng.normal(size=50) * 1e-4, rng.normal(size=50) * 1e-2
    one, other = state_with(fast, q, v, 300 / 3.6), state_with(slow, q, v, 300 / 3.6)
    plain = state_with(slow, q, v, 50.0)
    for _ in range(1000):
        one, _ = fast.step(one, fast.static_forces, fast.static_forces, 1e-4)
        other, _ = slow.step(other, slow.static_forces, slow.static_forces, 1e-4)
        plain, _ = slow.step(plain, slow.static_forces, slow.static_forces, 1e-4)
    scale = np.abs(one.coordinates[FREE] - plain.coordinates[FREE]).max()
    assert scale > 1e-6
    assert np.abs(one.coordinates[FREE] - other.coordinates[FREE]).max() < 1e-5 * scale


def test_pitch_moment_spins_a_wheelset_and_nothing_else():
    """Moment 292 s + 876 s (s - 1) N m over 0.1 s, which is 2 s + 6 s (s - 1) rad/s2."""
    model = VehicleModel(PAPER)
    start, end, bow = model.static_forces, model.static_forces, np.zeros((4, 6))
    end[1, 4], bow[1, 4] = 292.0, 876.0
    standing = model.initial_state(speed=0.0)
    state, outputs = model.step(standing, start, end, 0.1, force_quadratic=bow)
    # Integrals over s: 1 - 1 for the rate, 1/3 + 1/2 - 1 for the angle.
    assert outputs["wheelset[2].pitch_rate"] == pytest.approx(0.0, abs=1e-15)
    assert outputs["wheelset[2].pitch_angle"] == pytest.approx(-(0.1**2) / 6.0)
    assert outputs["wheelset[1].pitch_rate"] == 0.0
    assert not state.vector[:90].any()
    state, outputs = model.step(model.initial_state(), start, end, 0.1)
    spin = -PAPER.speed / 0.46
    assert outputs["wheelset[2].pitch_rate"] == pytest.approx(spin + 0.1, rel=1e-12)
    assert outputs["wheelset[2].pitch_angle"] == pytest.approx(spin * 0.1 + 0.01 / 3.0, rel=1e-12)


def soft_ground(model, outputs):
    """Return forces that carry the pitch moments of inertia forces and keep all upright."""
    forces = model.static_forces
    forces[:, 1:4] -= 2e6 * outputs.motion[:, 1:4] + 3e4 * outputs.motion[:, 6:9]
    return forces


def test_speed_follows_a_ramp_and_the_bogies_lag_by_their_inertia():
    model = VehicleModel(PAPER)
    state, forces = model.initial_state(), model.static_forces
    dt, acceleration, speed = 1e-3, 0.5, PAPER.speed
    before = state.position
    for step in range(20_000):
        state, outputs = model.step(
            state, forces, forces, dt, speed + acceleration * dt * (step + 1)
        )
        forces = soft_ground(model, outputs)
    elapsed = 20_000 * dt
    assert state.speed == pytest.approx(speed + acceleration * elapsed)
    assert state.position - before == pytest.approx(
        speed * elapsed + 0.5 * acceleration * elapsed**2
    )
    # Each bogie with two wheelsets hangs back in two springs of K_sx.
    running_gear = PAPER.bogie.mass + 2.0 * PAPER.wheelset.mass
    lag = running_gear * acceleration / (2.0 * 0.18e6)
    assert outputs["bogie[1].longitudinal_displacement"] == pytest.approx(-lag, rel=0.05)
    assert outputs["car_body.longitudinal_velocity"] == pytest.approx(speed + 10.0)


def test_jump_of_the_setpoint_becomes_a_ramp_within_the_limit():
    model = VehicleModel(PAPER)
    state, forces = model.initial_state(), model.static_forces
    for _ in range(100):
        state, outputs = model.step(state, forces, forces, 1e-3, 60.0)
        forces = soft_ground(model, outputs)
    assert state.speed == pytest.approx(PAPER.speed - 10.0 * 0.1)
    for _ in range(3000):
        state, outputs = model.step(state, forces, forces, 1e-3, 60.0)
        forces = soft_ground(model, outputs)
    assert state.speed == pytest.approx(60.0)
