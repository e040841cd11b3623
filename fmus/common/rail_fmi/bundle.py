"""Start-up of an FMU: import the packages it carries from a per-user cache.

The builder puts a copy of this file into each FMU under a name of its own, so
that every FMU runs its own copy, whatever else the process has loaded.
Standard library only.
"""

import hashlib
import importlib
import importlib.util
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

CACHE_VARIABLE = "RAIL_COSIM_CACHE"
HASH_ATTRIBUTE = "__source_hash__"
PYTHON = (3, 11)
"""The oldest version of Python that the packages work with."""

_kept: list[Any] = []


class BundleError(ImportError):
    """The packages of an FMU cannot be loaded.

    ``repr`` is the plain message with ``%`` doubled: pythonfmu hands it to
    the host's ``printf``-like logger.
    """

    def __repr__(self) -> str:
        text = str(self).encode("utf-8", "backslashreplace").decode("utf-8")
        return text.replace("%", "%%")


def source_files(folder: Path) -> list[Path]:
    """Return the files of a package that belong to it, sorted by their path inside."""
    files = [
        path
        for path in folder.rglob("*")
        if path.is_file()
        and path.suffix not in (".pyc", ".pyo")
        and not any(
            part == "__pycache__" or part.startswith(".") for part in path.relative_to(folder).parts
        )
    ]
    return sorted(files, key=lambda path: path.relative_to(folder).as_posix())


def source_hash(folder: Path) -> str:
    """Return the SHA-256 of names and contents of a package's files."""
    total = hashlib.sha256()
    for path in source_files(folder):
        contents = path.read_bytes()
        total.update(f"{path.relative_to(folder).as_posix()}\0{len(contents)}\0".encode())
        total.update(contents)
    return total.hexdigest()


def cache_folder() -> Path:
    """Return the per-user cache; the variable ``RAIL_COSIM_CACHE`` overrides it."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        return Path(chosen).expanduser()
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
        return Path(base) / "rail-cosim" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "rail-cosim"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "rail-cosim"


def prepare(namespace: dict[str, Any], packages: Mapping[str, str]) -> None:
    """Load the packages of an FMU; called at the top of its entry script.

    Parameters
    ----------
    namespace
        ``globals()`` of the entry script. pythonfmu 0.7 gives back one
        reference too many to it at every instantiation, which crashes the host
        sooner or later; the script runs at every instantiation, and one
        reference kept each time makes up for it.
    packages
        Hash by name of each package the FMU carries.

    Raises
    ------
    BundleError
        If Python is too old, the process has loaded another version of a package, or a
        library that the packages need is missing. ``fmi2Instantiate`` then fails, and
        the text is in the log and on stderr.
    """
    _kept.append(namespace)
    try:
        _check_python()
        for name in packages:
            if name in sys.modules:
                _compare(name, sys.modules[name], packages[name])
        _import_missing({name: h for name, h in packages.items() if name not in sys.modules})
    except BundleError as error:
        print(error, file=sys.stderr)
        raise


def _check_python() -> None:
    if sys.version_info[:2] < PYTHON:
        wanted, found = (".".join(map(str, v)) for v in (PYTHON, sys.version_info[:3]))
        raise BundleError(
            f"the FMU needs Python {wanted} or newer, and this host embeds Python {found} "
            f"({sys.prefix}). Remedy: start the host with a newer one (on Linux LD_PRELOAD its "
            "libpython and set PYTHONHOME, on Windows put its folder on the PATH)"
        )


def _compare(name: str, module: ModuleType, wanted: str) -> None:
    found = getattr(module, HASH_ATTRIBUTE, "")
    place = next(iter(getattr(module, "__path__", [])), "")
    if not found and place and Path(place).is_dir():
        found = source_hash(Path(place))
        setattr(module, HASH_ATTRIBUTE, found)
    if found != wanted:
        raise BundleError(
            f"package {name!r} is already loaded from {place or 'an unknown place'} in another "
            f"version ({found[:12] or 'unknown'}) than this FMU carries ({wanted[:12]}), and a "
            "process can hold only one. Remedy: rebuild the FMUs from the same sources, or run "
            "them in processes of their own."
        )


def _import_missing(packages: Mapping[str, str]) -> None:
    resources = Path(__file__).resolve().parent
    folders = [str(_cached(name, digest, resources)) for name, digest in packages.items()]
    sys.path[:0] = folders
    try:
        for name, digest in packages.items():
            setattr(importlib.import_module(name), HASH_ATTRIBUTE, digest)
    except BundleError:
        raise
    except ImportError as error:
        raise BundleError(
            f"the FMU needs a Python library that cannot be imported: {error}. Remedy: "
            f"{sys.executable} -m pip install -r {resources / 'requirements.txt'}"
        ) from error
    finally:
        for folder in folders:
            sys.path.remove(folder)


def _cached(name: str, digest: str, resources: Path) -> Path:
    """Return the folder to import ``name`` from: the cache, or ``resources`` if it must be."""
    bundled = resources / name
    try:
        shelf = cache_folder() / "packages"
        folder = shelf / f"{name}-{digest[:20]}"
        if _is_good(folder / name, digest):
            return folder
        if source_hash(bundled) != digest:
            raise BundleError(f"the FMU is damaged: {bundled} is not what was packed. Extract anew")
        shelf.mkdir(parents=True, exist_ok=True)
        _publish(bundled, folder)
        return folder if _is_good(folder / name, digest) else resources
    except (OSError, RuntimeError):  # no home, read-only, full, or locked by another process
        return resources


def _is_good(folder: Path, digest: str) -> bool:
    return folder.is_dir() and source_hash(folder) == digest


def _publish(bundled: Path, folder: Path) -> None:
    """Put a copy in place by one rename, so that no process sees half of it."""
    with tempfile.TemporaryDirectory(
        prefix=".new-", dir=folder.parent, ignore_cleanup_errors=True
    ) as workshop:
        fresh = Path(workshop) / "fresh"
        _copy(bundled, fresh / bundled.name)
        for _ in range(3):
            try:
                fresh.rename(folder)
                return
            except OSError:
                _set_aside(folder, Path(workshop))


def _copy(package: Path, target: Path) -> None:
    """Copy a package's files, but not their permissions."""
    for path in source_files(package):
        file = target / path.relative_to(package)
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, file)


def _set_aside(folder: Path, workshop: Path) -> None:
    """Move a damaged entry out of the way; a good one of another process stays."""
    digest = source_hash(workshop / "fresh" / folder.name.rpartition("-")[0])
    if _is_good(folder / folder.name.rpartition("-")[0], digest):
        return
    folder.rename(Path(tempfile.mkdtemp(prefix="old-", dir=workshop)) / "entry")
