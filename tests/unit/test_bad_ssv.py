"""Parameter sets (SSV) with values that no one should give, wherever a package binds them.

Each is refused in one message that names the file or the parameter, the value and the limit;
none is set, and none is left out in silence.
"""

import zipfile

import pytest
from described_fmus import fmu, track, vehicle
from rail_cosim.cache import VARIABLE
from rail_cosim.errors import FmuFileError, ParameterError, RailCosimError
from rail_cosim.options import RunOptions
from rail_cosim.runner import gather_parameters
from rail_cosim.ssp import write_ssp
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.ssv import read_entries

SPACE = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SET = f'<v:ParameterSet xmlns:v="{SPACE}" version="1.0" name="s"><v:Parameters>{{}}</v:Parameters>'
SET += "</v:ParameterSet>"
DECLARED = {
    "mass": '<Real unit="m" min="0" max="100" start="60"/>',
    "count": '<Integer min="1" start="3"/>',
    "size": '<Integer start="3"/>',
    "enabled": '<Boolean start="true"/>',
    "method": '<String start="sliding"/>',
}
FIXED = (
    '<ScalarVariable name="{}" valueReference="{}" causality="parameter" variability="fixed">{}'
    "</ScalarVariable>"
)


def one(name, value):
    return f'<v:Parameter name="{name}">{value}</v:Parameter>'


NUMBERS = ("nan", "NaN", "inf", "-inf", "INF", "1e400", "", " ", "sixty", "60 m", "0x3c", "6,5")
NUMBERS += ("1e", "1_0_", "true", "None", "[60]", "60;61", "٦e", "1" * 5000)
VALUES = [
    *(("mass", f'<v:Real value="{value}"/>', "must be a finite number") for value in NUMBERS),
    *(("count", f'<v:Integer value="{value}"/>', "must be a finite number") for value in NUMBERS),
    ("mass", '<v:Real value="-1e-9"/>', "must be at least 0 and at most 100 m"),
    ("mass", '<v:Real value="100.0001"/>', "must be at least 0 and at most 100 m"),
    ("mass", '<v:Real value="1e30"/>', "must be at least 0 and at most 100 m"),
    ("count", '<v:Integer value="0"/>', "must be at least 1"),
    ("count", '<v:Integer value="-2147483648"/>', "must be at least 1"),
    ("count", '<v:Integer value="2.5"/>', "must be a whole number"),
    ("size", '<v:Integer value="2147483648"/>', "must be a whole number of 32 bits"),
    ("size", '<v:Integer value="1e30"/>', "must be a whole number of 32 bits"),
    ("enabled", '<v:Boolean value="2"/>', "must be true or false"),
    ("enabled", '<v:Boolean value=""/>', "must be true or false"),
    ("enabled", '<v:Boolean value="wahr"/>', "must be true or false"),
    ("mass", '<v:Boolean value="true"/>', "is given as Boolean, but the variable is Real"),
    ("mass", '<v:String value="60"/>', "is given as String, but the variable is Real"),
    ("count", '<v:Boolean value="1"/>', "is given as Boolean, but the variable is Integer"),
    ("enabled", '<v:Real value="1.0"/>', "is given as Real, but the variable is Boolean"),
    ("enabled", '<v:Integer value="1"/>', "is given as Integer, but the variable is Boolean"),
    ("method", '<v:Real value="1.0"/>', "is given as Real, but the variable is String"),
    ("mass", '<v:Real value="60" unit="mm"/>', "is bound in mm, but the variable is in m"),
    ("mass", '<v:Real value="60" unit="kg"/>', "is bound in kg, but the variable is in m"),
    ("mess", '<v:Real value="60"/>', "no parameter of this name; did you mean track.mass"),
    ("Mass", '<v:Real value="60"/>', "no parameter of this name; did you mean track.mass"),
    ("mass ", '<v:Real value="60"/>', "no parameter of this name; did you mean track.mass"),
    ("wheelset[1].contact.roll_moment", '<v:Real value="1"/>', "this is an output"),
]
SHAPES = {
    "no value": (one("mass", ""), "mass must have one value, .* it has none"),
    "two values": (one("mass", '<v:Real value="1"/><v:Real value="2"/>'), "it has Real, Real"),
    "unknown type": (one("mass", '<v:Float value="1"/>'), "it has Float"),
    "binary": (one("mass", '<v:Binary value="00"/>'), "it has Binary"),
    "other space": (one("mass", '<Real value="1"/>'), "it has none|it has Real"),
    "value missing": (one("mass", "<v:Real/>"), "the Real of mass has no value"),
    "value as text": (one("mass", "<v:Real>60</v:Real>"), "the Real of mass has no value"),
    "value by another name": (one("mass", '<v:Real val="6"/>'), "the Real of mass has no value"),
    "no name": ('<v:Parameter><v:Real value="1"/></v:Parameter>', "parameter 1 has no name"),
    "empty name": (one("", '<v:Real value="1"/>'), "parameter 1 has no name"),
    "twice": (2 * one("mass", '<v:Real value="1"/>'), "mass is there twice"),
}


