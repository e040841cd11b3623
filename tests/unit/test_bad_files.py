"""Every file format of the product, spoiled in every way: one clear error, never another.

A good file is cut short at many places, its bytes are changed one at a time, it is filled with
garbage, emptied, put into another encoding, replaced by a folder, taken away and locked.
"""

import random

import pytest
import xarray as xr
from described_fmus import fmu, vehicle
from rail_cosim.case import read_case
from rail_cosim.description import read_description
from rail_cosim.errors import RailCosimError
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.ssv import read_entries
from rail_cosim.sweeps import read_specification
from rail_quantities import ParameterError
from slab_track.contact.profile_file import load_profile
from slab_track.irregularity.files import read_file

SSV = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
 version="1.0" name="a"><ssv:Parameters><ssv:Parameter name="mass"><ssv:Real value="1.0"/>
</ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"""
CASE = '[run]\nspeed = 170\ndistance = 20\nline = "HD"\n[set]\ntrack.rail.density = 7850.0\n'
SWEEP = "[run]\ndistance = 20\n[grid]\nspeed = [100, 200]\n[keep]\nnormal_force = ['max']\n"


def points(path):
    path.write_text("# unit: mm\n" + "".join(f"{y} {0.001 * y * y}\n" for y in range(-50, 40, 2)))


def csv(path):
    rows = "".join(f"{i},{0.1 * i % 1},{0.2 * i % 1}\n" for i in range(40))
    path.write_text("distance [m],level [mm],cross_level [mm]\n" + rows)


def netcdf(engine):
    def write(path):
        x = [float(i) for i in range(20)]
        data = xr.Dataset({"level": ("distance", [1e-3] * 20, {"units": "m"})}, {"distance": x})
        data.distance.attrs["units"] = "m"
        data.to_netcdf(
            path, engine=engine, format=None if engine == "h5netcdf" else "NETCDF3_64BIT"
        )

    return write


def text(content):
    return lambda path: path.write_text(content)


FORMATS = {
    "wheel profile": (points, lambda p: load_profile("wheel", str(p))),
    "rail profile": (points, lambda p: load_profile("rail", str(p))),
    "irregularity CSV": (csv, lambda p: read_file(str(p))),
    "irregularity NetCDF 3": (netcdf("scipy"), lambda p: read_file(str(p))),
    "irregularity NetCDF 4": (netcdf("h5netcdf"), lambda p: read_file(str(p))),
    "run file": (text(CASE), read_case),
    "sweep": (text(SWEEP), read_specification),
    "SSV": (text(SSV), lambda p: read_entries(p.read_bytes(), str(p))),
    "FMU": (lambda p: fmu(p, vehicle(1)), read_description),
    "SSP": (lambda p: fmu(p, vehicle(1)), read_ssp),
}
ERRORS = (ParameterError, RailCosimError)
CUTS, FLIPS, GARBAGE = 25, 60, 10


def spoiled(content):
    """Yield what a damaged file may hold."""
    chance = random.Random(1)
    yield from (content[: len(content) * i // CUTS] for i in range(CUTS))
    for _ in range(FLIPS):
        changed = bytearray(content)
        changed[chance.randrange(len(changed))] = chance.randrange(256)
        yield bytes(changed)
    yield from (chance.randbytes(chance.randrange(1, 5000)) for _ in range(GARBAGE))
    yield from (b"\0" * 1000, b"\xff" * 1000, b"\n" * 1000, b"9" * 100_000, b"nan,inf\n" * 50)
    yield content.decode("latin-1").encode("utf-16")
    yield content.decode("latin-1").replace("0", "ü").encode("latin-1")


def refusal(read, path):
    """Return why a file is not read, empty if it is; whatever else is raised is a failure."""
    try:
        found = read(path)
    except ERRORS as error:
        return str(error)
    assert found is not None
    return ""


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_are_refused_or_still_right(name, tmp_path):
    write, read = FORMATS[name]
    path = tmp_path / "a.file"
    write(path)
    content, refused, kept = path.read_bytes(), 0, 0
    for damaged in spoiled(content):
        path.write_bytes(damaged)
        why = refusal(read, path)
        refused += bool(why)
        kept += not why
        assert not why or 10 < len(why) < 2000
    print(f"{name}: {refused} refused, {kept} read")
    assert refused >= GARBAGE


@pytest.mark.parametrize("name", FORMATS)
def test_no_file_and_a_folder_are_refused(name, tmp_path):
    read = FORMATS[name][1]
    if name == "SSV":
        pytest.skip("it is read from a package")
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(ERRORS, match=str(path)):
            read(path)
