"""What the builder writes: valid, complete, reproducible."""

import datetime
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmi_builds import PACKAGES, SUPPORT, mass_spring_fmu
from fmpy.validation import validate_fmu
from lxml import etree
from rail_fmi import BuildError
from rail_fmi.builder import build_fmu

SCHEMAS = Path(fmpy.__file__).parent


def member(name: str) -> bytes:
    with zipfile.ZipFile(mass_spring_fmu()) as archive:
        return archive.read(name)


def assert_valid(xml: bytes, schema: str) -> None:
    etree.XMLSchema(etree.parse(SCHEMAS / schema)).assertValid(etree.fromstring(xml))


def test_fmpy_finds_no_problem():
    assert validate_fmu(str(mass_spring_fmu())) == []


def test_description_satisfies_the_fmi_schema():
    assert_valid(member("modelDescription.xml"), "schema/fmi2/fmi2ModelDescription.xsd")


def test_preset_satisfies_the_ssp_schema_and_has_units():
    xml = member("resources/presets/heavy.ssv")
    assert_valid(xml, "ssp/schema/SystemStructureParameterValues.xsd")
    values = {
        parameter.get("name"): dict(parameter[0].attrib)
        for parameter in ElementTree.fromstring(xml)[0]
    }
    assert values["mass"] == {"value": "500.0", "unit": "kg"}
    assert values["spring.law"] == {"value": "cubic"}
    assert values["spring.hertz_constant"] == {"value": "2e-07"}  # no integer exponents


def test_description_says_what_the_table_says():
    root = ElementTree.fromstring(member("modelDescription.xml"))
    variables = {v.get("name"): v for v in root.find("ModelVariables")}
    assert dict(variables["spring.stiffness"][0].attrib) == {
        "declaredType": "Stiffness",
        "unit": "N/m",
        "min": "0.0",
        "start": "10000.0",
    }
    assert variables["force"][0].get("nominal") == "1000.0"
    units = {u.get("name"): u.find("BaseUnit") for u in root.find("UnitDefinitions")}
    assert dict(units["N.s/m"].attrib) == {"kg": "1", "s": "-1"}
    assert units["m/N^(2/3)"] is None
    capabilities = root.find("CoSimulation").attrib
    assert capabilities["canGetAndSetFMUstate"] == capabilities["canSerializeFMUstate"] == "true"
    assert capabilities["canBeInstantiatedOnlyOncePerProcess"] == "false"
    names = [v.get("name") for v in root.find("ModelVariables")]
    unknown = [names[int(u.get("index")) - 1] for u in root.find("ModelStructure/InitialUnknowns")]
    assert unknown == ["omega", "position", "velocity", "steps", "moving", "say"]
    assert root.find("DefaultExperiment").attrib == {"startTime": "0.0", "stepSize": "0.001"}


def test_rebuild_is_identical(tmp_path):
    again = build_fmu(SUPPORT / "mass_spring_fmu.py", PACKAGES, tmp_path)
    assert again.read_bytes() == mass_spring_fmu().read_bytes()


def test_date_is_that_of_the_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    fmu = build_fmu(SUPPORT / "mass_spring_fmu.py", PACKAGES, tmp_path)
    description = fmpy.read_model_description(str(fmu))
    assert description.generationDateAndTime == "2023-11-14T22:13:20Z"
    usual = fmpy.read_model_description(str(mass_spring_fmu()))
    assert description.guid == usual.guid  # the date is not part of the identity
    date = datetime.datetime.strptime(usual.generationDateAndTime, "%Y-%m-%dT%H:%M:%SZ")
    assert date < datetime.datetime.now(datetime.UTC).replace(tzinfo=None)


def test_other_sources_give_another_guid(tmp_path):
    script = tmp_path / "mass_spring_fmu.py"
    script.write_text((SUPPORT / "mass_spring_fmu.py").read_text() + "\n# changed\n")
    other = fmpy.read_model_description(str(build_fmu(script, PACKAGES, tmp_path)))
    assert other.guid != fmpy.read_model_description(str(mass_spring_fmu())).guid


def test_contents():
    with zipfile.ZipFile(mass_spring_fmu()) as archive:
        names = archive.namelist()
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    assert names == sorted(names)
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]
    assert "binaries/linux64/MassSpring.so" in names
    assert member("resources/requirements.txt").split() == [
        b"numpy>=2.0",
        b"scipy>=1.15",
    ]
    assert b"| `spring.law` | parameter | string |" in member("documentation/variables.md")
    page = member("documentation/index.html").decode()
    for words in ("Deflection", "Python 3.11 or newer", "scipy&gt;=1.15", "LD_PRELOAD", "stiff?"):
        assert words in page, words
    assert b"MIT License" in member("documentation/licenses/pythonfmu.txt")
    assert b"BSD 3-Clause" in member("documentation/licenses/license.txt")


def test_build_leaves_the_process_as_it_was(tmp_path):
    code = (
        "import sys; from rail_fmi.builder import build_fmu; before = set(sys.modules), sys.path[:]"
        f"; build_fmu({str(SUPPORT / 'mass_spring_fmu.py')!r}, {PACKAGES!r}, {str(tmp_path)!r})"
        "; new = set(sys.modules) - before[0]; assert sys.path == before[1]"
        "; assert not [n for n in new if n.startswith(('mass', 'rail', 'pythonfmu'))], new"
    )
    search = os.pathsep.join(path for path in sys.path if path)
    subprocess.run(
        [sys.executable, "-c", code], check=True, env=os.environ | {"PYTHONPATH": search}
    )
    assert (tmp_path / "MassSpring.fmu").is_file()


def test_unknown_package_is_refused(tmp_path):
    with pytest.raises(BuildError, match="'no_such_package' is not an importable package"):
        build_fmu(SUPPORT / "mass_spring_fmu.py", ["no_such_package"], tmp_path)


def test_faulty_slave_is_refused_with_its_reason(tmp_path):
    script = tmp_path / "faulty_fmu.py"
    script.write_text(
        "from rail_fmi import RailSlave, Variable\n"
        "class Faulty(RailSlave):\n"
        "    MODEL_NAME = 'Faulty'\n"
        "    def declare(self):\n"
        "        return [Variable('x', unit='kN')]\n"
    )
    with pytest.raises(BuildError, match="unit 'kN': 'kN' is not known"):
        build_fmu(script, PACKAGES[:2], tmp_path)


def test_faulty_preset_is_refused(tmp_path):
    script = tmp_path / "preset_fmu.py"
    script.write_text(
        "from mass_spring.slave import MassSpringSlave\n"
        "class Preset(MassSpringSlave):\n"
        "    PRESETS = {'bad': {'mas': 1.0}}\n"
    )
    with pytest.raises(BuildError, match="did you mean mass"):
        build_fmu(script, PACKAGES, tmp_path)