@pytest.fixture
def bind(tmp_path, monkeypatch):
    """Return a function that binds the content of a set to the track and reads the package."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    numbers = enumerate(DECLARED.items(), start=100)
    more = "".join(FIXED.format(name, number, about) for number, (name, about) in numbers)
    edit = lambda text: text.replace("</ModelVariables>", f"{more}</ModelVariables>")  # noqa: E731
    fmus = {
        "Car": fmu(tmp_path / "Car.fmu", vehicle(1)),
        "Line": fmu(tmp_path / "Line.fmu", track(1), edit=edit),
    }
    write_ssp(tmp_path / "Pair.ssp", fmus, {}, {"Line": {"mass": 1.0}})

    def read(content, place="file"):
        path = tmp_path / "Bound.ssp"
        with zipfile.ZipFile(tmp_path / "Pair.ssp") as old, zipfile.ZipFile(path, "w") as new:
            for name in old.namelist():
                data = old.read(name)
                if name == "resources/Line-start.ssv" and place == "file":
                    data = SET.format(content).encode()
                if name == "SystemStructure.ssd" and place == "in place":
                    data = in_place(data.decode(), content).encode()
                new.writestr(name, data)
        system = read_ssp(path)
        return gather_parameters(RunOptions(), system.descriptions, {}, system.parameters)

    return read


def in_place(structure, content):
    """Return the description with a set for the system, written in place."""
    values = f"<ssd:ParameterValues>{SET.format(content)}</ssd:ParameterValues>"
    binding = f"<ssd:ParameterBinding>{values}</ssd:ParameterBinding>"
    bindings = f"<ssd:ParameterBindings>{binding}</ssd:ParameterBindings>"
    return structure.replace("<ssd:Elements>", bindings + "<ssd:Elements>", 1)


@pytest.mark.parametrize("place", ["file", "in place"])
def test_good_values_of_all_types_are_set(bind, place):
    owner = "Line." * (place == "in place")
    good = {"mass": ("Real", "61.5"), "count": ("Integer", "7"), "size": ("Integer", "-4")}
    good |= {"enabled": ("Boolean", "false"), "method": ("String", "ü")}
    content = "".join(one(owner + n, f'<v:{t} value="{v}"/>') for n, (t, v) in good.items())
    expected = {"mass": 61.5, "count": 7, "size": -4, "enabled": False, "method": "ü"}
    assert bind(content, place)["track"] == expected


@pytest.mark.parametrize("place", ["file", "in place"])
def test_bad_values_are_refused_with_name_value_and_limit(bind, place):
    for name, value, limit in VALUES:
        owner = "Line." * (place == "in place")
        with pytest.raises(ParameterError, match=limit) as caught:
            bind(one(owner + name, value), place)
        assert f".{name} = " in str(caught.value)
        assert len(str(caught.value)) < 6000


@pytest.mark.parametrize("place", ["file", "in place"])
@pytest.mark.parametrize("shape", SHAPES)
def test_sets_of_another_shape_are_refused_with_file_and_parameter(bind, shape, place):
    content, match = SHAPES[shape]
    file = "Line-start.ssv" if place == "file" else "SystemStructure.ssd"
    with pytest.raises(FmuFileError, match=rf"{file}: .*({match})"):
        bind(content, place)


@pytest.mark.parametrize("name", ["Lane.mass", "mass", "track.mass", ".mass", "Line"])
def test_values_for_no_component_or_no_variable_are_refused(bind, name):
    """They were left out in silence once."""
    with pytest.raises(ParameterError, match="there is no"):
        bind(one(name, '<v:Real value="60"/>'), "in place")


@pytest.mark.parametrize(
    "content",
    [
        "<ParameterSet/>",
        f'<ParameterSet xmlns="{SPACE}2"/>',
        f'<Parameters xmlns="{SPACE}"/>',
        "<html><body/></html>",
    ],
)
def test_another_kind_of_xml_is_no_parameter_set(content):
    with pytest.raises(RailCosimError, match=r"a\.ssv: this is no parameter set"):
        read_entries(content.encode(), "a.ssv")
