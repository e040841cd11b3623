"""Reading an SSP: roles by variables, bound values, connections; and what is refused."""

import re
import zipfile
from pathlib import Path

import pytest
from described_fmus import MOTION, fmu, track, vehicle
from rail_cosim.cache import VARIABLE
from rail_cosim.errors import FmuFileError, ParameterError, StructureError
from rail_cosim.options import RunOptions
from rail_cosim.runner import gather_parameters
from rail_cosim.ssp import write_ssp
from rail_cosim.ssp_reader import read_ssp

GIVEN = {"rail.mass": ("parameter", "m"), "count": ("parameter", None)}
SSV = (
    '<v:ParameterSet xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'version="1.0" name="s"><v:Parameters>{}</v:Parameters></v:ParameterSet>'
)
IN_PLACE = (
    "<ssd:ParameterBindings><ssd:ParameterBinding{}><ssd:ParameterValues>"
    f"{SSV}</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
)
MASS = '<v:Parameter name="{}"><v:Real value="{}"/></v:Parameter>'


@pytest.fixture(autouse=True)
def _cache(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))


@pytest.fixture
def package(tmp_path):
    """Write a pair under other names, the track first, with values bound to the track."""
    fmus = {
        "Strecke": fmu(tmp_path / "Line.fmu", track(1) | GIVEN),
        "Wagen": fmu(tmp_path / "Car.fmu", vehicle(1)),
    }
    write_ssp(tmp_path / "Pair.ssp", fmus, {}, {"Strecke": {"rail.mass": 60.25, "count": 3}})
    return tmp_path / "Pair.ssp"


def changed(package, edit=None, *, drop=(), add=None):
    """Write the package again with its structure edited, files dropped or added."""
    path = package.with_name("Changed.ssp")
    with zipfile.ZipFile(package) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "SystemStructure.ssd" and edit:
                text = edit(content.decode())
                assert text.encode() != content
                content = text.encode()
            if name not in drop:
                new.writestr(name, content)
        for name, content in (add or {}).items():
            new.writestr(name, content)
    return path


def test_roles_are_found_by_variables(package):
    system = read_ssp(package)
    assert system.names == {"vehicle": "Wagen", "track": "Strecke"}
    assert system.descriptions["vehicle"].path.name == "Car.fmu"
    assert system.remarks == []


def test_bound_values_are_set(package):
    system = read_ssp(package)
    assert system.parameters == {"vehicle": {}, "track": {"rail.mass": "60.25", "count": "3"}}
    found = gather_parameters(RunOptions(), system.descriptions, {}, system.parameters)
    assert found["track"] == {"rail.mass": 60.25, "count": 3}
    settings = RunOptions(settings=["track.rail.mass=7"])
    found = gather_parameters(settings, system.descriptions, {}, system.parameters)
    assert found["track"]["rail.mass"] == 7.0


def test_a_later_binding_and_the_systems_own_win(package):
    def later(text):
        more = IN_PLACE.format("", MASS.format("rail.mass", 61))
        return text.replace("</ssd:ParameterBindings>", more[len("<ssd:ParameterBindings>") :], 1)

    assert read_ssp(changed(package, later)).parameters["track"]["rail.mass"] == "61"

    def above(text):
        more = IN_PLACE.format("", MASS.format("Strecke.rail.mass", 62))
        return text.replace("<ssd:Elements>", more + "<ssd:Elements>", 1)

    assert read_ssp(changed(package, above)).parameters["track"]["rail.mass"] == "62"


def test_a_prefix_belongs_to_the_names(package):
    def prefixed(text):
        more = IN_PLACE.format(' prefix="rail."', MASS.format("mass", 63))
        return text.replace("</ssd:ParameterBindings>", more[len("<ssd:ParameterBindings>") :], 1)

    assert read_ssp(changed(package, prefixed)).parameters["track"]["rail.mass"] == "63"


