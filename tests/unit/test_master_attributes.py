"""What a run's attributes say of its parameters."""

import json
from types import SimpleNamespace

from rail_cosim.attributes import CHANGED, changed_attribute
from rail_cosim.slave import Variable

VARIABLES = {
    "speed": Variable(name="speed", start=83.33333333333333),
    "mode_count": Variable(name="mode_count", kind="integer", start=200),
    "profile": Variable(name="profile", kind="string", start="S1002"),
}


def changed(usual, given):
    descriptions = {"vehicle": SimpleNamespace(variables=VARIABLES)}
    return json.loads(
        changed_attribute(descriptions, {"vehicle": usual}, {"vehicle": given})[CHANGED]
    )


def test_only_what_differs_from_parameter_set_or_start_value_is_told():
    given = {"speed": 90.0, "mode_count": 200, "profile": "60E1"}
    assert changed({}, given) == {"vehicle.speed": 83.33333333333333, "vehicle.profile": "S1002"}
    assert changed({"speed": 90.0, "profile": "60E1"}, given) == {}


def test_rounding_is_no_change():
    assert changed({}, {"speed": 300.0 * (1.0 / 3.6)}) == {}
    assert changed({}, {"speed": 83.3334}) == {"vehicle.speed": 83.33333333333333}
