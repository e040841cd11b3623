"""Records as a Dataset and as NetCDF."""

import stat
import types

import master_mocks as mocks
import numpy as np
import pytest
import xarray as xr
from master_mocks import MockSlave, variable
from rail_cosim import results
from rail_cosim.errors import ResultsError, UnknownNameError
from rail_cosim.recorded import check_variables
from rail_cosim.recorder import Recorder
from rail_cosim.results import (
    Place,
    check_netcdf,
    check_writable,
    place,
    stream_netcdf,
    to_dataset,
    write_netcdf,
)
from rail_cosim.spool import Spool
from rail_cosim.system import SystemStructure


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "wheelset[4].right.normal_force",
            Place("normal_force", ("wheelset", "side"), (3, 1)),
        ),
        (
            "wheelset[2].left.rail_vertical_displacement",
            Place("rail_vertical_displacement", ("wheelset", "side"), (1, 0)),
        ),
        (
            "axle_box[1].left.vertical_acceleration",
            Place("axle_box_vertical_acceleration", ("wheelset", "side"), (0, 0)),
        ),
        (
            "wheelset[3].vertical_displacement",
            Place("wheelset_vertical_displacement", ("wheelset",), (2,)),
        ),
        (
            "wheelset[3].contact.yaw_moment",
            Place("wheelset_contact_yaw_moment", ("wheelset",), (2,)),
        ),
        (
            "bogie[2].vertical_acceleration",
            Place("bogie_vertical_acceleration", ("bogie",), (1,)),
        ),
        (
            "secondary_suspension[2].right.vertical_deflection",
            Place("secondary_suspension_vertical_deflection", ("bogie", "side"), (1, 1)),
        ),
        ("car_body.vertical_acceleration", Place("car_body_vertical_acceleration", (), ())),
        (
            "car_body_floor[3].lateral_acceleration",
            Place("car_body_floor_lateral_acceleration", ("floor_place",), (2,)),
        ),
        ("window.slide_count", Place("window_slide_count", (), ())),
        ("slab[7].vertical_displacement", Place("slab_vertical_displacement", ("slab",), (6,))),
    ],
)
def test_place_of_an_output(name, expected):
    assert place(name) == expected


def recorded(attributes=None):
    """Return the Dataset of :func:`records`."""
    return to_dataset(*records(), attributes or {})


def records(count=3, spool=None):
    """Two wheelsets; output number k of a slave has the value 100 k + record."""
    outputs = [
        variable("wheelset[1].longitudinal_position", unit="m", description="position"),
        variable("wheelset[2].longitudinal_position", unit="m", description="position"),
        variable("wheelset[1].left.normal_force", unit="N", description="force of the wheel"),
        variable("wheelset[2].right.normal_force", unit="N", description="force of the wheel"),
        variable("bogie[1].vertical_acceleration", unit="m/s2", description="Rise of bogie 1, up"),
        variable("both"),
    ]
    first = MockSlave("vehicle", [*outputs, variable("in", "input")])
    second = MockSlave("track", [variable("in"), variable("both")])
    system = SystemStructure([first, second])
    if spool is not None:
        spool = Spool(spool, Recorder(system.ports).width)
    recorder = Recorder(system.ports, spool=spool)
    for record in range(count):
        for slave in system.slaves:
            for number, name in enumerate(slave.data):
                slave.data[name] = 100.0 * number + record
        for port in system.ports:
            port.outputs.read()
        recorder.record(0.5 * record)
    return system, recorder


@pytest.mark.parametrize("streamed", [False, True])
def test_only_the_chosen_variables_are_in_the_results(streamed, tmp_path):
    patterns = ["normal_*", "both_track"]
    system, recorder = records(20, spool=tmp_path / "records")
    data = to_dataset(system, recorder, {}, variables=patterns)
    assert set(data.data_vars) == {"distance", "normal_force", "both_track"}
    whole = to_dataset(system, recorder, {})
    assert len(whole.data_vars) > 3
    xr.testing.assert_identical(
        data, whole[list(data.data_vars)].drop_vars("bogie", errors="ignore")
    )
    if streamed:
        stream_netcdf(system, recorder, {}, tmp_path / "run.nc", patterns)
        with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as read:
            xr.testing.assert_identical(read.load(), data)


def test_a_chosen_variable_that_is_none_is_refused_with_the_nearest():
    known = ["normal_force", "distance", "axle_box_vertical_acceleration"]
    check_variables(["axle_box_*", "distance"], known)
    with pytest.raises(UnknownNameError, match=r"--variables = 'normal_forc': .*mean normal_force"):
        check_variables(["normal_forc"], known)
    with pytest.raises(
        UnknownNameError, match=r"--variables = 'box\*'.*there are normal_force, dis"
    ):
        check_variables(["box*"], known)


def test_content_of_the_dataset():
    data = recorded()
    assert data["time"].to_numpy().tolist() == [0.0, 0.5, 1.0]
    assert data["wheelset"].to_numpy().tolist() == [1, 2]
    assert data["bogie"].to_numpy().tolist() == [1]
    assert data["side"].to_numpy().tolist() == ["left", "right"]
    force = data["normal_force"]
    assert force.dims == ("time", "wheelset", "side")
    assert force.attrs == {"units": "N", "long_name": "force of the wheel"}
    assert force.sel(wheelset=1, side="left").to_numpy().tolist() == [200.0, 201.0, 202.0]
    assert force.sel(wheelset=2, side="right").to_numpy().tolist() == [300.0, 301.0, 302.0]
    assert np.isnan(force.sel(wheelset=1, side="right")).all()  # the slave has no such output
    assert data["wheelset_longitudinal_position"].dims == ("time", "wheelset")
    about = {"units": "m/s2", "long_name": "Rise of the bogie, up"}
    assert data["bogie_vertical_acceleration"].attrs == about


