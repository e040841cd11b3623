"""A film of a run, by the command line."""

import numpy as np
import pytest
import xarray as xr
from PIL import Image

COMMON = ["--distance", 2, "--speed", 288]


@pytest.fixture(scope="module")
def filmed(fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    film = ["--animate", folder / "run.gif", "--slow-motion", 10]
    fmus.command("run", *COMMON, "--out", folder / "run.nc", *film)
    return folder


def test_film_lasts_as_long_as_asked_for(filmed):
    """2 m at 80 m/s are 25 ms; slowed down ten times, at 25 frames/s: 4 ms from frame to frame."""
    with Image.open(filmed / "run.gif") as film:
        assert film.n_frames == 7
        assert film.info["duration"] == 40


def test_filming_changes_nothing(fmus, filmed):
    fmus.invoke("run", *COMMON, "--out", filmed / "plain.nc")
    with (
        xr.open_dataset(filmed / "run.nc", engine="h5netcdf") as run,
        xr.open_dataset(filmed / "plain.nc", engine="h5netcdf") as plain,
    ):
        assert list(run.data_vars) == list(plain.data_vars)
        for name in ("normal_force", "axle_box_vertical_acceleration"):
            np.testing.assert_array_equal(run[name], plain[name])


def test_film_is_refused_before_the_run(fmus, tmp_path):
    said = fmus.command("run", *COMMON, "--animate", tmp_path / "run.avi", status=(2,)).stderr
    assert "--animate" in said
    assert "must end in .mp4 or .gif" in said
