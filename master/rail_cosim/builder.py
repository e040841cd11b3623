"""Build the project's two FMUs, and find them again as long as their sources are unchanged."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
import zlib
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from rail_cosim.at_rest import values_at_rest
from rail_cosim.cache import cache_directory
from rail_cosim.errors import BuildError
from rail_cosim.osp import OSP_NAME, write_osp
from rail_cosim.presets import read_preset
from rail_cosim.ssp import write_ssp

SSP_NAME = "VehicleOnSlabTrack.ssp"
# Built in a process of its own: building imports the slave's packages, and
# once imported here they would stand in for those inside any other FMU.
_WORKER = """
import sys
from pathlib import Path
from rail_fmi.builder import build_fmu
build_fmu(Path(sys.argv[1]), packages=sys.argv[3:], out_dir=Path(sys.argv[2]))
"""


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Recipe:
    """What an FMU is built from: names of an entry module and of packages, found when needed."""

    model: str
    entry: str
    packages: tuple[str, ...]


VEHICLE = Recipe(
    model="HighSpeedVehicle",
    entry="vehicle_fmu",
    packages=("rail_quantities", "rail_fmi", "rail_native", "rail_vehicle"),
)
TRACK = Recipe(
    model="InfiniteSlabTrack",
    entry="track_fmu",
    packages=("rail_quantities", "rail_fmi", "rail_native", "slab_track"),
)
RECIPES = {"vehicle": VEHICLE, "track": TRACK}


def _origin(name: str) -> Path:
    """Return the file of a module, without importing it."""
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        raise BuildError(
            f"the module {name} is not installed, so its FMU cannot be built; install rail-cosim "
            "whole, or give ready FMUs with --vehicle and --track"
        )
    return Path(spec.origin)


def source_hash(recipe: Recipe) -> str:
    """Return a hash of all that goes into an FMU: its sources and the versions of the tools.

    Raises
    ------
    BuildError
        If a module of the recipe is not installed.
    """
    digest = hashlib.sha256(f"python {sys.version}\n".encode())
    digest.update(f"pythonfmu {metadata.version('pythonfmu')}\n".encode())
    files = {f"{recipe.entry}.py": _origin(recipe.entry)}
    for package in recipe.packages:
        root = _origin(package).parent
        for path in root.rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                files[f"{package}/{path.relative_to(root).as_posix()}"] = path
    for name in sorted(files):
        content = files[name].read_bytes()
        digest.update(f"{name} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()


def build_one(recipe: Recipe, directory: Path) -> Path:
    """Build one FMU into ``directory`` and return its path.

    Raises
    ------
    BuildError
        With what the builder said, if it fails.
    """
    entry = _origin(recipe.entry)
    directory.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-c", _WORKER, str(entry), str(directory), *recipe.packages]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=child_environment()
    )
    path = directory / f"{recipe.model}.fmu"
    if done.returncode != 0 or not path.is_file():
        lines = (done.stderr.strip() or done.stdout.strip()).splitlines()
        reason = lines[-1] if lines else f"no {path.name} was made"
        raise BuildError(f"{recipe.model}.fmu could not be built: {reason}")
    return path


def child_environment() -> dict[str, str]:
    """Return an environment in which a new process finds the modules that this one finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def built_fmu(recipe: Recipe) -> Path:
    """Return the FMU from the cache, building it if its sources have changed.

    Raises
    ------
    BuildError
        If it has to be built and cannot be.
    """
    target = cache_directory() / "built" / source_hash(recipe)[:16] / f"{recipe.model}.fmu"
    if _is_whole(target):
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    scratch = Path(tempfile.mkdtemp(prefix=".building-", dir=target.parent))
    try:
        os.replace(build_one(recipe, scratch), target)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return target


def _is_whole(fmu: Path) -> bool:
    """Whether a file is a complete archive: each member has its checksum."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            return archive.testzip() is None
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError):
        return False


def build(
    out: Path, *, line: str = "HD", vehicle: str = "paper", at_rest: bool = False
) -> list[Path]:
    """Build both FMUs and the system descriptions (SSP and OSP); return the four files.

    Parameters
    ----------
    out
        Directory, made if it is not there.
    line, vehicle
        Parameter sets that the system descriptions use.
    at_rest
        Whether to find the static equilibrium of the pair and to put it into the
        system descriptions, for tools that pass nothing on before the start.

    Raises
    ------
    BuildError
        If an FMU cannot be built.
    UnknownNameError
        If there is no such parameter set.
    """
    built = {name: built_fmu(recipe) for name, recipe in RECIPES.items()}
    presets = {"track": line, "vehicle": vehicle}
    for name, option in (("track", "--line"), ("vehicle", "--vehicle")):
        read_preset(built[name], presets[name], option)
    out.mkdir(parents=True, exist_ok=True)
    fmus = {name: out / path.name for name, path in built.items()}
    for name, path in built.items():
        shutil.copyfile(path, fmus[name])
    start = values_at_rest(fmus, presets) if at_rest else {}
    ssp, osp = out / SSP_NAME, out / OSP_NAME
    write_ssp(ssp, fmus, presets, start)
    write_osp(osp, fmus, presets, start)
    return [*fmus.values(), ssp, osp]