def test_a_set_inside_the_fmu(package, tmp_path):
    with zipfile.ZipFile(tmp_path / "Line.fmu", "a") as archive:
        archive.writestr("resources/own.ssv", SSV.format(MASS.format("rail.mass", 64)))
    again = tmp_path / "Again.ssp"
    names = {"Strecke": tmp_path / "Line.fmu", "Wagen": tmp_path / "Car.fmu"}
    write_ssp(again, names, {}, {"Strecke": {"rail.mass": 1.0}})

    def inside(text):
        old = 'source="resources/Strecke-start.ssv"'
        return text.replace(old, 'source="resources/own.ssv" sourceBase="component"')

    assert read_ssp(changed(again, inside)).parameters["track"] == {"rail.mass": "64"}


def test_connections_left_open_are_told(package):
    def one_less(text):
        return re.sub(r"<ssd:Connection [^>]*yaw_rate[^>]*/>", "", text, count=1)

    (remark,) = read_ssp(changed(package, one_less)).remarks
    assert "Strecke.wheelset[1].yaw_rate open" in remark
    every = re.compile(r"<ssd:Connection [^>]*/>")
    (remark,) = read_ssp(changed(package, lambda text: every.sub("", text))).remarks
    assert f"and {len(MOTION) + 5} more" in remark


def crossed(text):
    old = 'endConnector="wheelset[1].roll_angle"'
    return text.replace(old, 'endConnector="wheelset[1].yaw_angle"')


def backwards(text):
    pattern = r'startElement="Wagen"( startConnector="[^"]*roll_angle") endElement="Strecke"'
    return re.sub(pattern, r'startElement="Strecke"\1 endElement="Wagen"', text)


def mapped(text):
    new = '<ssd:ParameterMapping source="m.ssm"/></ssd:ParameterBinding>'
    return re.sub(r"(<ssd:ParameterBinding [^>]*[^/]) ?/>", rf"\1>{new}", text, count=1)


def nested(text):
    text = text.replace('<ssd:Component name="Wagen"', '<ssd:System name="Wagen"')
    head, tail = text.rsplit("</ssd:Component>", 1)
    return f"{head}</ssd:System>{tail}"


@pytest.mark.parametrize(
    ("edit", "match"),
    [
        (crossed, r"roll_angle with Strecke.wheelset\[1\].yaw_angle joins different names"),
        (backwards, "is none: there is no output of this name"),
        (mapped, "ParameterMapping, which is not supported"),
        (nested, "Wagen is a System; only components that are FMUs"),
        (
            lambda text: text.replace("resources/Car.fmu", "resources/Line.fmu"),
            r"there must be one vehicle; there are 0 \(none\)",
        ),
    ],
)
def test_other_systems_are_refused(package, edit, match):
    with pytest.raises(StructureError, match=match):
        read_ssp(changed(package, edit))


def test_another_unit_is_refused(package):
    bad = SSV.format('<v:Parameter name="rail.mass"><v:Real value="60" unit="mm"/></v:Parameter>')
    path = changed(
        package, drop=["resources/Strecke-start.ssv"], add={"resources/Strecke-start.ssv": bad}
    )
    with pytest.raises(
        ParameterError, match=r"Strecke.rail.mass = 60: is bound in mm, but .* in m;"
    ):
        read_ssp(path)


def test_missing_and_broken_files_are_named(package, tmp_path):
    with pytest.raises(FmuFileError, match=r"no 'resources/Strecke-start.ssv' in the package"):
        read_ssp(changed(package, drop=["resources/Strecke-start.ssv"]))
    with pytest.raises(FmuFileError, match=r"no 'resources/Car.fmu' in the package"):
        read_ssp(changed(package, drop=["resources/Car.fmu"]))
    with pytest.raises(FmuFileError, match="this is no SSP package"):
        read_ssp(changed(package, drop=["SystemStructure.ssd"]))
    with pytest.raises(FmuFileError, match="this is a directory, not an SSP package"):
        read_ssp(tmp_path)
    with pytest.raises(FmuFileError, match="there is no such file"):
        read_ssp(tmp_path / "none.ssp")


@pytest.mark.parametrize(
    ("option", "value"), [("line", "x"), ("vehicle", "x"), ("track", Path("x"))]
)
def test_a_package_and_options_for_its_parts_exclude_each_other(package, option, value):
    with pytest.raises(ParameterError, match=rf"--{option} = 'x': .* has vehicle, track"):
        RunOptions(system=package, **{option: value})
