"""Parameters: conversion, checks, presets, settings as text."""

import zipfile

import pytest
from master_mocks import variable
from rail_cosim.errors import FmuFileError, ParameterError, UnknownNameError, nearest
from rail_cosim.parameters import checked, parse_assignments
from rail_cosim.presets import preset_files, read_preset

VARIABLES = {
    v.name: v
    for v in (
        variable(
            "fastener.vertical_stiffness",
            "parameter",
            "N/m",
            minimum=0.0,
            description="stiffness of one fastener",
        ),
        variable("slab.poisson_ratio", "parameter", "1", minimum=0.0, maximum=0.5),
        variable("rail.mode_count", "parameter", kind="integer", minimum=1),
        variable("contact.enabled", "parameter", kind="boolean", start=True),
        variable("window.method", "parameter", kind="string", start="sliding"),
        variable("basis.word", "parameter", kind="string", choices={"per_bay": 0, "per_seat": 1}),
        variable("basis", "parameter", kind="enumeration", choices={"per_bay": 1, "per_slab": 2}),
        variable("wheelset[1].left.normal_force", "output", "N"),
        variable("static_wheel_load", "calculatedParameter", "N"),
    )
}


def check(name, value):
    return checked("track", VARIABLES, {name: value})[name]


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("fastener.vertical_stiffness", "40e6", 40e6),
        ("fastener.vertical_stiffness", 0, 0.0),
        ("rail.mode_count", "200", 200),
        ("rail.mode_count", 200.0, 200),
        ("contact.enabled", "false", False),
        ("contact.enabled", True, True),
        ("window.method", "moving_mass", "moving_mass"),
        ("basis.word", "per_seat", "per_seat"),
        ("basis", "per_slab", 2),
        ("basis", 1, 1),
    ],
)
def test_values_get_the_type_of_their_variable(name, value, expected):
    result = check(name, value)
    assert result == expected
    assert type(result) is type(expected)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (
            "fastener.vertical_stiffness",
            "-1e6",
            r"track\.fastener\.vertical_stiffness = -1e6: must be at least 0 N/m; "
            "meaning: stiffness of one fastener",
        ),
        ("slab.poisson_ratio", 0.6, "= 0.6: must be at least 0 and at most 0.5$"),
        ("fastener.vertical_stiffness", "soft", "'soft': must be a finite number in N/m"),
        ("fastener.vertical_stiffness", float("nan"), "must be a finite number"),
        ("fastener.vertical_stiffness", True, "must be a finite number"),
        ("rail.mode_count", "2.5", "must be a whole number"),
        ("rail.mode_count", 0, "must be at least 1$"),
        ("contact.enabled", "perhaps", "must be true or false"),
        ("basis", "per_metre", "must be one of per_bay, per_slab"),
        (
            "basis.word",
            "per_bays",
            r"word = 'per_bays': must be one of per_bay, per_seat; did you mean per_bay\?",
        ),
        ("wheelset[1].left.normal_force", 1.0, "this is an output; only parameters can be set"),
        ("static_wheel_load", 1.0, "this is a calculated parameter"),
    ],
)
def test_wrong_values_are_refused_with_name_value_and_limit(name, value, message):
    with pytest.raises(ParameterError, match=message) as caught:
        check(name, value)
    assert caught.value.name == f"track.{name}"
    assert caught.value.exit_status == 2


def test_a_misspelt_name_is_refused_with_the_nearest_right_one():
    message = (
        r"track\.fastener\.vertical_stifness = 1\.0: there is no parameter of this name; "
        r"did you mean track\.fastener\.vertical_stiffness"
    )
    with pytest.raises(UnknownNameError, match=message):
        check("fastener.vertical_stifness", 1.0)


def test_nearest_ignores_capitals():
    assert nearest("hd", ["HD", "ZX"]) == ["HD"]


OWNERS = {"track": VARIABLES, "vehicle": {"speed": variable("speed", "parameter", "m/s")}}


def test_assignments_are_split_by_owner():
    texts = ["track.window.method = sliding", "vehicle.speed=50", "track.rail.mode_count=3=x"]
    assert parse_assignments(texts, OWNERS) == {
        "track": {"window.method": "sliding", "rail.mode_count": "3=x"},
        "vehicle": {"speed": "50"},
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("vehicle.speed", r"there is no value; write track\.NAME=VALUE or vehicle\.NAME=VALUE"),
        ("speed=50", r"must begin with the FMU it is for; write vehicle\.speed"),
        ("trak.rail.mode_count=5", r"did you mean track\.rail\.mode_count"),
    ],
)
def test_assignments_in_another_form_are_refused(text, message):
    with pytest.raises(ParameterError, match=message):
        parse_assignments([text], OWNERS)


SSV = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet version="1.0" name="HD"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"><ssv:Parameters>
  <ssv:Parameter name="fastener.vertical_stiffness"><ssv:Real value="4e7"/></ssv:Parameter>
  <ssv:Parameter name="rail.mode_count"><ssv:Integer value="600"/></ssv:Parameter>
  <ssv:Parameter name="window.method"><ssv:String value="sliding"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"""


@pytest.fixture
def fmu(tmp_path):
    path = tmp_path / "Line.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("resources/presets/HD.ssv", SSV)
        archive.writestr("resources/presets/ZX.ssv", "<broken")
    return path


def test_presets_are_read_from_the_fmu(fmu):
    assert sorted(preset_files(fmu)) == ["HD", "ZX"]
    values = checked("track", VARIABLES, read_preset(fmu, "HD", "--line"))
    assert values == {
        "fastener.vertical_stiffness": 4e7,
        "rail.mode_count": 600,
        "window.method": "sliding",
    }


def test_an_unknown_preset_is_refused_with_the_names_there_are(fmu):
    message = "--line = 'Q': there is no parameter set in Line.fmu of this name; there are HD, ZX"
    with pytest.raises(UnknownNameError, match=message):
        read_preset(fmu, "Q", "--line")


def test_a_broken_preset_is_an_error_of_the_fmu(fmu):
    with pytest.raises(FmuFileError, match=r"ZX\.ssv cannot be read"):
        read_preset(fmu, "ZX", "--line")
