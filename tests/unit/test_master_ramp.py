"""Runs at growing and falling speed: the setpoints of a uniform acceleration."""

import pytest
from master_mocks import MockSlave, variable
from rail_cosim.errors import ParameterError
from rail_cosim.options import RunOptions
from rail_cosim.ramp import LIMIT, SpeedRamp


def vehicle(limit=10.0):
    names = [variable("speed_setpoint", "input"), variable(LIMIT, "parameter", start=limit)]
    return MockSlave("vehicle", names)


@pytest.mark.parametrize(("start", "end"), [(60.0, 90.0), (90.0, 60.0)])
def test_a_vehicle_that_follows_is_at_the_end_of_the_way_with_the_final_speed(start, end):
    slave, step = vehicle(), 1e-3
    ramp = SpeedRamp(slave, start=start, end=end, distance=750.0)
    speed, way = start, 0.0
    for number in range(ramp.step_count(step)):
        ramp.apply(number * step, step)
        now = slave.data["speed_setpoint"]
        way += 0.5 * (speed + now) * step
        speed = now
    assert speed == pytest.approx(end)
    assert way == pytest.approx(750.0, abs=step * max(start, end))
    assert ramp.acceleration == pytest.approx((end - start) / ramp.duration)


def test_what_cannot_be_followed_is_refused():
    with pytest.raises(ParameterError, match=r"--final-speed.*more than vehicle.*longer"):
        SpeedRamp(vehicle(limit=2.0), start=60.0, end=90.0, distance=750.0)
    with pytest.raises(ParameterError, match="no input speed_setpoint"):
        SpeedRamp(MockSlave("vehicle", []), start=60.0, end=90.0, distance=750.0)
    with pytest.raises(ParameterError, match=r"--final-speed.*--until-steady"):
        RunOptions(final_speed=300.0, until_steady=1e-3)
    with pytest.raises(ParameterError, match=r"--final-speed = -1"):
        RunOptions(final_speed=-1.0)
