"""Faults around a run: a folder that takes no file, damaged caches."""

import os
import shutil
import sys
import time
import zipfile

import pytest
import xarray as xr
from product import PATIENCE, Product

SHORT = ["--distance", 2, "--set", "track.window.slab_count=8", "--set", "track.rail.mode_count=80"]


@pytest.fixture(scope="module")
def reference(fmus, tmp_path_factory):
    path = tmp_path_factory.mktemp("reference") / "run.nc"
    fmus.invoke("run", *SHORT, "--out", path)
    return force_of(path)


def force_of(path):
    with xr.open_dataset(path, engine="h5netcdf") as data:
        return data.normal_force.to_numpy()


@pytest.fixture
def own(fmus, tmp_path):
    """Return the product with a cache of the test's own, a copy of the common one."""
    cache = tmp_path / "cache"
    shutil.copytree(fmus.cache, cache)
    return Product(fmus.folder, cache)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc takes no files")
def test_a_folder_that_takes_no_file_is_refused_before_the_run(fmus):
    before = os.times().children_user
    done = fmus.command("run", "--distance", 5000, "--out", "/proc/run.nc", status=(1,))
    assert "/proc/run.nc: cannot be written" in done.stderr
    assert os.times().children_user - before < 30.0  # the steps would take a minute and more


def damage(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize("what", [["built"], ["extracted", "arrays", "library"]])
def test_damaged_caches_are_made_anew_and_the_result_is_the_same(own, reference, tmp_path, what):
    names = {
        "built": "built/*/InfiniteSlabTrack.fmu",
        "extracted": "extracted/*/resources/*.py",
        "arrays": "arrays/*/*.npy",
        "library": "packages/*/rail_vehicle/native/*",
    }
    for name in what:
        files = list(own.cache.glob(names[name]))
        assert files
        for path in files:
            damage(path)
    own.command("run", *SHORT, "--out", tmp_path / "run.nc")
    assert (force_of(tmp_path / "run.nc") == reference).all()


@pytest.mark.slow
def test_two_processes_fill_one_empty_cache(fmus, reference, tmp_path):
    """Both build, extract and compile at the same time, and both results are right."""
    empty = Product(fmus.folder, tmp_path / "cache")
    files = [tmp_path / f"{number}.nc" for number in range(2)]
    runs = [empty.start("run", *SHORT, "--out", file) for file in files]
    assert [run.wait(PATIENCE) for run in runs] == [0, 0]
    for file in files:
        assert (force_of(file) == reference).all()


@pytest.mark.slow
def test_a_run_killed_while_it_builds_extracts_or_compiles_does_no_harm(fmus, reference, tmp_path):
    empty = Product(fmus.folder, tmp_path / "cache")
    for seconds in (1.0, 2.0, 3.0, 4.5, 6.0, 10.0, 20.0):
        run = empty.start("run", *SHORT, "--out", tmp_path / "killed.nc")
        time.sleep(seconds)
        run.kill()
        run.wait()
    file = tmp_path / "run.nc"
    empty.command("run", *SHORT, "--out", file)
    assert (force_of(file) == reference).all()


@pytest.mark.slow
def test_a_build_killed_at_any_time_leaves_whole_files_or_none(fmus, tmp_path):
    for tenths in range(2, 40, 3):
        folder = tmp_path / f"killed{tenths}"
        build = fmus.start("build", "--out", folder)
        time.sleep(0.1 * tenths)
        build.kill()
        build.wait()
        for path in folder.glob("*.fmu"):
            with zipfile.ZipFile(path) as archive:
                assert archive.testzip() is None
