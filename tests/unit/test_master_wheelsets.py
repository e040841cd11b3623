"""The track's number of wheelsets is the vehicle's."""

import described_fmus
import pytest
from master_mocks import variable
from rail_cosim.cache import VARIABLE
from rail_cosim.errors import ParameterError, StructureError
from rail_cosim.options import RunOptions
from rail_cosim.runner import gather_parameters
from rail_cosim.ssp import write_ssp
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.wheelsets import wheelset_parameters


def terminals(causality, numbers, *more):
    names = [f"wheelset[{i}].vertical_displacement" for i in numbers]
    made = [variable(name, causality, "m") for name in names]
    return {v.name: v for v in (*made, *more)}


def count_parameter(start):
    return variable("wheelset_count", "parameter", kind="integer", start=start)


TRACK = terminals("input", (1, 2, 3, 4), count_parameter(4))


def found(numbers, track=TRACK, *, own=(), given_vehicle=None, given_track=None):
    vehicle = terminals("output", numbers, *own)
    given = {"vehicle": given_vehicle or {}, "track": given_track or {}}
    return wheelset_parameters(vehicle, track, given)


def test_the_count_is_that_of_the_vehicles_terminals():
    assert found((1,)) == {"wheelset_count": 1}
    assert found((2, 1)) == {"wheelset_count": 2}
    assert found((1, 2, 3, 4)) == {}  # as the track starts


def test_outputs_of_other_names_are_no_terminals():
    others = [variable("wheelset[2].left.normal_force"), variable("wheelset[2].pitch_angle")]
    inputs = [variable("wheelset[3].vertical_displacement", "input")]
    assert found((1,), own=(*others, *inputs)) == {"wheelset_count": 1}


def test_the_vehicles_own_count_says_how_many_of_its_terminals_are_in_use():
    own = [count_parameter(2)]
    assert found((1, 2, 3, 4), own=own) == {"wheelset_count": 2}
    given = {"wheelset_count": 3}
    assert found((1, 2, 3, 4), own=own, given_vehicle=given) == given


def test_a_right_count_may_be_set_and_another_is_refused():
    assert found((1,), given_track={"wheelset_count": 1}) == {}
    message = r"track\.wheelset_count = 4: the vehicle FMU has 1 wheelset; omit it"
    with pytest.raises(ParameterError, match=message) as caught:
        found((1,), given_track={"wheelset_count": 4})
    assert caught.value.exit_status == 2


def test_terminals_with_a_gap_are_refused():
    with pytest.raises(StructureError, match=r"wheelset\[1\], wheelset\[3\]; they must count"):
        found((1, 3))
    with pytest.raises(StructureError, match="without a gap"):
        found((2,))


def test_more_wheelsets_than_the_track_has_terminals_are_refused():
    with pytest.raises(StructureError, match=r"has 5 wheelsets, but .* terminals for 4 only"):
        found((1, 2, 3, 4, 5))


def test_a_track_without_the_parameter_must_have_as_many_terminals():
    track = terminals("input", (1, 2))
    assert found((1, 2), track) == {}
    with pytest.raises(StructureError, match=r"has 1 wheelset, .* and no parameter wheelset_"):
        found((1,), track)


def test_what_is_no_vehicle_or_track_is_left_to_the_connections():
    assert found(()) == {}
    assert found((1,), {}) == {}


def gathered(folder, bound):
    """Return the track's values of a run of a package: 1 wheelset on 4 terminals."""
    fmus = {
        "Line": described_fmus.fmu(folder / "Line.fmu", described_fmus.track(4)),
        "Car": described_fmus.fmu(folder / "Car.fmu", described_fmus.vehicle(1)),
    }
    write_ssp(folder / "Pair.ssp", fmus, {}, {"Line": bound})
    pair = read_ssp(folder / "Pair.ssp")
    return gather_parameters(RunOptions(), pair.descriptions, {}, pair.parameters)["track"]


def test_the_pair_of_a_package_has_the_vehicles_count(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    assert gathered(tmp_path, {}) == {"wheelset_count": 1}
    with pytest.raises(ParameterError, match=r"track\.wheelset_count = 3: the vehicle FMU has 1"):
        gathered(tmp_path, {"wheelset_count": 3})
