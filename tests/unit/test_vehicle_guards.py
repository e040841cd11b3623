"""Partners that drive the vehicle off: found in the step where it happens, with body and limit.

Whatever finite force or moment acts on a wheelset, a step ends with motions that a vehicle on a
track can have, or with an error.
"""

import time

import numpy as np
import pytest
from rail_quantities import ParameterError, with_values
from rail_quantities.terminals import CONTACT
from rail_vehicle import StepError, VehicleModel, VehicleParameters
from rail_vehicle.limits import LARGEST_DISPLACEMENT, LARGEST_ROTATION, beyond, motion_limits
from rail_vehicle.slave import VehicleSlave

STEP = 1e-4
FROM = 3
"""Step in which a value goes wrong."""
NAMES = [f"wheelset[{i}].contact.{name}" for i in range(1, 5) for name, _, _ in CONTACT]


@pytest.fixture(scope="module")
def model():
    return VehicleModel(VehicleParameters())


def run(model, script, steps, dt=STEP):
    """Drive the vehicle by a script for the forces; return steps made, motions and the error."""
    state, motions, before = model.initial_state(), [], model.static_forces
    for n in range(steps):
        forces = model.static_forces
        script(forces, n)
        try:
            state, outputs = model.step(state, before, forces, dt)
        except StepError as error:
            return n, np.array(motions), str(error)
        motions.append(outputs.vector)
        before = forces
    return steps, np.array(motions), ""


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", range(24), ids=NAMES)
def test_forces_that_are_no_number_are_refused_at_once(model, place, value):
    def script(forces, n):
        if n == FROM:
            forces.ravel()[place] = value

    made, motions, why = run(model, script, 10)
    assert made == FROM
    assert "contact forces are not finite" in why
    assert np.isfinite(motions).all()


@pytest.mark.parametrize("value", [1e300, 1e30, -1e30, 1e15])
@pytest.mark.parametrize("place", range(24), ids=NAMES)
def test_forces_that_diverge_are_refused_at_once(model, place, value):
    def script(forces, n):
        if n >= FROM:
            forces.ravel()[place] = value

    made, motions, why = run(model, script, 10)
    assert made == FROM
    assert "at position -" in why  # of the car body's centre
    assert np.isfinite(motions).all()


ALL, FIRST = slice(None), slice(0, 1)
PUSHED = {
    "lateral": (ALL, 1, 1e8, ".lateral_displacement", LARGEST_DISPLACEMENT),
    "lateral, left": (ALL, 1, -1e8, ".lateral_displacement", LARGEST_DISPLACEMENT),
    "tipped": (ALL, 1, 2e5, ".roll_angle", LARGEST_ROTATION),
    "upwards": (ALL, 2, -1e6, ".vertical_displacement", LARGEST_DISPLACEMENT),
    "downwards": (ALL, 2, 1e6, ".vertical_displacement", LARGEST_DISPLACEMENT),
    "longitudinal": (ALL, 0, 2e8, ".longitudinal_displacement", LARGEST_DISPLACEMENT),
    "one wheelset upwards": (FIRST, 2, -1e6, "bogie[1].pitch_angle", LARGEST_ROTATION),
    "roll": (FIRST, 3, 1e7, "wheelset[1].roll_angle", LARGEST_ROTATION),
    "yaw": (FIRST, 5, 5e6, "wheelset[1].yaw_angle", LARGEST_ROTATION),
    "pitch": (FIRST, 4, 1e6, "wheelset[1].pitch_rate", 1e4 / 0.46),
}


@pytest.mark.parametrize("case", PUSHED)
def test_a_pushed_vehicle_is_stopped_with_body_value_and_limit(model, case):
    """By forces that are finite, step by step."""
    wheelsets, column, value, name, limit = PUSHED[case]

    def script(forces, n):
        forces[wheelsets, column] += value

    made, motions, why = run(model, script, 20_000, 1e-3)
    assert 3 < made < 20_000
    assert name in why.partition(" = ")[0]
    found = float(why.split(" = ")[1].split()[0])
    assert limit < abs(found) < 1.2 * limit
    assert f"beyond {limit:.4g} " in why
    assert "drive the vehicle off its track" in why
    assert np.isfinite(motions).all()


def test_all_that_is_shown_before_was_within_the_limits(model):
    def script(forces, n):
        forces[:, 1] += 5e4

    made, motions, _ = run(model, script, 20_000, 1e-3)
    assert 100 < made < 20_000
    rows = motions[:, :44].reshape(made, 4, 11)
    assert np.abs(rows[:, :, 1:3]).max() <= LARGEST_DISPLACEMENT
    assert np.abs(rows[:, :, 3:5]).max() <= LARGEST_ROTATION


def test_a_vehicle_that_falls_is_stopped(model):
    """Without any force from a track: 5 m of free fall take a second."""

    def script(forces, n):
        forces[:] = 0.0

    made, _, why = run(model, script, 3000, 1e-3)
    assert 1e-3 * made == pytest.approx(np.sqrt(2.0 * LARGEST_DISPLACEMENT / 9.81), rel=0.05)
    assert "vertical_displacement" in why


def test_every_number_with_a_limit_has_a_name(model):
    limits = motion_limits(model.parameters)
    places = np.flatnonzero(np.isfinite(limits))
    assert places.size == 45 + 4
    names = set()
    for place in places:
        vector = np.zeros(limits.size)
        vector[place] = -1.01 * limits[place]
        names.add(beyond(vector, limits).partition(" = ")[0])
    assert len(names) == places.size
    shown = {output.name for output in model.output_table}
    assert {name for name in names if "pitch_rate" in name or "yaw" in name} <= shown
    assert beyond(np.where(np.isfinite(limits), limits, 1e9), limits) == ""


