"""Irregularities from the user's file."""

import sys

import numpy as np
import pytest
from scipy.io import netcdf_file
from slab_track.irregularity import (
    FileParameters,
    Irregularity,
    IrregularityFileError,
    IrregularityParameters,
    read_file,
    track_from_rails,
)

DISTANCE = np.arange(0.0, 100.25, 0.25)
LEVEL = 2e-3 * np.sin(DISTANCE / 3.0) + 1e-3
GAUGE = 1e-3 * np.cos(DISTANCE / 5.0)


def from_file(path, **values) -> Irregularity:
    file = FileParameters(path=str(path), **values)
    return Irregularity(IrregularityParameters(file=file, start=-1e6))


def write_csv(path, header, columns, delimiter=","):
    rows = "\n".join(delimiter.join(f"{v:.17g}" for v in row) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n", encoding="utf-8")
    return path


@pytest.fixture
def csv_file(tmp_path):
    return write_csv(tmp_path / "line.csv", "distance,level,gauge", (DISTANCE, LEVEL, GAUGE))


def test_goes_through_the_values_of_the_file(csv_file):
    offsets, slopes = from_file(csv_file).evaluate(DISTANCE)
    track = track_from_rails(offsets)
    assert track[:, 0] == pytest.approx(LEVEL, abs=1e-15)
    assert track[:, 3] == pytest.approx(GAUGE, abs=1e-15)
    assert not track[:, 1:3].any()
    inside = slice(8, -8)
    slope = track_from_rails(slopes)[inside, 0]
    assert slope == pytest.approx(2e-3 / 3 * np.cos(DISTANCE / 3)[inside], abs=1e-8)


def test_interpolates_cubically_between_the_values(csv_file):
    x = np.linspace(5.0, 95.0, 1234)
    level = track_from_rails(from_file(csv_file).evaluate(x)[0])[:, 0]
    assert level == pytest.approx(2e-3 * np.sin(x / 3) + 1e-3, abs=1e-9)


def test_rails_columns_in_any_order(tmp_path):
    columns = (DISTANCE, LEVEL, 2 * LEVEL, -LEVEL)
    header = "distance, right_lateral, left_vertical, right_vertical"
    offsets, _ = from_file(write_csv(tmp_path / "a.csv", header, columns)).evaluate(DISTANCE)
    assert offsets[:, 1, 1] == pytest.approx(LEVEL, abs=1e-15)
    assert offsets[:, 0, 0] == pytest.approx(2 * LEVEL, abs=1e-15)
    assert offsets[:, 1, 0] == pytest.approx(-LEVEL, abs=1e-15)
    assert not offsets[:, 0, 1].any()


@pytest.mark.parametrize(
    ("header", "delimiter"),
    [
        ("# measured\n\ndistance [km];level [mm]", ";"),
        ("\ufeffdistance (km)\tlevel (mm)", "\t"),
    ],
)
def test_delimiters_comments_and_units(tmp_path, header, delimiter):
    columns = (DISTANCE / 1e3, LEVEL * 1e3)
    read = read_file(str(write_csv(tmp_path / "a.txt", header, columns, delimiter)))
    assert read["distance"] == pytest.approx(DISTANCE, abs=1e-9)
    assert read["level"] == pytest.approx(LEVEL, abs=1e-12)


def test_fades_to_zero_beyond_both_ends_without_jump(csv_file):
    irregularity = from_file(csv_file, fade_length=30.0)
    step = 2.0**-8
    x = np.arange(-40.0, 140.0, step)
    offsets, slopes = irregularity.evaluate(x)
    middle = (offsets[2:] - offsets[:-2]) / (2 * step)
    assert np.abs(middle - slopes[1:-1]).max() < 1e-5
    assert np.abs(np.diff(slopes, axis=0)).max() < 4e-3 * step
    outside = (x <= -30) | (x >= 130)
    assert not offsets[outside].any()
    assert not slopes[outside].any()
    # The end's slope must not lead far away: no farther than a small share of the end's value.
    level = track_from_rails(offsets)[:, 0]
    tail = level[(x > 100) & (x < 130)]
    assert tail.min() > min(0.0, LEVEL[-1]) - 2e-4
    assert tail.max() < max(0.0, LEVEL[-1]) + 2e-4
    assert track_from_rails(irregularity.evaluate([-15.0])[0])[0, 0] == pytest.approx(
        LEVEL[0] / 2, rel=1e-9
    )


def test_fade_shorter_than_the_intervals(tmp_path):
    path = write_csv(tmp_path / "a.csv", "distance,level", ([0.0, 10.0], [0.0, 1e-2]))
    irregularity = from_file(path, fade_length=5.0)
    offsets, slopes = irregularity.evaluate([5.0, 10.0 - 1e-9, 10.0, 15.0, 16.0])
    assert offsets[:, 0, 0] == pytest.approx([5e-3, 1e-2, 1e-2, 0, 0], abs=1e-11)
    assert slopes[:, 0, 0] == pytest.approx([1e-3, 1e-3, 1e-3, 0, 0], abs=1e-9)


def test_position_moves_the_file_along_the_line(csv_file):
    here, there = from_file(csv_file), from_file(csv_file, position=1e6)
    x = np.linspace(-30, 130, 999)
    assert there.evaluate(x + 1e6)[0] == pytest.approx(here.evaluate(x)[0], abs=1e-12)


def test_file_is_left_out_before_start_and_that_is_remarked(csv_file):
    file = FileParameters(path=str(csv_file))
    irregularity = Irregularity(IrregularityParameters(file=file, start=50.0))
    assert not irregularity.evaluate([49.0])[0].any()
    assert irregularity.evaluate([71.0])[0].any()
    assert "begins at 0 m, before irregularity.start = 50 m" in irregularity.remarks[0]


@pytest.mark.parametrize("version", [1, 2])
def test_classic_netcdf_with_units_and_packed_values(tmp_path, version):
    path = tmp_path / "line.nc"
    with netcdf_file(path, "w", version=version) as dataset:
        dataset.createDimension("distance", DISTANCE.size)
        dataset.createDimension("nothing", 3)
        dataset.createVariable("distance", "f8", ("distance",))[:] = DISTANCE
        dataset.variables["distance"].units = "m"
        level = dataset.createVariable("level", "i4", ("distance",))
        level[:] = np.round(LEVEL * 1e9).astype("i4")
        level.units, level.scale_factor = "mm", 1e-6
    read = read_file(str(path))
    assert set(read) == {"distance", "level"}
    assert read["level"] == pytest.approx(LEVEL, abs=1e-9)


def test_missing_value_of_netcdf_is_refused(tmp_path):
    path = tmp_path / "line.nc"
    with netcdf_file(path, "w") as dataset:
        dataset.createDimension("distance", 4)
        dataset.createVariable("distance", "f8", ("distance",))[:] = np.arange(4)
        level = dataset.createVariable("level", "f8", ("distance",))
        level[:] = [0.0, 1e-3, -999.0, 0.0]
        level.missing_value = -999.0
    with pytest.raises(IrregularityFileError, match="row 3: level is not a finite number"):
        read_file(str(path))


def write_netcdf4(path, level_unit="m"):
    h5py = pytest.importorskip("h5py", reason="NetCDF 4 needs h5py")
    with h5py.File(path, "w") as dataset:
        distance = dataset.create_dataset("distance", data=DISTANCE)
        distance.make_scale("distance")
        level = dataset.create_dataset("level", data=LEVEL)
        level.dims[0].attach_scale(distance)
        level.attrs["units"] = level_unit
        dataset.create_dataset("comment", data="text")
    return path


def test_netcdf4(tmp_path):
    read = read_file(str(write_netcdf4(tmp_path / "line.nc")))
    assert np.array_equal(read["distance"], DISTANCE)
    assert np.array_equal(read["level"], LEVEL)
    with pytest.raises(IrregularityFileError, match="'level' in 'inch'"):
        read_file(str(write_netcdf4(tmp_path / "other.nc", "inch")))


def test_netcdf4_without_h5py_names_the_package(tmp_path, monkeypatch):
    path = tmp_path / "line.nc"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(IrregularityFileError, match=r"needs the Python package h5py.*NETCDF3"):
        read_file(str(path))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("distance,level\n", "has no rows"),
        ("distance,level\n0,0\n", "has 1 rows"),
        ("distance,levle\n0,0\n1,0\n", "unknown column 'levle'; did you mean 'level'"),
        ("x,level\n0,0\n1,0\n", "unknown column 'x'; expected are distance"),
        ("level,gauge\n0,0\n1,0\n", "no column of distance"),
        ("distance\n0\n1\n", "no column of irregularity"),
        ("distance,level,level\n0,0,0\n1,0,0\n", "column 'level' twice"),
        ("distance,level,left_vertical\n0,0,0\n1,0,0\n", "one direction twice: left_vertical, lev"),
        ("distance,level\n0,0\n1,0,5\n", "line 3 has 3 cells where the header has 2"),
        ("distance,level,gauge\n0,0\n1,0\n", "line 2 has 2 cells where the header has 3"),
        ("distance,level\n0,0\n# note\n1,none\n", "line 4: 'none' is no number"),
        ("distance,level\n0,0\n1,nan\n", "row 2: level is not a finite number"),
        ("distance,level\n0,0\n2,0\n1,0\n", "row 3: distance 1 m follows 2 m"),
        ("distance,level\n0,0\n0,0\n", "row 2: distance 0 m follows 0 m"),
        ("distance,level\n0,0\n1,2.5\n", r"level is 2.5 m, more than 0.1 m.*\[mm\]"),
        ("distance,level [in]\n0,0\n1,0\n", "'level' in 'in'; use m or mm"),
        ("0,0\n1,0\n", "unknown column '0'"),
    ],
)
def test_faulty_files_are_refused_with_the_place_of_the_fault(tmp_path, content, message):
    path = tmp_path / "faulty.csv"
    path.write_text(content)
    with pytest.raises(IrregularityFileError, match=message):
        from_file(path)


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(IrregularityFileError, match="cannot be read: No such file"):
        from_file(tmp_path / "absent.csv")
    (tmp_path / "a.bin").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(IrregularityFileError, match="neither CSV text"):
        from_file(tmp_path / "a.bin")
    (tmp_path / "b.nc").write_bytes(b"CDF\x05" + bytes(40))
    with pytest.raises(IrregularityFileError, match="CDF-5"):
        from_file(tmp_path / "b.nc")
