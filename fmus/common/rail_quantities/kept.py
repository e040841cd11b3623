"""Arrays that take long to compute, kept in the user's cache from one process to the next."""

import contextlib
import functools
import hashlib
import io
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

_DIGEST_SIZE = 32
_MOST = 40
"""Files kept in a folder; the oldest go first."""


def kept_array(name: str, key: object, make: Callable[[], np.ndarray], code: Path) -> np.ndarray:
    """Return what ``make`` returns, from the cache if it was made before.

    Parameters
    ----------
    name
        Of the kind of array; a folder in the cache.
    key
        All that the array depends on; its ``repr`` counts, so it must be exact.
    make
        Computes the array.
    code
        Folder of the package whose code makes it: with other code, it is made anew.

    Notes
    -----
    A cache that cannot be read or written costs time only. A file is put in place
    by one rename, so no process reads half of it; behind the array it has the SHA-256
    of it, so that what was damaged since is made anew.
    """
    digest = hashlib.sha256(f"{_code_digest(code)}{key!r}".encode()).hexdigest()[:32]
    with contextlib.suppress(OSError, RuntimeError, ValueError, EOFError):
        return _read(_folder(name) / f"{digest}.npy")
    array = make()
    with contextlib.suppress(OSError, RuntimeError):
        _write(_folder(name), f"{digest}.npy", array)
    return array


def _folder(name: str) -> Path:
    """Return a folder of the per-user cache; ``RAIL_COSIM_CACHE`` overrides the place."""
    chosen = os.environ.get("RAIL_COSIM_CACHE")
    if chosen:
        return Path(chosen).expanduser() / "arrays" / name
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        return base / "rail-cosim" / "Cache" / "arrays" / name
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "rail-cosim" / "arrays" / name
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "rail-cosim" / "arrays" / name


@functools.cache
def _code_digest(folder: Path) -> str:
    total = hashlib.sha256(np.__version__.encode())
    for path in sorted(folder.rglob("*.py")):
        total.update(path.read_bytes())
    return total.hexdigest()


def _read(path: Path) -> np.ndarray:
    content = path.read_bytes()
    array, digest = content[:-_DIGEST_SIZE], content[-_DIGEST_SIZE:]
    if hashlib.sha256(array).digest() != digest:
        raise ValueError(f"{path} is damaged")
    return np.load(io.BytesIO(array), allow_pickle=False)


def _write(folder: Path, name: str, array: np.ndarray) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    old = sorted(folder.glob("*.npy"), key=lambda path: path.stat().st_mtime)
    for path in old[: max(0, len(old) - _MOST + 1)]:
        path.unlink(missing_ok=True)
    handle, part = tempfile.mkstemp(prefix=".new-", dir=folder)
    try:
        content = io.BytesIO()
        np.save(content, array, allow_pickle=False)
        with os.fdopen(handle, "wb") as file:
            file.write(content.getvalue() + hashlib.sha256(content.getvalue()).digest())
        os.replace(part, folder / name)
    except OSError:
        Path(part).unlink(missing_ok=True)
        raise
