"""FMUs are programs: which were built here, and what is said before another one runs."""

from __future__ import annotations

from pathlib import Path

from rail_cosim.archives import opened
from rail_cosim.builder import RECIPES
from rail_cosim.cache import cache_directory

_SHOWN = 3


def is_own(path: Path) -> bool:
    """Whether an FMU is byte for byte one that this user's ``rail-cosim`` has built."""
    try:
        content = path.read_bytes()
        built = cache_directory() / "built"
        return any(
            other.stat().st_size == len(content) and other.read_bytes() == content
            for recipe in RECIPES.values()
            for other in built.glob(f"*/{recipe.model}.fmu")
        )
    except OSError:
        return False


def foreign_remark(path: Path) -> str:
    """Return a line for the user before an FMU runs; empty for one of our own.

    Raises
    ------
    FmuFileError
        If it is no FMU, or must not be unpacked.
    """
    if is_own(path):
        return ""
    with opened(path) as archive:
        names = archive.namelist()
    libraries = [n for n in names if n.startswith("binaries/") and n[-1] != "/"]
    scripts = [n for n in names if n.endswith(".py")]
    what = ", ".join(libraries[:_SHOWN]) + (" and more" if len(libraries) > _SHOWN else "")
    if scripts:
        what += f", {len(scripts)} Python files" if len(scripts) > 1 else f", {scripts[0]}"
    return (
        f"{path} was not built here. It is a program ({what}) and now runs with all your rights; "
        "with --trust this is not said"
    )
