"""Archives and XML from elsewhere: what must not be unpacked or parsed is refused by name."""

import stat
import struct
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import pytest
from rail_cosim import archives, trust
from rail_cosim.description import read_description
from rail_cosim.errors import FmuFileError
from rail_cosim.extraction import extract
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.ssv import read_entries

PACKAGES = ("rail_cosim", "rail_fmi", "rail_quantities", "rail_vehicle", "slab_track")


def archive(path, members):
    """Write an archive; a member is a name or a ZipInfo, with its content."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members:
            file.writestr(name, content)
    return path


def link(name):
    about = zipfile.ZipInfo(name)
    about.external_attr = (stat.S_IFLNK | 0o777) << 16
    return about


OUTSIDE = ["../up", "a/../../up", "/etc/up", "\\up", "a\\..\\..\\up", "C:up", "C:/up", "//host/up"]


@pytest.mark.parametrize("name", [*OUTSIDE, "..", ""])
def test_names_that_lead_out_are_known(name):
    assert not archives.is_inside(name)


@pytest.mark.parametrize("name", ["a", "a/b.c", "..a/b..", "resources/ä b.ssv", "a/"])
def test_names_that_stay_inside_are_known(name):
    assert archives.is_inside(name)


CASES = {
    **{f"outside {name}": ([(name, "x")], "points out of the archive") for name in OUTSIDE},
    "link": ([(link("resources/there"), "/etc")], "is a link"),
    "twice": ([("A/b", "x"), ("a/B", "y")], "is there twice"),
    "many": ([(f"{i}", "") for i in range(12)], "has 12 members, more than 10"),
    "large": ([("a", "x" * 900), ("b", "x" * 900)], "GiB, more than"),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("reader", [lambda p: extract(p, "guid"), read_description, read_ssp])
def test_harmful_archives_are_refused_before_anything_is_unpacked(
    tmp_path, monkeypatch, case, reader
):
    members, text = CASES[case]
    monkeypatch.setattr(archives, "MOST_MEMBERS", 10)
    monkeypatch.setattr(archives, "LARGEST", 1000)
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(tmp_path / "cache"))
    path = archive(tmp_path / "bad.zip", members)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(FmuFileError, match=text):
        reader(path)
    left = [p for p in tmp_path.rglob("*") if p not in before and p.is_file()]
    assert left == []


def test_encrypted_members_are_refused(tmp_path):
    path = archive(tmp_path / "secret.zip", [("a", "x" * 100)])
    content = bytearray(path.read_bytes())
    for mark, place in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        content[content.index(mark) + place] |= 1
    path.write_bytes(content)
    with pytest.raises(FmuFileError, match="is encrypted"):
        extract(path, "guid")


def test_a_member_larger_than_the_archive_says_is_refused(tmp_path, monkeypatch):
    """The size is written in the list of members, the content unpacks to more."""
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(tmp_path / "cache"))
    path = archive(tmp_path / "bomb.zip", [("a", b"\0" * 100_000)])
    content = path.read_bytes()
    path.write_bytes(content.replace(struct.pack("<I", 100_000), struct.pack("<I", 10)))
    with pytest.raises(FmuFileError, match=r"damaged one|larger than"):
        extract(path, "guid")
    assert not list((tmp_path / "cache" / "extracted").iterdir())


def test_a_description_without_end_is_not_read(tmp_path, monkeypatch):
    path = archive(tmp_path / "long.fmu", [("modelDescription.xml", b" " * 5000)])
    monkeypatch.setattr(archives, "LARGEST_XML", 1000)
    with zipfile.ZipFile(path) as file, pytest.raises(FmuFileError, match="it is not read"):
        archives.read_member(file, "modelDescription.xml", 1000)


def test_truncated_archives_are_refused(tmp_path):
    whole = archive(tmp_path / "whole.zip", [("modelDescription.xml", "<a/>" * 200)]).read_bytes()
    path = tmp_path / "part.fmu"
    for length in range(0, len(whole), 7):
        path.write_bytes(whole[:length])
        with pytest.raises(FmuFileError):
            read_description(path)


def test_flipped_bytes_never_cause_another_error(tmp_path):
    whole = archive(tmp_path / "whole.zip", [("modelDescription.xml", "<a/>" * 50)]).read_bytes()
    path = tmp_path / "flipped.fmu"
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 0xFF
        path.write_bytes(changed)
        with pytest.raises(FmuFileError):
            read_description(path)


LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<root>&b;</root>"""
OUTER = """<?xml version="1.0"?>
<!DOCTYPE root [<!ENTITY secret SYSTEM "file:///etc/passwd">]>
<root>&secret;</root>"""
FETCH = '<!DOCTYPE root SYSTEM "http://192.0.2.1/x.dtd"><root/>'


@pytest.mark.parametrize("text", [LAUGHS, OUTER, FETCH])
def test_document_types_are_refused_wherever_xml_is_read(tmp_path, text):
    with pytest.raises(ElementTree.ParseError, match="which is not accepted"):
        archives.parse_xml(text.encode())
    fmu = archive(tmp_path / "x.fmu", [("modelDescription.xml", text)])
    ssp = archive(tmp_path / "x.ssp", [("SystemStructure.ssd", text)])
    for read, what in (
        (read_description, fmu),
        (read_ssp, ssp),
        (lambda content: read_entries(content, "a.ssv"), text.encode()),
    ):
        with pytest.raises(FmuFileError, match="which is not accepted"):
            read(what)


@pytest.mark.parametrize(
    "content", [b"", b"\0\1\2", b"<a", b"\xff\xfe<\0", b"<?xml encoding='x'?>"]
)
def test_garbage_is_no_xml(content):
    with pytest.raises(ElementTree.ParseError):
        archives.parse_xml(content)


def test_a_damaged_extraction_is_made_anew(tmp_path, monkeypatch):
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(tmp_path / "cache"))
    path = archive(tmp_path / "a.fmu", [("resources/x.py", "good"), ("b/c", "d")])
    folder = extract(path, "guid")
    for spoil in (
        lambda: (folder / "resources" / "x.py").write_text("bad!"),
        lambda: (folder / "b" / "c").unlink(),
        lambda: (folder / "b" / "c").write_text(""),
    ):
        spoil()
        assert extract(path, "guid") == folder
        assert (folder / "resources" / "x.py").read_text() == "good"
        assert (folder / "b" / "c").read_text() == "d"


def test_other_peoples_fmus_are_announced_and_our_own_are_not(tmp_path, monkeypatch):
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(tmp_path / "cache"))
    members = [("binaries/linux64/A.so", "x"), ("resources/a.py", ""), ("resources/b.py", "")]
    path = archive(tmp_path / "A.fmu", members)
    text = trust.foreign_remark(path)
    assert str(path) in text
    assert "binaries/linux64/A.so, 2 Python files" in text
    assert "--trust" in text
    built = tmp_path / "cache" / "built" / "0123" / "HighSpeedVehicle.fmu"
    built.parent.mkdir(parents=True)
    built.write_bytes(path.read_bytes())
    assert trust.foreign_remark(path) == ""
    path.write_bytes(path.read_bytes() + b" ")
    assert trust.foreign_remark(path) != ""


def test_nothing_of_the_product_unpickles_or_evaluates():
    """Dask does between a sweep's own processes; a scheduler is named by the user only."""
    words = ("import pickle", "pickle.load", "allow_pickle=True", "eval(", "exec(", "yaml.load")
    found = []
    for package in PACKAGES:
        folder = Path(__import__(package).__file__).parent
        for path in folder.rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            found += [(path.name, word) for word in words if word in text]
    assert found == []
