"""The system description for other tools, valid against the SSP 1.0 schemas."""

import zipfile
from pathlib import Path

import pytest
from fmpy.ssp.ssd import find_components, get_connections, read_ssd, read_ssv
from master_mocks import variable
from rail_cosim.description import FmuDescription
from rail_cosim.errors import StructureError
from rail_cosim.ssp import structure, write_ssp

SSV = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet version="1.0" name="{0}"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"><ssv:Parameters>
  <ssv:Parameter name="spacing"><ssv:Real value="0.6"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"""
HEAD = """<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{name}">
<CoSimulation modelIdentifier="{name}"/>
<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit>
<Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit><Unit name="odd"/></UnitDefinitions>
<ModelVariables>{variables}</ModelVariables></fmiModelDescription>"""
SCALAR = (
    '<ScalarVariable name="{0}" valueReference="{1}" causality="{2}"><Real unit="{3}"/>'
    "</ScalarVariable>"
)


def fmu(folder, name, variables, presets):
    scalars = [SCALAR.format(v[0], i, *v[1:]) for i, v in enumerate(variables)]
    path = folder / f"{name}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        content = HEAD.format(name=name, variables="".join(scalars))
        archive.writestr("modelDescription.xml", content)
        for preset in presets:
            archive.writestr(f"resources/presets/{preset}.ssv", SSV.format(preset))
    return path


@pytest.fixture
def package(tmp_path):
    track = [
        ("wheelset[1].z", "input", "m"),
        ("wheelset[1].f", "output", "N"),
        ("rail_head[1].f", "input", "N"),
        ("grade", "output", "odd"),
        ("spacing", "parameter", "m"),
    ]
    vehicle = [("wheelset[1].z", "output", "m"), ("wheelset[1].f", "input", "N")]
    fmus = {
        "vehicle": fmu(tmp_path, "Car", vehicle, ["paper"]),
        "track": fmu(tmp_path, "Line", track, ["HD", "ZX"]),
    }
    path = tmp_path / "Pair.ssp"
    write_ssp(path, fmus, {"track": "ZX", "vehicle": "paper"})
    return path


def test_structure_is_valid_and_complete(package):
    ssd = read_ssd(package)  # validates against the schema, and the bound .ssv too
    components = {c.name: c for c in find_components(ssd.system)}
    assert {c.name: c.source for c in components.values()} == {
        "vehicle": "resources/Car.fmu",
        "track": "resources/Line.fmu",
    }
    connectors = {(c.name, c.kind) for c in components["track"].connectors}
    # An input that nothing feeds is no connector: tools take those for connected.
    assert connectors == {
        ("wheelset[1].z", "input"),
        ("wheelset[1].f", "output"),
        ("grade", "output"),
    }
    assert [
        (a.parent.name, a.name, b.parent.name, b.name) for a, b in get_connections(ssd.system)
    ] == [
        ("track", "wheelset[1].f", "vehicle", "wheelset[1].f"),
        ("vehicle", "wheelset[1].z", "track", "wheelset[1].z"),
    ]
    assert {u.name: (u.kg, u.m, u.s) for u in ssd.units} == {"m": (0, 1, 0), "N": (1, 1, -2)}
    (binding,) = components["track"].parameterBindings
    assert binding.source == "resources/track-ZX.ssv"


def test_all_parameter_sets_are_in_the_package(package):
    for name in ("track-HD", "track-ZX", "vehicle-paper"):
        parameters = read_ssv(package, resource=f"resources/{name}.ssv").parameters
        assert [(p.name, p.value) for p in parameters] == [("spacing", "0.6")]


def test_the_package_is_the_same_bytes_every_time(package, tmp_path):
    again = tmp_path / "again" / "Pair.ssp"
    again.parent.mkdir()
    fmus = {"vehicle": tmp_path / "Car.fmu", "track": tmp_path / "Line.fmu"}
    write_ssp(again, fmus, {"track": "ZX", "vehicle": "paper"})
    assert again.read_bytes() == package.read_bytes()
    assert [p.name for p in again.parent.iterdir()] == ["Pair.ssp"]


def test_fmus_that_do_not_fit_are_not_packed():
    def described(name, *variables):
        named = {v.name: v for v in variables}
        path = Path(f"{name}.fmu")
        return FmuDescription(
            path=path, model_name=name, identifier=name, guid=name, variables=named
        )

    a = described("a", variable("x", unit="mm"), variable("y", "input"))
    b = described("b", variable("x", "input", "m"), variable("y"))
    with pytest.raises(StructureError, match="same unit"):
        structure("Pair", {"a": a, "b": b}, {})
