"""The compiled step of the vehicle against the equations in plain numpy: random parameter sets."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from rail_vehicle import VehicleModel, VehicleParameters
from rail_vehicle.coordinates import FREE
from rail_vehicle.coupling import ForceHistory
from rail_vehicle.equations import VehicleEquations, forces_over_step
from random_parameters import examples, parameter_sets
from vehicle_reference import state_with

DEFAULTS = VehicleParameters(
    initial_position=12.0,
    initial_lateral_displacement=1e-3,
    primary_suspension=VehicleParameters().primary_suspension.replace(
        guide_vertical_stiffness=1e5, guide_vertical_damping=1e3
    ),
)
VEHICLES = parameter_sets(DEFAULTS)
SEEDS = st.integers(0, 2**32 - 1)
COUNTS = pytest.mark.parametrize("count", [24, pytest.param(300, marks=pytest.mark.slow)])


def drawn(count):
    """Return settings for so many examples: shrinking a failure takes too long here."""
    return settings(examples(count), phases=[Phase.generate])


def close(found, wanted, tolerance=1e-10):
    wanted = np.asarray(wanted)
    scale = tolerance * np.abs(wanted).max(initial=1e-6)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=scale)


@COUNTS
def test_matrices_are_those_of_the_product(count):
    @drawn(count)
    @given(VEHICLES)
    def holds(p):
        system, equations = VehicleModel(p).linear_system(), VehicleEquations(p)
        close(equations.M, np.diag(system.mass), 1e-14)
        for mine, theirs in (
            (equations.K, system.stiffness),
            (equations.C, system.damping),
            (equations.N, -system.element_matrix.T),
        ):
            # Entry by entry: small ones are as good as large ones.
            sizes = np.sqrt(
                np.abs(np.outer(np.abs(theirs).max(axis=1), np.abs(theirs).max(axis=0)))
            )
            assert np.all(np.abs(mine - theirs) <= 1e-13 * sizes)

    holds()


@COUNTS
def test_the_step_agrees_to_rounding(count):
    """Everything non-linear at work: stops, blow-off, spins beside the speed, a changing speed."""
    at_work = []

    @drawn(count)
    @given(VEHICLES, SEEDS, st.sampled_from([1e-4, 5e-4, 2e-3]), st.floats(-2.0, 2.0))
    def holds(p, seed, dt, faster):
        if seed % 4 == 0:
            p = p.replace(yaw_damper=p.yaw_damper.replace(damping=0.0))
        model, rng = VehicleModel(p), np.random.default_rng(seed)
        equations = VehicleEquations(p, model.internal_step)
        rest = equations.initial_state(heights := rng.normal(size=4) * 1e-4)
        close(rest.coordinates[FREE], model.initial_state(heights).coordinates[FREE])
        q, v = rng.normal(size=50) * 1e-3, rng.normal(size=50) * 0.02
        q[0] = v[0] = 0.0
        q[1], v[1], v[5], v[11] = rng.uniform(-1.0, 1.0, 4) * (0.05, 0.3, 0.1, 0.3)
        state = state_with(model, q, v)
        mine = rest._replace(coordinates=state.coordinates, rates=state.rates)
        history, ages, values = None, np.zeros(0), np.zeros((0, 4, 6))
        for n in range(12):
            new = model.static_forces + rng.normal(size=(4, 6)) * (4e3, 1e4, 3e4, 2e3, 3e2, 5e3)
            history = history.append(new, dt) if history else ForceHistory.begin(new)
            ages, values = np.r_[0.0, ages + dt][:3], np.r_[new[None], values][:3]
            over = history.extrapolate(dt, 2)
            setpoint = p.speed + faster * n * dt
            state, out = model.step(state, over.start, over.end, dt, setpoint, over.quadratic)
            mine, found = equations.step(mine, forces_over_step(ages, values, dt, 2), dt, setpoint)
            close(mine.coordinates[FREE], state.coordinates[FREE])
            close(mine.rates[FREE], state.rates[FREE])
            close(mine.rates[22:42:6], state.rates[22:42:6], 1e-13)
            close(mine.coordinates[22:42:6], state.coordinates[22:42:6], 1e-13)
            close(mine.yaw_dampers, state.yaw_damper_forces)
            close([mine.position, mine.speed], [state.position, state.speed], 1e-14)
            close(found.motion, out.motion, 1e-13)
            boxes = [
                [out[f"axle_box[{i}].{s}.vertical_acceleration"] for s in ("left", "right")]
                for i in (1, 2, 3, 4)
            ]
            close(found.axle_boxes, boxes)
            names = [f"yaw_damper[{j}].{s}" for j in (1, 2) for s in ("left", "right")]
            names += [
                f"{kind}[{j}]" for kind in ("lateral_damper", "lateral_bump_stop") for j in (1, 2)
            ]
            close(found.elements, [out[f"{name}.force"] for name in names])
            limits = p.yaw_damper.blow_off_force, p.lateral_damper.blow_off_force, 0.0
            at_work.append(np.abs(found.elements[[0, 4, 6]]) > limits)

    holds()
    assert np.all(np.any(at_work, axis=0) & ~np.all(at_work, axis=0))


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("at_end", [False, True])
def test_forces_over_a_step(order, at_end):
    rng = np.random.default_rng(0)
    values, steps = rng.normal(size=(4, 4, 6)), (1e-3, 2.5e-3, 1e-3)
    history, ages = ForceHistory.begin(values[0]), np.zeros(1)
    for n, elapsed in enumerate(steps, start=1):
        history, ages = history.append(values[n], elapsed), np.r_[0.0, ages + elapsed]
        dt = elapsed if at_end else 7e-4
        over = history.interpolate(order) if at_end else history.extrapolate(dt, order)
        found = forces_over_step(ages, values[n::-1], dt, order, at_end=at_end)
        curves = over.start, over.end, over.quadratic
        for mine, theirs in zip((found[0], found.sum(axis=0), found[2]), curves, strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-13)
