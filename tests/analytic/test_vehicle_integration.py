"""The step against an adaptive Runge-Kutta solution of the same equations."""

import numpy as np
import pytest
from rail_vehicle import PAPER, StepError, VehicleModel, VehicleState
from rail_vehicle.coordinates import FREE
from vehicle_reference import solve, state_with

DURATION = 0.12

# Early stops and dampers that blow off at little force: everything non-linear acts at once.
LIVELY = PAPER.replace(
    lateral_bump_stop=PAPER.lateral_bump_stop.replace(clearance=0.002),
    lateral_damper=PAPER.lateral_damper.replace(blow_off_force=2.0e3),
)


def driving_forces(model):
    """Smooth contact forces (4, 6) over time, strong in all six directions."""
    rng = np.random.default_rng(7)
    amplitude = np.array([4e3, 1.5e4, 3e4, 2e3, 3e2, 6e3]) * rng.uniform(0.5, 1.0, (4, 6))
    frequency, phase = rng.uniform(3.0, 45.0, (4, 6)), rng.uniform(0.0, 6.0, (4, 6))
    static = model.static_forces
    return lambda t: static + amplitude * np.sin(2.0 * np.pi * frequency * t + phase)


def start_state(model):
    rng = np.random.default_rng(8)
    rates = np.zeros(50)
    rates[FREE] = 0.02 * rng.normal(size=FREE.size)
    rates[1], rates[5], rates[11] = 0.3, 0.05, 0.1
    return state_with(model, rng.normal(size=50) * 2e-4, rates)


def march(model, state, forces, dt, bow=True, acceleration=0.0):
    extremes = np.zeros(3)
    steps = round(DURATION / dt)
    for step in range(steps):
        t = step * dt
        start, middle, end = forces(t), forces(t + 0.5 * dt), forces(t + dt)
        curve = 2.0 * (start + end) - 4.0 * middle if bow else None
        state, outputs = model.step(state, start, end, dt, state.speed + acceleration * dt, curve)
        now = [
            outputs["yaw_damper[1].left.force"],
            outputs["lateral_damper[1].force"],
            outputs["lateral_bump_stop[1].force"],
        ]
        extremes = np.maximum(extremes, np.abs(now))
    return state, extremes


@pytest.fixture(scope="module")
def reference():
    """Solution with everything non-linear at work while the train gains speed."""
    model = VehicleModel(LIVELY)
    return solve(model, start_state(model), driving_forces(model), DURATION, acceleration=2.0)


def largest_error(state, reference):
    q, v, damper = reference
    errors = [
        np.abs(state.coordinates - q)[FREE].max() / np.abs(q[FREE]).max(),
        np.abs(state.rates - v)[FREE].max() / np.abs(v[FREE]).max(),
        np.abs(state.yaw_damper_forces - damper).max() / np.abs(damper).max(),
    ]
    return max(errors)


def test_all_nonlinear_elements_against_runge_kutta(reference):
    model = VehicleModel(LIVELY)
    state, extremes = march(
        model, start_state(model), driving_forces(model), 1e-4, acceleration=2.0
    )
    assert np.all(extremes > [LIVELY.yaw_damper.blow_off_force, 2.0e3, 500.0])
    assert largest_error(state, reference) < 3e-5
    q, v, _ = reference
    spins = [22, 28, 34, 40]
    assert state.coordinates[spins] == pytest.approx(q[spins], rel=1e-9)
    assert state.rates[spins] == pytest.approx(v[spins], rel=1e-9)


@pytest.mark.parametrize("bow", [True, False])
def test_second_order_with_nonlinear_elements(reference, bow):
    model = VehicleModel(LIVELY)
    forces = driving_forces(model)
    steps = (1e-3, 5e-4, 2.5e-4)
    errors = [
        largest_error(march(model, start_state(model), forces, dt, bow, 2.0)[0], reference)
        for dt in steps
    ]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.4)


