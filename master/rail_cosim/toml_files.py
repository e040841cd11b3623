"""What run files and sweep specifications have in common: TOML, dotted names, paths."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeGuard

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.slave import Value

TABLE = "[...]"
"""How a table is shown in a message."""
_RANGE = {"start", "stop", "step"}


def read_toml(path: Path, option: str, sections: Iterable[str]) -> dict[str, Any]:
    """Return the content of a TOML file of these sections.

    Parameters
    ----------
    path
        The file.
    option
        What it was given as, for messages.
    sections
        The tables that it may have.

    Raises
    ------
    ParameterError
        If it cannot be read, or has anything else.
    """
    try:
        with path.open("rb") as file:
            content = tomllib.load(file)
    except OSError as error:
        raise ParameterError(option, str(path), f"cannot be read ({error.strerror})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ParameterError(option, str(path), f"is no TOML file ({error})") from error
    known = tuple(sections)
    for name, value in content.items():
        if name not in known:
            shown = TABLE if isinstance(value, Mapping | list) else value
            raise UnknownNameError(name, shown, known, "section", listed=True)
        if not isinstance(value, Mapping) and name != "points":
            raise ParameterError(name, value, "must be a section", f"write [{name}] and below it")
    return content


def _is_table(value: object) -> TypeGuard[Mapping[str, Any]]:
    return isinstance(value, Mapping)


def flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Return the entries with dotted names; a table that is a range is one entry."""
    entries: list[tuple[str, Any]] = []
    for name, value in table.items():
        if _is_table(value) and set(value) != _RANGE:
            entries += flat(value, f"{prefix}{name}.")
        else:
            entries.append((prefix + name, value))
    return entries


def assignments(settings: Mapping[str, Value]) -> list[str]:
    """Return the texts ``NAME=VALUE`` that stand for these values after ``--set``."""
    return [
        f"{name}={str(value).lower() if isinstance(value, bool) else value}"
        for name, value in settings.items()
    ]


def looks_like_a_path(text: str) -> bool:
    """Say whether a text is rather a path than a name: it has a folder or an ending."""
    return "/" in text or "\\" in text or Path(text).suffix != ""


def located(value: Any, folder: Path | None) -> Any:
    """Return a relative path seen from ``folder``; names and other values as they are."""
    if folder is None or not isinstance(value, str) or not looks_like_a_path(value):
        return value
    return str(folder / Path(value).expanduser())


def located_settings(settings: Mapping[str, Value], folder: Path | None) -> dict[str, Value]:
    """Return parameter values in which texts that are files in ``folder`` are full paths."""
    found = dict(settings)
    for name, value in settings.items():
        path = located(value, folder)
        if path != value and Path(path).is_file():
            found[name] = str(Path(path).resolve())
    return found