def test_distance_is_that_travelled_by_the_leading_wheelset():
    distance = recorded()["distance"]
    assert distance.to_numpy().tolist() == [0.0, 1.0, 2.0]
    assert distance.attrs["units"] == "m"


def test_outputs_of_equal_name_are_kept_apart_by_the_slave():
    data = recorded()
    assert data["both"].to_numpy().tolist() == [500.0, 501.0, 502.0]
    assert data["both_track"].to_numpy().tolist() == [100.0, 101.0, 102.0]


def test_netcdf_round_trip_with_all_attributes(tmp_path):
    attributes = {f"track.group.parameter_{i}": float(i) for i in range(400)}
    attributes |= {"complete": True, "track.text": "per_bay", "track.count": 8, "empty": ""}
    data = recorded(attributes)
    write_netcdf(data, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as read:
        xr.testing.assert_identical(read.load().drop_attrs(), data.drop_attrs())
        assert read.attrs["complete"] == 1
        assert read.attrs["track.group.parameter_399"] == 399.0
        assert read.attrs["track.text"] == "per_bay"
        assert read.attrs["track.count"] == 8
        assert read["normal_force"].attrs["units"] == "N"
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_a_long_run_is_written_in_parts_with_the_same_content(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "_PART", 1000)
    system, recorder = records(9500, spool=tmp_path / "records")
    stream_netcdf(system, recorder, {"run": 1}, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as read:
        xr.testing.assert_identical(read.load(), to_dataset(system, recorder, {"run": 1}))
        assert read["distance"].to_numpy().tolist() == list(range(9500))
        assert read["time"].to_numpy().tolist() == [0.5 * record for record in range(9500)]


def test_records_are_the_same_in_memory_and_on_disk(tmp_path):
    (_, memory), (_, disk) = records(9500), records(9500, spool=tmp_path / "records")
    assert len(memory) == len(disk) == 9500
    for start, stop in ((0, 9500), (4090, 8200), (8192, 8193), (9000, 9500), (0, 1)):
        assert np.array_equal(memory.rows(start, stop), disk.rows(start, stop))
    for count in (1, 2000, 9499, 20000):
        one, other = memory.latest("vehicle", [0, 1], count), disk.latest("vehicle", [0, 1], count)
        assert len(one) == min(count, 9500)
        assert np.array_equal(one, other)


def test_a_failed_write_leaves_the_old_file_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    write_netcdf(recorded({"run": 1}), path)
    monkeypatch.setattr(results.os, "replace", lambda *_: (_ for _ in ()).throw(RuntimeError))
    with pytest.raises(RuntimeError):
        write_netcdf(recorded({"run": 2}), path)
    with xr.open_dataset(path, engine="h5netcdf") as read:
        assert read.attrs["run"] == 1
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_results_that_cannot_be_written_are_saved_elsewhere(tmp_path, monkeypatch):
    rescue = tmp_path / "rescue"
    rescue.mkdir()
    monkeypatch.setattr(results.tempfile, "gettempdir", lambda: str(rescue))
    with pytest.raises(ResultsError, match=r"could not be written there .* they are in"):
        write_netcdf(recorded(), tmp_path / "gone" / "run.nc")
    (saved,) = rescue.iterdir()
    with xr.open_dataset(saved, engine="h5netcdf") as read:
        assert read.sizes["time"] == 3


def test_a_place_that_cannot_be_written_is_refused_before_the_run(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(ResultsError, match=r"run\.nc: cannot be written"):
        check_writable(blocked / "run.nc")
    with pytest.raises(ResultsError, match="it is a directory"):
        check_writable(tmp_path)
    check_writable(tmp_path / "new" / "run.nc")
    assert stat.S_ISDIR((tmp_path / "new").stat().st_mode)


def test_mock_pair_gives_the_variables_of_the_contract():
    system = SystemStructure([mocks.MockTrack(), mocks.MockVehicle()])
    recorder = Recorder(system.ports)
    recorder.record(0.0)
    data = to_dataset(system, recorder, {})
    assert data["normal_force"].dims == ("time", "wheelset", "side")
    assert data["axle_box_vertical_acceleration"].dims == ("time", "wheelset", "side")
    assert data["wheelset_vertical_displacement"].dims == ("time", "wheelset")
    assert data["window_slide_count"].dims == ("time",)
    assert data["window_slide_count"].dtype == np.int32


def test_a_missing_library_is_found_before_the_run(tmp_path, monkeypatch):
    def write(*_, **__):
        raise ImportError("No module named 'h5py'")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", write)
    with pytest.raises(ResultsError, match=r"No module named 'h5py'.*install h5netcdf and h5py"):
        check_netcdf(tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


def test_no_room_is_found_before_the_file_is_begun(tmp_path, monkeypatch):
    """HDF5 would crash the process; the temporary folder takes the results."""
    rescue = tmp_path / "temporary"
    rescue.mkdir()
    free = {tmp_path: 1000, rescue: 10**9}
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(rescue))
    monkeypatch.setattr(
        "shutil.disk_usage", lambda folder: types.SimpleNamespace(free=free[folder])
    )
    data = xr.Dataset({"x": ("time", np.arange(10.0))})
    with pytest.raises(ResultsError, match=r"No space left.*they are in"):
        write_netcdf(data, tmp_path / "run.nc")
    assert not (tmp_path / "run.nc").exists()
    (kept,) = rescue.iterdir()
    assert xr.load_dataset(kept, engine="h5netcdf").equals(data)
