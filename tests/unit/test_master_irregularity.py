"""The option --irregularity, and the wheel radius that the vehicle passes to the track."""

import master_mocks as mocks
import pytest
from master_mocks import variable
from rail_cosim.description import FmuDescription
from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.initialisation import initialise
from rail_cosim.irregularity import (
    irregularity_parameters,
    irregularity_words,
    joint_position,
)
from rail_cosim.options import RunOptions
from rail_cosim.runner import gather_parameters
from rail_cosim.system import SystemStructure

SPECTRA = {word: i for i, word in enumerate(("none", "german_low", "german_high"))}
SIDES = {"none": 0, "both": 1}
TRACK = {
    v.name: v
    for v in (
        variable("irregularity.spectrum", "parameter", kind="string", choices=SPECTRA),
        variable("irregularity.rail_joint.side", "parameter", kind="string", choices=SIDES),
        variable("irregularity.rail_joint.position", "parameter", "m", start=20.0),
        variable("irregularity.file.path", "parameter", kind="string", start=""),
        variable("irregularity.rail_joint.long_wavelength", "parameter", "m", start=1.0),
        variable("fastener.spacing", "parameter", "m", start=0.629),
        variable("contact.wheel_radius", "parameter", "m", start=0.46, minimum=0.1),
        variable("static_wheel_load", "parameter", "N"),
    )
}
VEHICLE = {
    v.name: v
    for v in (
        variable("initial_position", "parameter", "m"),
        variable("speed", "parameter", "m/s", start=80.0),
        variable("wheelset.radius", "parameter", "m", start=0.43),
    )
}
JOINT = {"irregularity.rail_joint.side": "both", "irregularity.rail_joint.position": 22.2}


def given(text, track=TRACK):
    return irregularity_parameters(text, track, start=10.0, spacing=0.6)


def test_names_are_spectra_or_the_rail_joint():
    assert given("german_low") == {"irregularity.spectrum": "german_low"}
    assert given("rail_joint")["irregularity.rail_joint.side"] == "both"


@pytest.mark.parametrize("start", [0.0, 0.3, -7.0, 1e5])
@pytest.mark.parametrize("spacing", [0.5, 0.6, 0.629, 0.63])
def test_the_joint_is_at_the_first_mid_span_12_m_ahead(start, spacing):
    """Fasteners are at (k + 1/2) spacings along the line."""
    ahead = joint_position(start, spacing) - start
    assert 12.0 - 1e-6 <= ahead < 12.0 + spacing
    to_fasteners = ((start + ahead) / spacing - 0.5) % 1.0
    assert to_fasteners == pytest.approx(0.5, abs=1e-6)


def test_on_the_line_hd_the_joint_is_at_the_middle_of_a_slab():
    slab = 8 * 0.629
    assert joint_position(0.0, 0.629) == pytest.approx(2.5 * slab)


def test_a_file_becomes_an_absolute_path(tmp_path, monkeypatch):
    (tmp_path / "line.csv").write_text("distance,level\n")
    monkeypatch.chdir(tmp_path)
    path = str((tmp_path / "line.csv").resolve())
    assert given("line.csv") == {"irregularity.file.path": path}


def test_an_unknown_name_is_refused_with_the_nearest_and_all_names():
    message = (
        r"--irregularity = 'german_lo': there is no irregularity and no file of this name; did you "
        r"mean german_low.*\(there are none, german_low, german_high, rail_joint\)"
    )
    with pytest.raises(UnknownNameError, match=message) as caught:
        given("german_lo")
    assert caught.value.exit_status == 2
    with pytest.raises(UnknownNameError, match="there are none, german_low, german_high"):
        given("swell")


def test_a_runs_irregularity_is_said_with_its_fade_in_by_distance_travelled():
    about = {
        "vehicle.initial_position": 5.0,
        "track.irregularity.spectrum": "none",
        "track.irregularity.seed": 1,
        "track.irregularity.file.path": "/far/away/line.csv",
        "track.irregularity.start": 10.0,
        "track.irregularity.ramp_length": 20.0,
        "track.irregularity.rail_joint.side": "none",
        "track.irregularity.rail_joint.position": 12.58,
    }
    file = "line.csv; faded in from 5 to 25 m distance travelled (track.irregularity.ramp_length)"
    assert irregularity_words(about) == file
    full = about | {"track.irregularity.ramp_length": 0.0, "track.irregularity.spectrum": "german"}
    assert irregularity_words(full) == "german, realisation 1; line.csv"
    joint = about | {"track.irregularity.rail_joint.side": "both"}
    assert irregularity_words(joint) == f"{file}; rail joint at 7.58 m distance travelled"
    assert irregularity_words({}) == ""
    assert irregularity_words(about | {"track.irregularity.file.path": ""}) == ""


