"""Sweeps with the real FMUs: short runs with few modes, killed, resumed, and shared out."""

import os
import re
import signal
import sys
import time

import numpy as np
import pytest
import xarray as xr
from product import PATIENCE

STIFFNESS = "track.fastener.vertical_stiffness"
COARSE = """
[set]
track.rail.mode_count = 40
track.slab.mode_count = 6
track.integration.maximum_step = 2e-4
[run]
macro_step = 2e-4
distance = {distance}
[grid]
"""
GRID = "speed = [200, 300]\ntrack.fastener.vertical_stiffness = [40e6, 140e6]\n"


def specification(folder, *, grid=GRID, distance=60):
    path = folder / "spec.toml"
    path.write_text(COARSE.format(distance=distance) + grid)
    return path


def loaded(path):
    with xr.open_dataset(path, engine="h5netcdf") as file:
        return file.load()


def times(folder):
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.nc")}


@pytest.fixture(scope="module")
def two_by_two(fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    out = folder / "two.nc"
    done = fmus.command("sweep", specification(folder), "--workers", 2, "--out", out)
    return loaded(out), done, out


def test_two_by_two_points(two_by_two):
    data, done, _ = two_by_two
    assert dict(data.sizes) == {"speed": 2, STIFFNESS: 2, "wheelset": 4, "side": 2}
    assert (data["error"] == "").all()
    assert (data["steady"] == 1).all()
    assert (data["steady_change"] <= 1e-3).all()
    assert data[STIFFNESS].attrs["units"] == "N/m"
    assert data["speed"].attrs["units"] == "km/h"
    # Steady: the mean over a slab is the static load, and the sleepers come at speed / bay.
    np.testing.assert_allclose(data["normal_force_mean"], 69214.4, rtol=1e-3)
    frequency = data["axle_box_vertical_acceleration_dominant_frequency"]
    np.testing.assert_allclose(frequency[0], 200 / 3.6 / 0.629, rtol=1e-6)
    assert re.search(r"points +4", done.stdout)
    assert re.search(r"evaluated over +last slab length", done.stdout)
    assert data["normal_force_max"].attrs["evaluation_window"] == "last slab length"
    np.testing.assert_allclose(data["window_stop"] - data["window_start"], 5.032, rtol=1e-6)
    assert "Traceback" not in done.stderr


def test_a_point_is_the_run_of_its_parameters(fmus, two_by_two, tmp_path):
    arguments = ["--speed", 200, "--distance", 60, "--until-steady", 1e-3, "--macro-step", 2e-4]
    for setting in (
        f"{STIFFNESS}=140e6",
        "track.rail.mode_count=40",
        "track.slab.mode_count=6",
        "track.integration.maximum_step=2e-4",
    ):
        arguments += ["--set", setting]
    fmus.invoke("run", *arguments, "--out", tmp_path / "run.nc")
    run = loaded(tmp_path / "run.nc")
    at = two_by_two[0].sel({"speed": 200, STIFFNESS: 140e6})
    assert run.attrs["steady"] == 1
    assert float(at["distance_travelled"]) == float(run["distance"][-1])
    period = round(5.032 / (200 / 3.6) / run.attrs["macro_step"])
    last = run["normal_force"].isel(time=slice(-period, None))
    np.testing.assert_array_equal(at["normal_force_max"], last.max("time"))
    np.testing.assert_array_equal(at["normal_force_min"], last.min("time"))


def test_one_worker_gives_the_same_as_two(fmus, two_by_two, tmp_path):
    out = tmp_path / "one.nc"
    fmus.command("sweep", specification(tmp_path), "--workers", 1, "--out", out)
    assert loaded(out).identical(two_by_two[0])


def test_a_point_that_fails_is_recorded_and_not_fatal(fmus, tmp_path):
    out = tmp_path / "some.nc"
    spec = specification(tmp_path, grid="speed = [300]\ntrack.window.slab_count = [4, 13]\n")
    done = fmus.command("sweep", spec, "--out", out)
    data = loaded(out).sel(speed=300)
    bad, good = data.isel({"track.window.slab_count": 0}), data.isel({"track.window.slab_count": 1})
    assert "raise window.slab_count" in str(bad["error"].item())
    assert np.isnan(bad["normal_force_max"]).all()
    assert str(good["error"].item()) == ""
    assert np.isfinite(good["normal_force_max"]).all()
    assert "raise window.slab_count" in " ".join(done.stdout.split())
    assert "Traceback" not in done.stderr


def test_what_no_point_can_have_is_refused_at_once(fmus, tmp_path):
    grid = "track.fastener.vertical_stifness = [1e6]\n"
    done = fmus.command("sweep", specification(tmp_path, grid=grid), status=(2,))
    assert "track.fastener.vertical_stiffness" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9")
def test_killed_in_the_middle_it_goes_on_where_it_was(fmus, tmp_path):
    """The result is that of a sweep that was not killed, and no point is run twice."""
    spec = specification(tmp_path, grid="speed = [210, 230, 250, 270]\n", distance=15)
    out, store = tmp_path / "killed.nc", tmp_path / "killed.points"
    with fmus.start("sweep", spec, "--workers", 1, "--out", out, start_new_session=True) as process:
        end = time.monotonic() + PATIENCE
        while len(times(store)) < 2:
            assert process.poll() is None, "it ended before it could be killed"
            assert time.monotonic() < end, "no point was finished"
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
    before = times(store)
    assert 2 <= len(before) < 4
    assert not out.exists()
    fmus.command("sweep", spec, "--workers", 1, "--out", out)
    after = times(store)
    assert len(after) == 4
    assert {name: after[name] for name in before} == before
    whole = tmp_path / "whole.nc"
    fmus.command("sweep", spec, "--workers", 1, "--out", whole)
    assert loaded(out).identical(loaded(whole))
    fresh = times(tmp_path / "whole.points")
    assert set(fresh) == set(after)
    fmus.command("sweep", spec, "--workers", 1, "--out", whole)
    assert times(tmp_path / "whole.points") == fresh
