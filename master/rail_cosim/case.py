"""Run files: the options of one co-simulation in TOML.

    [run]                # the options of `rail-cosim run`, by the same names
    speed = 170
    distance = 200
    out = "winter.nc"    # paths are relative to the file

    [set]                # parameters, as after --set
    track.fastener.vertical_stiffness = 140e6

``[run]`` and ``[set]`` mean the same in a sweep's specification.
"""

from __future__ import annotations

import dataclasses
import json
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.options import RunOptions
from rail_cosim.results import check_writable
from rail_cosim.slave import Value
from rail_cosim.toml_files import TABLE, flat, located, located_settings, read_toml

ENDING = ".toml"
_SECTIONS = ("run", "set")
_NUMBER = re.compile(r"[+-]?\d+(\.\d+)?(e[+-]?\d+)?")
_OTHERS = ("settings", "command", "resume", "trust")  # fields of RunOptions not for a file


def option_names() -> list[str]:
    """Return the names that ``[run]`` of a run file may have."""
    return [f.name for f in dataclasses.fields(RunOptions) if f.name not in _OTHERS]


def read_case(path: str | Path) -> dict[str, Any]:
    """Return what a run file says, as keyword arguments of :func:`rail_cosim.run`.

    Parameters
    ----------
    path
        A TOML file with the sections ``[run]`` (options) and ``[set]`` (parameters).

    Returns
    -------
    dict
        Options by name, only those that the file has, in the units of :func:`rail_cosim.run`;
        ``settings`` has the parameters by full name. Relative paths are relative to the file.

    Raises
    ------
    ParameterError
        If the file cannot be read, or a name in it is unknown.

    Examples
    --------
    >>> data = rail_cosim.run(**read_case("winter.toml") | {"speed": 180})  # doctest: +SKIP
    """
    path = Path(path)
    content = _content(path)
    folder = path.absolute().parent
    given: dict[str, Any] = {}
    known = option_names()
    for typed, value in content.get("run", {}).items():
        name = typed.replace("-", "_")
        if name not in known:
            raise UnknownNameError(f"run.{typed}", value, known, "option", name)
        given[name] = _placed(name, value, folder)
    if given.get("until_steady") is False:  # as in a sweep: the whole way
        given["until_steady"] = None
    settings = dict(flat(content.get("set", {})))
    for name in settings:
        if not name.startswith(("track.", "vehicle.")):
            limit = "must begin with the FMU it is for"
            remedy = f"write track.{name} or vehicle.{name}"
            raise ParameterError(f"set.{name}", settings[name], limit, remedy)
    given["settings"] = located_settings(settings, folder)
    return given


def _content(path: Path) -> dict[str, Any]:
    try:
        return read_toml(path, "CASE", _SECTIONS)
    except UnknownNameError as error:
        if error.value == TABLE and error.name in ("track", "vehicle"):
            limit, remedy = "is no section", f"write {error.name}.NAME = VALUE below [set]"
        elif error.name.replace("-", "_") in option_names():
            limit, remedy = "is an option of a run", "write it below [run]"
        else:
            raise
        raise ParameterError(error.name, error.value, limit, remedy) from error


def _placed(name: str, value: Any, folder: Path) -> Any:
    """Return an option of which a path is relative to ``folder``."""
    if name in _paths() and isinstance(value, str):
        return folder / Path(value).expanduser()
    return located(value, folder)


def _paths() -> list[str]:
    return [f.name for f in dataclasses.fields(RunOptions) if "Path" in str(f.type)]


def write_case(path: Path, options: RunOptions) -> None:
    """Write a run file that says what these options say.

    Options that have their default are there too, behind ``#``.

    Raises
    ------
    ResultsError
        If it cannot be written.
    """
    lines = ["# rail-cosim run " + path.name, "", "[run]"]
    for field in dataclasses.fields(RunOptions):
        if field.name in _OTHERS:
            continue
        value = getattr(options, field.name)
        if isinstance(value, Path):
            value = _seen_from(path, value)
        elif isinstance(value, str) and Path(value).is_file():  # a vehicle, an irregularity
            value = _seen_from(path, Path(value))
        if value == field.default or value == []:
            shown = "..." if value is None else _toml(value)
            lines.append(f"# {field.name} = {shown}")
        else:
            lines.append(f"{field.name} = {_toml(value)}")
    lines += ["", "[set]"]
    pairs = (text.partition("=") for text in options.settings)
    settings = {name.strip(): value.strip() for name, _, value in pairs}
    lines += [f"{_key(name)} = {_value(value)}" for name, value in settings.items()]
    check_writable(path)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _seen_from(file: Path, path: Path) -> str:
    """Return ``path`` relative to the folder of ``file`` if it is in there, else in full."""
    folder, path = file.absolute().parent, path.expanduser().absolute()
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else str(path)


def _value(text: str) -> str:
    """Return a text from after ``--set`` as TOML: a number as typed, a truth value, or text.

    With a capital E it is rather a name (the rail profile 60E1).
    """
    if text in ("true", "false") or (_NUMBER.fullmatch(text) and _is_toml(text)):
        return text
    return _toml(text)


def _is_toml(text: str) -> bool:
    try:
        tomllib.loads(f"x = {text}")
    except tomllib.TOMLDecodeError:  # 007, 1.
        return False
    return True


def _key(name: str) -> str:
    return name if re.fullmatch(r"[\w.-]+", name, re.ASCII) else _toml(name)


def _toml(value: Value | Sequence[str]) -> str:
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)
