"""Staggered coupling of the two cores against their monolithic integration."""

import numpy as np
import pytest
from pair import WholeVehicle, run_monolithic, run_staggered
from rail_vehicle import VehicleModel, VehicleParameters
from slab_track import TrackModel, TrackParameters
from slab_track.contact import ContactParameters
from slab_track.parameters import Integration, Rail, Window

VERTICAL = ContactParameters(model="vertical")
SPEED, DISTANCE, PITCH = 300 / 3.6, 15.0, 5.032


def _pair():
    parameters = TrackParameters(
        contact=VERTICAL,
        rail=Rail(mode_count=250),
        integration=Integration(maximum_step=5e-5),
        window=Window(method="moving_mass"),
    )
    return TrackModel(parameters), WholeVehicle(VehicleModel(VehicleParameters(speed=SPEED)))


@pytest.fixture(scope="module")
def reference():
    return run_monolithic(*_pair(), distance=DISTANCE, speed=SPEED, step=5e-5)


def _error(reference, step, jacobi):
    """Largest difference of wheel force over the last slab, over half the peak-to-peak."""
    history = run_staggered(*_pair(), distance=DISTANCE, speed=SPEED, step=step, jacobi=jacobi)
    last = (history.time > reference.time[-1] - PITCH / SPEED) & (
        history.time < reference.time[-1] + 1e-9
    )
    monolithic = reference.normal_force[:, :, 0]
    half = 0.5 * np.ptp(monolithic[reference.time > reference.time[-1] - PITCH / SPEED], axis=0)
    same_times = monolithic[np.rint(history.time[last] / 5e-5).astype(int) - 1]
    difference = np.abs(history.normal_force[last][:, :, 0] - same_times)
    return float(np.max(difference / half))


def test_gauss_seidel_meets_the_monolithic_solution(reference):
    errors = [_error(reference, step, jacobi=False) for step in (4e-4, 2e-4, 1e-4)]
    assert errors[-1] < 1e-3
    assert np.log2(errors[0] / errors[-1]) / 2 > 2.0


def test_jacobi_meets_the_monolithic_solution(reference):
    errors = [_error(reference, step, jacobi=True) for step in (4e-4, 2e-4, 1e-4)]
    assert errors[-1] < 2e-2
    assert np.log2(errors[0] / errors[-1]) / 2 > 2.0


@pytest.mark.parametrize(("jacobi", "bound"), [(False, 1.5e-2), (True, 5e-2)])
def test_steps_of_mixed_size_meet_the_monolithic_solution(reference, jacobi, bound):
    assert _error(reference, (1e-4, 5e-5, 2e-4), jacobi) < bound


def test_long_steps_between_short_ones_are_stable_as_long_ones_alone_are(reference):
    """The points before a long step are a tenth of it away; extrapolation diverged from them."""
    assert _error(reference, 1e-3, jacobi=False) < 0.5
    assert _error(reference, (1e-4, 1e-3), jacobi=False) < 0.7
