"""Faults around a run: a folder that takes no file, damaged caches."""

import shutil
import sys
import time

import pytest
import xarray as xr
from product import Product

SHORT = ["--distance", 2, "--set", "track.window.slab_count=8", "--set", "track.rail.mode_count=80"]


@pytest.fixture(scope="module")
def reference(fmus, tmp_path_factory):
    path = tmp_path_factory.mktemp("reference") / "run.nc"
    fmus.command("run", *SHORT, "--out", path)
    return force_of(path)


def force_of(path):
    with xr.open_dataset(path, engine="h5netcdf") as data:
        return data.normal_force.to_numpy()


@pytest.fixture
def own(fmus, tmp_path):
    """Return the product with a cache of the test's own, a copy of the common one."""
    cache = tmp_path / "cache"
    shutil.copytree(fmus.cache, cache, symlinks=True)
    return Product(fmus.folder, cache)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc takes no files")
def test_a_folder_that_takes_no_file_is_refused_before_the_run(fmus):
    started = time.monotonic()
    done = fmus.command("run", "--distance", 5000, "--out", "/proc/run.nc", status=(1,))
    assert "/proc/run.nc: cannot be written" in done.stderr
    assert time.monotonic() - started < 60.0


def damage(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize("what", ["built", "extracted", "arrays"])
def test_damaged_caches_are_made_anew_and_the_result_is_the_same(own, reference, tmp_path, what):
    names = {
        "built": "built/*/InfiniteSlabTrack.fmu",
        "extracted": "extracted/*/resources/*.py",
        "arrays": "arrays/*/*.npy",
    }
    files = list(own.cache.glob(names[what]))
    assert files
    for path in files:
        damage(path)
    own.command("run", *SHORT, "--out", tmp_path / "run.nc")
    assert (force_of(tmp_path / "run.nc") == reference).all()
