"""What holds for every vehicle: equilibrium, energy, mirror symmetry; random parameter sets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rail_vehicle import VehicleModel, VehicleParameters
from rail_vehicle.coordinates import FREE
from random_parameters import examples, parameter_sets
from vehicle_reference import mirror, state_with

DEFAULTS = VehicleParameters(
    initial_position=12.0,
    initial_lateral_displacement=1e-3,
    primary_suspension=VehicleParameters().primary_suspension.replace(
        guide_vertical_stiffness=1e5, guide_vertical_damping=1e3
    ),
)
VEHICLES = parameter_sets(DEFAULTS)
SEEDS = st.integers(0, 2**32 - 1)
COUNTS = pytest.mark.parametrize("count", [12, pytest.param(300, marks=pytest.mark.slow)])


def disturbed(model, seed, size):
    rng = np.random.default_rng(seed)
    q, v = rng.normal(size=50) * size, rng.normal(size=50) * 50.0 * size
    q[0] = v[0] = 0.0
    return q, v


@COUNTS
def test_every_vehicle_rests_under_its_weight(count):
    @examples(count)
    @given(VEHICLES)
    def holds(p):
        model = VehicleModel(p)
        weight = p.gravity * (p.car_body.mass + 2.0 * p.bogie.mass + 4.0 * p.wheelset.mass)
        forces = model.static_forces
        assert forces[:, 2].sum() == pytest.approx(-weight, rel=1e-12)
        state = model.initial_state()
        journals = [
            model.outputs(state, forces)[f"axle_box[{i}].{side}.journal_force"]
            for i in range(1, 5)
            for side in ("left", "right")
        ]
        sprung = p.gravity * (p.car_body.mass + 2.0 * p.bogie.mass + 8.0 * p.axle_box.mass)
        assert sum(journals) == pytest.approx(sprung, rel=1e-9)
        after = state
        for _ in range(10):
            after, outputs = model.step(after, forces, forces, 1e-3)
        np.testing.assert_allclose(after.coordinates[FREE], state.coordinates[FREE], atol=1e-12)
        np.testing.assert_allclose(after.rates[FREE], 0.0, atol=1e-9)
        assert outputs["car_body.longitudinal_position"] == pytest.approx(
            state.position + 0.01 * p.speed, rel=1e-12
        )

    holds()


def energy(model, state):
    """Of motion and springs, those in series with the yaw dampers included; J."""
    system, p = model.linear_system(), model.parameters
    free = np.isin(np.arange(50), FREE)
    q, v = state.coordinates * free, state.rates * free
    elongation = np.abs(system.element_matrix.T @ q)[6:8]
    depth = np.maximum(elongation - p.lateral_bump_stop.clearance, 0.0)
    stop = p.lateral_bump_stop
    stored = 0.5 * stop.stiffness * depth**2 + 0.25 * stop.cubic_stiffness * depth**4
    series = 0.5 * state.yaw_damper_forces**2 / p.yaw_damper.series_stiffness
    moving = 0.5 * v @ system.mass @ v
    return moving, moving + 0.5 * q @ system.stiffness @ q + stored.sum() + series.sum()


@COUNTS
def test_no_vehicle_makes_energy(count):
    """Under its weight alone; the gyroscopic moments of rolling wheelsets do no work."""

    @examples(count)
    @given(VEHICLES, SEEDS)
    def holds(p, seed):
        model = VehicleModel(p)
        state, forces = state_with(model, *disturbed(model, seed, 2e-4)), model.static_forces
        moving, total = energy(model, state)
        energies, largest = [total], moving
        for _ in range(100):
            state, _ = model.step(state, forces, forces, 5e-4)
            moving, total = energy(model, state)
            energies.append(total)
            largest = max(largest, moving)
        assert np.isfinite(energies).all()
        assert np.diff(energies).max() < 1e-6 * largest
        assert energies[-1] < energies[0]

    holds()


@COUNTS
def test_every_vehicle_is_its_own_mirror_image(count):
    @examples(count)
    @given(VEHICLES.map(lambda p: p.replace(initial_lateral_displacement=0.0)), SEEDS)
    def holds(p, seed):
        model, swap = VehicleModel(p), mirror()
        q, v = disturbed(model, seed, 1e-3)
        forces = model.static_forces + np.random.default_rng(seed + 1).normal(size=(4, 6)) * 1e4
        image = forces * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
        one, other = state_with(model, q, v), state_with(model, swap @ q, swap @ v)
        for _ in range(20):
            one, _ = model.step(one, forces, forces, 1e-3)
            other, _ = model.step(other, image, image, 1e-3)
        np.testing.assert_allclose(other.coordinates, swap @ one.coordinates, rtol=0, atol=1e-13)
        np.testing.assert_allclose(other.rates, swap @ one.rates, rtol=0, atol=1e-10)
        assert np.abs(one.coordinates[FREE]).max() > 1e-4

    holds()