def test_linear_vehicle_is_exact_but_for_the_forces_interpolation():
    """No non-linear element: parabolas give fourth order, lines second, constants exactness."""
    linear = PAPER.replace(
        yaw_damper=PAPER.yaw_damper.replace(damping=0.0),
        lateral_damper=PAPER.lateral_damper.replace(blow_off_force=1e9),
        lateral_bump_stop=PAPER.lateral_bump_stop.replace(clearance=1.0),
    )
    model = VehicleModel(linear.replace(lateral_damper=linear.lateral_damper.replace(damping=0.0)))
    forces = driving_forces(model)
    _, v, _ = solve(model, start_state(model), forces, DURATION)

    def error(dt, bow):
        state, _ = march(model, start_state(model), forces, dt, bow)
        return np.abs(state.rates - v)[FREE].max() / np.abs(v[FREE]).max()

    lines = [error(dt, False) for dt in (1e-3, 5e-4)]
    parabolas = [error(dt, True) for dt in (1e-3, 5e-4)]
    assert np.log2(lines[0] / lines[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(parabolas[0] / parabolas[1]) == pytest.approx(4.0, abs=0.3)
    assert parabolas[0] < 1e-5

    constant = driving_forces(model)(0.01)
    one, _ = model.step(start_state(model), constant, constant, DURATION)
    _, v, _ = solve(model, start_state(model), lambda t: constant, DURATION)
    assert one.rates[FREE] == pytest.approx(v[FREE], abs=1e-8 * np.abs(v[FREE]).max())


@pytest.mark.parametrize("dt", [1e-5, 3.7e-4, 1e-3, 1e-2])
def test_stable_at_every_step_size(dt):
    """Stiff, strongly damped vehicle on a soft ground settles whatever the step."""
    stiff = PAPER.replace(
        yaw_damper=PAPER.yaw_damper.replace(series_stiffness=1e9, damping=2e6),
        lateral_damper=PAPER.lateral_damper.replace(damping=5e5, blow_off_force=1e5),
        lateral_bump_stop=PAPER.lateral_bump_stop.replace(clearance=1e-3, stiffness=5e7),
    )
    model = VehicleModel(stiff)
    rates = np.zeros(50)
    rates[[1, 5, 11]] = 0.2, 0.02, 0.3
    state = state_with(model, None, rates)
    forces = model.static_forces
    for _ in range(max(20, round(0.1 / dt)) if dt > 1e-5 else 2000):
        state, _ = model.step(state, forces, forces, dt)
        assert np.abs(state.rates[FREE]).max() < 1.0


def test_a_long_step_is_many_short_ones():
    model = VehicleModel(LIVELY)
    rng = np.random.default_rng(9)
    start, end, bow = model.static_forces + rng.normal(size=(3, 4, 6)) * 5e3
    bow = bow - model.static_forces
    long, _ = model.step(start_state(model), start, end, 5e-3, force_quadratic=bow)
    short = start_state(model)
    for part in range(5):
        a, b = part / 5, (part + 1) / 5
        at_a, at_b = (start + (end - start) * s + bow * s * (s - 1.0) for s in (a, b))
        short, _ = model.step(short, at_a, at_b, 1e-3, force_quadratic=bow / 25)
    assert long.vector == pytest.approx(short.vector, rel=1e-9, abs=1e-12)


def test_step_leaves_its_state_alone_and_repeats_itself():
    model = VehicleModel(LIVELY)
    state = start_state(model)
    before = state.vector.copy()
    forces = driving_forces(model)(0.0)
    first, outputs = model.step(state, forces, forces, 1e-3)
    again, same = model.step(VehicleState.of_vector(before), forces, forces, 1e-3)
    assert np.array_equal(state.vector, before)
    assert np.array_equal(first.vector, again.vector)
    assert np.array_equal(outputs.vector, same.vector)


def test_rounding_of_the_step_size_changes_nothing_that_matters():
    model = VehicleModel(PAPER)
    forces = driving_forces(model)(0.0)
    one, _ = model.step(start_state(model), forces, forces, 1e-4)
    other, _ = model.step(start_state(model), forces, forces, 1e-4 * (1.0 + 1e-10))
    assert other.vector[:90] == pytest.approx(one.vector[:90], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("dt", [0.0, -1e-4, float("nan"), float("inf")])
def test_impossible_step_size_is_refused(dt):
    model = VehicleModel(PAPER)
    with pytest.raises(StepError, match="must be positive and finite"):
        model.step(model.initial_state(), model.static_forces, model.static_forces, dt)


def test_contact_forces_that_are_not_finite_are_refused():
    model = VehicleModel(PAPER)
    forces = model.static_forces
    forces[2, 1] = np.nan
    with pytest.raises(StepError, match="contact forces are not finite"):
        model.step(model.initial_state(), model.static_forces, forces, 1e-4)


def test_setpoint_that_is_not_finite_is_refused():
    model = VehicleModel(PAPER)
    forces = model.static_forces
    with pytest.raises(StepError, match="speed_setpoint"):
        model.step(model.initial_state(), forces, forces, 1e-4, float("nan"))
