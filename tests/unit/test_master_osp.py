"""The configuration for libcosim."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from described_fmus import FORCES, MOTION, fmu, track, vehicle
from lxml import etree
from rail_cosim.errors import StructureError
from rail_cosim.osp import write_osp

SCHEMA = Path(__file__).parents[1] / "support" / "osp_schema.xsd"
SPACE = {"o": "http://opensimulationplatform.com/MSMI/OSPSystemStructure"}


@pytest.fixture
def written(tmp_path):
    fmus = {
        "vehicle": fmu(tmp_path / "Car.fmu", vehicle(2)),
        "track": fmu(tmp_path / "Line.fmu", track(2) | {"mass": ("parameter", "m")}),
    }
    path = tmp_path / "OspSystemStructure.xml"
    write_osp(path, fmus, {}, {"track": {"mass": 0.1 + 0.2, "wheelset_count": 2}}, 2e-4)
    return path


def test_it_satisfies_the_schema(written):
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.parse(written))


def test_all_equal_names_are_connected(written):
    root = ElementTree.parse(written).getroot()
    pairs = [
        [(v.get("simulator"), v.get("name")) for v in pair]
        for pair in root.iterfind(".//o:VariableConnection", SPACE)
    ]
    terminals = [
        (source, f"wheelset[{i}].{name}")
        for i in (1, 2)
        for source, members in (("vehicle", MOTION), ("track", FORCES))
        for name in members
    ]
    other = {"vehicle": "track", "track": "vehicle"}
    assert sorted(pairs) == sorted([[(s, n), (other[s], n)] for s, n in terminals])


def test_values_keep_their_kind_and_all_their_bits(written):
    root = ElementTree.parse(written).getroot()
    values = {
        e.get("variable"): (e[0].tag.rpartition("}")[2], e[0].get("value"))
        for e in root.iterfind(".//o:InitialValue", SPACE)
    }
    assert values == {"mass": ("Real", "0.30000000000000004"), "wheelset_count": ("Integer", "2")}
    assert float(root.findtext("o:BaseStepSize", namespaces=SPACE)) == 2e-4
    sources = [e.get("source") for e in root.iterfind(".//o:Simulator", SPACE)]
    assert sources == ["Car.fmu", "Line.fmu"]


def test_fmus_that_do_not_fit_are_not_written(tmp_path):
    fmus = {
        "a": fmu(tmp_path / "a.fmu", vehicle(1)),
        "b": fmu(tmp_path / "b.fmu", {"x": ("input", "m")}),
    }
    with pytest.raises(StructureError, match="nothing to connect"):
        write_osp(tmp_path / "OspSystemStructure.xml", fmus, {})
    assert not (tmp_path / "OspSystemStructure.xml").exists()