@pytest.mark.parametrize(
    ("heights", "match"),
    [
        ([0.0, np.nan, 0.0, 0.0], r"wheelset\[2\].initial_vertical_displacement = nan: must be"),
        ([0.0, 0.0, 0.0, 1e30], r"wheelset\[4\].initial_vertical_displacement = 1e\+30: must be"),
        ([4.0, -4.0, 0.0, 0.0], r"wheelset\[1\].initial.* = 4.0: .* put .*pitch_angle = "),
    ],
)
def test_heights_that_no_wheelset_has_are_refused(model, heights, match):
    with pytest.raises(ParameterError, match=match):
        model.initial_state(heights)


@pytest.mark.parametrize("setpoint", [np.nan, np.inf, -np.inf, 1e30, -1e30, 1001.0])
def test_speeds_that_no_vehicle_has_are_refused(model, setpoint):
    forces = model.static_forces
    with pytest.raises(StepError, match=r"speed_setpoint = .* must be finite and at most 1000"):
        model.step(model.initial_state(), forces, forces, STEP, setpoint)


@pytest.mark.parametrize("dt", [1e3, 1e9, 1e300])
def test_steps_that_would_never_end_are_refused_at_once(model, dt):
    forces, started = model.static_forces, time.process_time()
    with pytest.raises(StepError, match="at most 100 s, 100000 internal steps"):
        model.step(model.initial_state(), forces, forces, dt)
    assert time.process_time() - started < 1.0


HARD = {
    "lateral_damper.damping": {"lateral_damper.damping": 1e9},
    "yaw_damper.series_stiffness": {"yaw_damper.series_stiffness": 1e17},
    "lateral_bump_stop.cubic_stiffness": {"lateral_bump_stop.cubic_stiffness": 1e18},
}


@pytest.mark.parametrize("name", HARD)
def test_elements_too_stiff_for_their_bodies_are_refused_by_name(name):
    """Without end they would have been integrated, a step of 0.1 ms in 1e9 parts."""
    with pytest.raises(ParameterError, match=f"{name} = .* needs internal steps below .* s"):
        VehicleModel(with_values(VehicleParameters(), HARD[name]))


def slave(**values):
    made = VehicleSlave(instance_name="vehicle")
    for name, value in values.items():
        made.values[name] = value
    made.enter_initialization_mode()
    made.exit_initialization_mode()
    assert made.held_error == ""
    return made


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e30, -1e30])
@pytest.mark.parametrize("name", [*NAMES, "speed_setpoint"])
def test_inputs_of_the_fmu_are_refused_in_their_step(name, value):
    """With the input's name: nothing is computed from it."""
    vehicle = slave()
    assert all(vehicle.do_step(STEP * n, STEP) for n in range(FROM))
    kept = vehicle.reals.copy()
    place = vehicle.indices([name])
    vehicle.set_real(place.tolist(), [value])
    assert not vehicle.do_step(STEP * FROM, STEP)
    assert name in vehicle.held_error
    kept[place] = value
    assert np.array_equal(vehicle.reals, kept, equal_nan=True)
    assert not vehicle.do_step(STEP * FROM, STEP)


@pytest.mark.parametrize("step", [1, 2])
def test_inputs_that_cancel_are_refused_too(step):
    """Set in one call, of consecutive and of other references."""
    vehicle = slave()
    places = vehicle.indices([NAMES[0], NAMES[step], NAMES[2 * step]]).tolist()
    vehicle.set_real(places, [1e30, -1e30, 0.0])
    assert not vehicle.do_step(0.0, STEP)
    assert f"{NAMES[0]} = 1e+30" in vehicle.held_error


def test_the_fmu_tells_the_instant_at_which_the_vehicle_flies():
    vehicle = slave()
    places = vehicle.indices([f"wheelset[{i}].contact.vertical_force" for i in range(1, 5)])
    vehicle.set_real(places.tolist(), [-5e6] * 4)
    made = 0
    while vehicle.do_step(STEP * made, STEP):
        made += 1
        assert made < 10_000
    why = vehicle.held_error
    assert f"t = {STEP * (made + 1):.9g} s: wheelset[" in why
    assert ".vertical_displacement = -5.0" in why
    heights = vehicle.indices([f"wheelset[{i}].vertical_displacement" for i in range(1, 5)])
    assert -5.0 < vehicle.reals[heights].min() < -4.9


@pytest.mark.parametrize(
    ("speed", "setpoints", "told"),
    [
        (None, [0.0, 0.0], 1),  # a tool that gives 0 to what is not connected
        (None, [None, 0.0], 1),  # from the second step on
        (70.0, [0.0], 1),
        (70.0, [None, None], 0),  # it follows the parameter
        (70.0, [70.0, 70.5, 72.0], 0),  # a ramp
    ],
)
def test_set_point_far_from_the_speed_is_told(speed, setpoints, told):
    slave = VehicleSlave(instance_name="test", resources=None)
    slave.enter_initialization_mode()
    if speed:
        slave.values["speed"] = speed
    slave.exit_initialization_mode()
    for number, setpoint in enumerate(setpoints):
        if setpoint is not None:
            slave.values["speed_setpoint"] = setpoint
        assert slave.do_step(number * 1e-4, 1e-4), slave.held_error
    warnings = [message.msg for message in slave.log_queue if message.status == 1]
    assert len(warnings) == told
    if told:
        assert f"speed_setpoint = 0 m/s, speed = {speed or 83.3333:g} m/s: " in warnings[0]
