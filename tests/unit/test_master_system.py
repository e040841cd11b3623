"""System structure and initialisation: names, units, causality, order of calls."""

import master_mocks as mocks
import pytest
from master_mocks import MockSlave, variable
from rail_cosim.errors import StructureError
from rail_cosim.initialisation import initialise
from rail_cosim.system import SystemStructure


def test_outputs_and_inputs_of_equal_name_are_connected():
    system = SystemStructure([mocks.MockTrack(), mocks.MockVehicle()])
    found = {(c.source, c.target, c.name, c.unit) for c in system.connections}
    assert found == {
        ("vehicle", "track", mocks.Z, "m"),
        ("vehicle", "track", mocks.V, "m/s"),
        ("track", "vehicle", mocks.F, "N"),
    }
    assert system.unconnected == []
    assert system.port("track").outputs.names[0] == mocks.F  # connected ones first
    assert system.port("track").coupled == 1


def test_values_go_to_the_inputs_of_their_names():
    """Whatever the order on either side, with outputs and inputs between that are not connected."""
    names = ["a", "b", "c", "d"]
    source = MockSlave(
        "track",
        [variable(name, start=float(n)) for n, name in enumerate(["other", *reversed(names)])],
    )
    source.variables["back"] = variable("back", "input")
    target = MockSlave(
        "vehicle",
        [variable("back", start=7.0), variable("free", "input")]
        + [variable(name, "input") for name in ("c", "a", "d", "b")],
    )
    source.data["back"] = 0.0
    system = SystemStructure([source, target])
    for port in system.ports:
        port.read_all()
    for port in system.ports:
        port.set_inputs()
    assert {name: target.data[name] for name in names} == {"d": 1.0, "c": 2.0, "b": 3.0, "a": 4.0}
    assert source.data["back"] == 7.0
    assert target.data["free"] == 0.0


def test_inputs_without_a_source_are_reported():
    track = mocks.MockTrack(extra=[variable("rail_head[1].left.vertical_force", "input", "N")])
    system = SystemStructure([track, mocks.MockVehicle()])
    (left,) = system.unconnected
    assert (left.slave, left.name) == ("track", "rail_head[1].left.vertical_force")
    assert left.reason == "no other FMU has an output of this name"


def pair(output, input_):
    return [
        MockSlave("a", [output, variable("back", "input", "m")]),
        MockSlave("b", [input_, variable("back", "output", "m")]),
    ]


def test_different_units_are_refused_naming_both():
    with pytest.raises(StructureError, match=r"a\.x is in mm, .* b\.x is in m; .* same unit"):
        SystemStructure(pair(variable("x", unit="mm"), variable("x", "input", "m")))


def test_a_unit_declared_on_one_side_only_will_do():
    system = SystemStructure(pair(variable("x"), variable("x", "input", "m")))
    assert {c.unit for c in system.connections} == {"m"}


def test_a_local_variable_as_counterpart_of_an_input_is_refused():
    with pytest.raises(StructureError, match=r"b\.x is an input, but a\.x is declared a local"):
        SystemStructure(pair(variable("x", "local"), variable("x", "input")))


def test_two_outputs_for_one_input_are_refused():
    slaves = [*pair(variable("x"), variable("x", "input")), MockSlave("c", [variable("x")])]
    with pytest.raises(StructureError, match=r"b\.x is an input that a and c both"):
        SystemStructure(slaves)


def test_other_than_real_variables_stay_unconnected_and_say_why():
    output = variable("x", kind="integer", start=0)
    system = SystemStructure(pair(output, variable("x", "input", kind="integer", start=0)))
    (left,) = system.unconnected
    assert "only reals connect" in left.reason


def test_slaves_with_nothing_in_common_are_refused():
    with pytest.raises(StructureError, match=r"a: none of its inputs .*, \.\.\.\) and outputs \(x"):
        SystemStructure([MockSlave("a", [variable("x")]), mocks.MockVehicle(), mocks.MockTrack()])


def initialised(parameters=None, **more):
    calls = []
    system = SystemStructure(
        [mocks.MockTrack(calls=calls, **more), mocks.MockVehicle(calls=calls, **more)]
    )
    calls.clear()
    initialise(
        system,
        parameters=parameters or {},
        input_times={"track": "step_start", "vehicle": "step_end"},
        stop_time=1.5,
    )
    return system, calls


def test_order_of_calls_of_the_initialisation():
    _, calls = initialised()
    initial = "wheelset[1].initial_vertical_displacement"
    expected = [
        ("track", "set", "coupling.input_time"),
        ("track", "setup", 0.0, 1.5),
        ("vehicle", "set", "coupling.input_time"),
        ("vehicle", "setup", 0.0, 1.5),
        ("vehicle", "enter_initialization"),
        ("vehicle", "read", 5),
        ("track", "write"),
        ("vehicle", "get", "static_wheel_load"),
        ("track", "set", "static_wheel_load"),
        ("track", "enter_initialization"),
        ("track", "get", "wheelset[1].static_vertical_displacement"),
        ("vehicle", "set", initial),
        ("vehicle", "read", 5),
        ("track", "write"),
        ("track", "read", 4),
        ("vehicle", "write"),
        ("track", "exit_initialization"),
        ("vehicle", "exit_initialization"),
        ("track", "read", 4),
        ("track", "read", 1),  # integers
        ("vehicle", "read", 5),
    ]
    assert calls == expected


def test_values_passed_at_initialisation():
    system, _ = initialised()
    assert system["track"].data["static_wheel_load"] == 69e3
    assert system["vehicle"].data["wheelset[1].initial_vertical_displacement"] == 2e-5
    assert system["track"].data[mocks.Z] == mocks.START


def test_values_set_by_the_user_are_not_overwritten():
    given = {
        "track": {"static_wheel_load": 5e4},
        "vehicle": {"wheelset[1].initial_vertical_displacement": 1e-4},
    }
    system, _ = initialised(given)
    assert system["track"].data["static_wheel_load"] == 5e4
    assert system["vehicle"].data["wheelset[1].initial_vertical_displacement"] == 1e-4


def test_the_speed_setpoint_follows_the_speed_unless_it_is_set():
    extra = [variable("speed_setpoint", "input", "m/s", start=83.3)]
    for given, expected in (({"speed": 60.0}, 60.0), ({"speed": 60.0, "speed_setpoint": 61.0}, 61)):
        system = SystemStructure([mocks.MockTrack(), mocks.MockVehicle(extra=extra)])
        parameters = {"vehicle": given}
        initialise(system, parameters=parameters, input_times={}, stop_time=1.0)
        assert system["vehicle"].data["speed_setpoint"] == expected


def test_foreign_slaves_with_the_terminals_alone_are_initialised():
    force, motion = mocks.F, mocks.Z
    track = MockSlave("track", [variable(force, unit="N"), variable(motion, "input", "m")])
    vehicle = MockSlave("vehicle", [variable(motion, unit="m"), variable(force, "input", "N")])
    vehicle.data[motion] = 0.25
    system = SystemStructure([track, vehicle])
    initialise(system, parameters={}, input_times={"track": "step_start"}, stop_time=1.0)
    assert track.data[motion] == 0.25
