"""Fixtures for tests of the whole product."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from product import Product, build


def pytest_configure(config):
    """Give all tests one cache of the product, and nothing of the user's.

    It stays in pytest's own cache directory: it is keyed by the sources' hashes, and keeps
    what was built for the next session.
    """
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "100"}
    for name in ("FORCE_COLOR", "NO_COLOR", "GITHUB_ACTIONS"):  # change what is printed
        os.environ.pop(name, None)
    kept = getattr(config, "cache", None)
    if kept is None:
        return
    os.environ["RAIL_COSIM_CACHE"] = str(kept.mkdir("rail-cosim"))
    os.environ["MPLCONFIGDIR"] = str(kept.mkdir("matplotlib"))  # a list of fonts, made once
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        _compile_references()


def _compile_references() -> None:
    """Compile the finite elements before the workers start, who would each do the same."""
    program = (
        "from reference_fe import ReferenceTrack, ReferenceVehicle, SingleWheel, simulate\n"
        "for vehicle in (SingleWheel(), ReferenceVehicle()):\n"
        "    simulate(ReferenceTrack(), vehicle, 80.0, 1.0, step=1e-4)\n"
    )
    paths = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run([sys.executable, "-c", program], env=os.environ | paths, check=False)


@pytest.fixture(scope="session")
def fmus(tmp_path_factory) -> Product:
    """Both FMUs, built once."""
    cache = os.environ.get("RAIL_COSIM_CACHE") or tmp_path_factory.mktemp("cache")
    return build(tmp_path_factory.mktemp("fmus"), Path(cache))
