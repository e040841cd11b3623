"""Fixtures for tests of the whole product."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from product import Product, build
from rail_fmi.bundle import source_hash

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "fmus/common/rail_fmi",
    "fmus/common/rail_native",
    "fmus/common/rail_quantities",
    "fmus/track/slab_track",
    "fmus/vehicle/rail_vehicle",
)


def pytest_configure(config):
    """Give all tests one cache of the product, and nothing of the user's.

    It stays in pytest's own cache directory: it is keyed by the sources' hashes, and keeps
    what was built and compiled for the next session.
    """
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "100"}
    for name in ("FORCE_COLOR", "NO_COLOR", "GITHUB_ACTIONS"):  # change what is printed
        os.environ.pop(name, None)
    kept = getattr(config, "cache", None)
    if kept is None:
        return
    cache = kept.mkdir("rail-cosim")
    os.environ["RAIL_COSIM_CACHE"] = str(cache)
    os.environ["MPLCONFIGDIR"] = str(kept.mkdir("matplotlib"))  # a list of fonts, made once
    _share_sources(cache)
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        _compile(cache)


def _share_sources(cache: Path) -> None:
    """Have the FMUs import the sources that the tests import, so that nothing is copied.

    An FMU looks for its packages in the cache by their hash; a link there is as good as the copy
    that it would make. `tests/component` and `tests/system/test_faults.py` have it make copies.
    """
    for package in map(ROOT.joinpath, PACKAGES):
        folder = cache / "packages" / f"{package.name}-{source_hash(package)[:20]}"
        if not folder.exists():
            folder.mkdir(parents=True)
            with contextlib.suppress(OSError):  # Windows: not without the right to
                (folder / package.name).symlink_to(package, target_is_directory=True)


def _compile(cache: Path) -> None:
    """Compile what most tests need before the workers start, who would each do the same."""
    environment = Product(cache, cache).environment()
    started = [
        subprocess.Popen([sys.executable, "-c", f"import warm; warm.{name}()"], env=environment)
        for name in ("product", "references")
    ]
    for process in started:
        process.wait()


@pytest.fixture(scope="session")
def fmus(tmp_path_factory) -> Product:
    """Both FMUs, built once."""
    cache = os.environ.get("RAIL_COSIM_CACHE") or tmp_path_factory.mktemp("cache")
    return build(tmp_path_factory.mktemp("fmus"), Path(cache))
