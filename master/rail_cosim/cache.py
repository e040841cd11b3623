"""The per-user directory for extracted and built FMUs."""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

import platformdirs

from rail_cosim.errors import RailCosimError

VARIABLE = "RAIL_COSIM_CACHE"


def cache_directory() -> Path:
    """Return the cache directory: ``RAIL_COSIM_CACHE``, or the user's own, and create it.

    Raises
    ------
    RailCosimError
        If it cannot be created.
    """
    given = os.environ.get(VARIABLE)
    path = Path(given).expanduser() if given else platformdirs.user_cache_path("rail-cosim")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RailCosimError(
            f"the cache directory {path} cannot be created ({error.strerror}); "
            f"set {VARIABLE} to a directory you can write to"
        ) from error
    return path.resolve()


def plain_directory() -> Path:
    """Return a cache directory whose address needs no percent-encoding.

    FMUs get the address of their resources as a URI, and some (all made with
    pythonfmu) crash on a percent sign in it. If the user's cache directory has
    such a path, a directory of the user's own below the temporary one is taken.

    Raises
    ------
    RailCosimError
        If neither will do.
    """
    cache = cache_directory()
    if is_plain(cache):
        return cache
    user = hashlib.sha256(str(cache).encode()).hexdigest()[:12]
    fallback = Path(tempfile.gettempdir()).resolve() / f"rail-cosim-{user}"
    if is_plain(fallback):
        fallback.mkdir(mode=0o700, exist_ok=True)
        if not hasattr(os, "getuid") or fallback.stat().st_uid == os.getuid():
            return fallback
    raise RailCosimError(
        f"the cache directory {cache} has letters outside plain ASCII in its path, on which "
        f"FMUs crash; set {VARIABLE} to a directory with a plain path"
    )


def is_plain(path: Path) -> bool:
    """Whether the path is the same as text and as a URI."""
    return path.is_absolute() and "%" not in path.as_uri() and " " not in str(path)
