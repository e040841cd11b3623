"""Force laws of dampers and stops."""

import numpy as np
import pytest
from rail_vehicle import PAPER, VehicleModel
from rail_vehicle.kernels import blow_off_force, maxwell_force, stop_force
from scipy.integrate import solve_ivp
from vehicle_reference import dashpot_rate, state_with

YAW = (10.0e6, 300.0e3, 3.0e3, 20.0e3)


@pytest.mark.parametrize(
    ("rate", "force"),
    [(0.0, 0.0), (0.005, 1500.0), (0.01, 3000.0), (0.03, 3400.0), (-0.11, -5000.0)],
)
def test_yaw_damper_settles_on_its_characteristic(rate, force):
    """Pulled at a constant rate until the series spring has come to rest."""
    assert maxwell_force(0.0, rate, 2.0, *YAW) == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("start", [-9e3, -3e3, 0.0, 2e3, 3e3, 8e3])
@pytest.mark.parametrize("rate", [-0.2, -0.012, 0.0, 0.009, 0.3])
@pytest.mark.parametrize("duration", [2e-4, 5e-3, 0.05])
def test_series_damper_is_exact_at_constant_rate(start, rate, duration):
    spring, damping, limit, after = YAW

    def slope(_, force):
        return spring * (rate - dashpot_rate(force, damping, limit, after))

    reference = solve_ivp(slope, (0.0, duration), [start], rtol=1e-9, atol=1e-6, max_step=1e-4)
    found = maxwell_force(start, rate, duration, *YAW)
    assert found == pytest.approx(reference.y[0, -1], rel=1e-6, abs=1e-3)


def test_series_damper_is_stable_when_stiff():
    assert maxwell_force(5e3, 0.02, 1.0, 1e12, 3e5, 3e3, 2e4) == pytest.approx(3.2e3, rel=1e-9)


@pytest.mark.parametrize(("rate", "force"), [(0.1, 3.0e3), (0.15, 4.5e3), (0.25, 4.81e3)])
def test_lateral_damper_blows_off(rate, force):
    law = (30.0e3, 4.5e3, 3.1e3)
    assert blow_off_force(rate, *law) == pytest.approx(force)
    assert blow_off_force(-rate, *law) == pytest.approx(-force)


@pytest.mark.parametrize(("elongation", "force"), [(0.03, 0.0), (-0.01, 0.0), (0.05, 12.8e3)])
def test_stop_has_free_play_and_gets_harder(elongation, force):
    assert stop_force(elongation, 0.03, 1.2e5, 1.3e9) == pytest.approx(force)
    assert stop_force(-elongation, 0.03, 1.2e5, 1.3e9) == pytest.approx(-force)


def test_yaw_rate_of_a_bogie_pulls_its_two_dampers_against_each_other():
    """A frame that turns to the right moves its right side backwards."""
    model = VehicleModel(PAPER)
    rates = np.zeros(50)
    rates[11] = 0.02
    state = state_with(model, None, rates)
    _, outputs = model.step(state, model.static_forces, model.static_forces, 1e-5)
    left, right = outputs["yaw_damper[1].left.force"], outputs["yaw_damper[1].right.force"]
    # Positive force: the car body moves forward against the frame.
    elongation = 1.35 * 0.02 * 1e-5
    assert right == pytest.approx(10.0e6 * elongation, rel=1e-2)
    assert left == pytest.approx(-right, rel=1e-9)
    assert outputs["yaw_damper[2].left.force"] == pytest.approx(0.0, abs=1e-3)


def test_car_body_moving_right_is_pushed_back():
    model = VehicleModel(PAPER)
    coordinates, rates = np.zeros(50), np.zeros(50)
    coordinates[1], rates[1] = 0.04, 0.1
    outputs = model.outputs(state_with(model, coordinates, rates), model.static_forces)
    damper = 30.0e3 * 0.1
    stop = 1.2e5 * 0.01 + 1.3e9 * 0.01**3
    springs = 4.0 * (0.18e6 * 0.04 + 3.0e3 * 0.1)
    assert outputs["lateral_damper[1].force"] == pytest.approx(damper)
    assert outputs["lateral_bump_stop[2].force"] == pytest.approx(stop)
    expected = -(2.0 * damper + 2.0 * stop + springs) / 44039.0
    assert outputs["car_body.lateral_acceleration"] == pytest.approx(expected, rel=1e-9)


def test_elements_act_at_their_places():
    """Elongation per coordinate by hand: heights, half-spans and the bogies' distance."""
    elongation = -VehicleModel(PAPER).linear_system().element_matrix.T
    car_pitch, car_roll, car_yaw, frame_roll, frame_yaw = 4, 3, 5, 9, 11
    yaw_left, yaw_right, damper_ahead, damper_behind, stop_ahead = 0, 1, 4, 5, 6
    assert elongation[yaw_left, car_pitch] == pytest.approx(1.71 - 0.50)
    assert elongation[yaw_left, car_yaw] == pytest.approx(1.35)
    assert elongation[yaw_right, frame_yaw] == pytest.approx(1.35)
    for element in (damper_ahead, stop_ahead):
        assert elongation[element, car_roll] == pytest.approx(-(1.71 - 0.74))
        assert elongation[element, frame_roll] == pytest.approx(-(0.74 - 0.50))
        assert elongation[element, car_yaw] == pytest.approx(8.9)
    assert elongation[damper_behind, car_yaw] == pytest.approx(-8.9)