def test_a_track_without_irregularities_is_told(tmp_path):
    with pytest.raises(ParameterError, match=r"has no irregularities; .* irregularity\.spectrum"):
        given("rail_joint", {})
    path = tmp_path / "line.csv"
    path.touch()
    with pytest.raises(ParameterError, match="takes no irregularity from a file"):
        given(str(path), {})


def gathered(track=TRACK, vehicle=VEHICLE, **options):
    descriptions = {
        name: FmuDescription(
            path=None, model_name=name, identifier=name, guid="", variables=variables
        )
        for name, variables in (("track", track), ("vehicle", vehicle))
    }
    return gather_parameters(RunOptions(**options), descriptions, {})


def test_the_joint_does_not_depend_on_the_distance():
    places = [
        gathered(irregularity="rail_joint", distance=distance)["track"]
        for distance in (14, 20, 999)
    ]
    assert places[0]["irregularity.rail_joint.position"] == pytest.approx(20 * 0.629)
    assert places[0] == places[1] == places[2]


def test_the_joint_follows_the_start_and_the_spacing_that_are_set():
    found = gathered(
        irregularity="rail_joint",
        settings=["vehicle.initial_position=10", "track.fastener.spacing=0.6"],
    )
    assert found["track"] == pytest.approx(JOINT | {"fastener.spacing": 0.6})


def test_settings_win_over_the_option():
    text = "track.irregularity.rail_joint.position=33"
    found = gathered(irregularity="rail_joint", settings=[text])
    assert found["track"] == JOINT | {"irregularity.rail_joint.position": 33.0}


def test_a_joint_that_the_run_does_not_pass_is_refused():
    message = (
        r"--distance = 8.0: the run ends before the rail joint, 12.58 m ahead .*position = 12.58 "
        r"m\); take at least 13.08 m"
    )
    with pytest.raises(ParameterError, match=message):
        gathered(irregularity="rail_joint", distance=8.0)
    side = "track.irregularity.rail_joint.side=both"
    with pytest.raises(ParameterError, match="before the rail joint, 20 m ahead"):
        gathered(settings=[side], distance=20.0)
    assert gathered(settings=[side], distance=20.5)["track"]
    assert gathered(distance=8.0)["track"] == {}


@pytest.mark.parametrize(
    ("vehicle", "expected"), [(VEHICLE, {}), ({}, {"contact.wheel_radius": 0.46})]
)
def test_a_lines_preset_does_not_decide_on_the_vehicles_wheels(monkeypatch, vehicle, expected):
    preset = {"contact.wheel_radius": "0.46"}
    monkeypatch.setattr("rail_cosim.presets.read_preset", lambda *_: preset)
    descriptions = {
        "track": FmuDescription(path=None, model_name="", identifier="", guid="", variables=TRACK),
        "vehicle": FmuDescription(
            path=None, model_name="", identifier="", guid="", variables=vehicle
        ),
    }
    options = RunOptions(line="HD")
    assert gather_parameters(options, descriptions, {"track": "HD"})["track"] == expected


def initialised(track_given, *, radius=0.43):
    contact = variable("contact.wheel_radius", "parameter", "m", start=0.46)
    own = variable("wheelset.radius", "parameter", "m", start=radius)
    calls = []
    system = SystemStructure(
        [
            mocks.MockTrack(extra=[contact], calls=calls),
            mocks.MockVehicle(extra=[own], calls=calls),
        ]
    )
    system["track"].data.update(track_given)
    remarks = initialise(system, parameters={"track": track_given}, input_times={}, stop_time=1.0)
    return system, remarks, calls


def test_the_track_gets_the_vehicles_wheel_radius_before_it_finds_its_equilibrium():
    system, remarks, calls = initialised({})
    assert system["track"].data["contact.wheel_radius"] == 0.43
    assert remarks == []
    passed = calls.index(("track", "set", "contact.wheel_radius"))
    assert passed < calls.index(("track", "enter_initialization"))


def test_a_wheel_radius_set_apart_is_kept_with_a_warning():
    system, remarks, _ = initialised({"contact.wheel_radius": 0.5})
    assert system["track"].data["contact.wheel_radius"] == 0.5
    (text,) = remarks
    assert text.startswith("track.contact.wheel_radius = 0.5 m, but vehicle.wheelset.radius = 0.43")


def test_equal_wheel_radii_are_no_matter_for_a_warning():
    assert initialised({"contact.wheel_radius": 0.43})[1] == []
