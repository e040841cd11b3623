"""Use an FMU whose variables have other names, signs or units than the contract.

    [names]                                      # name of the contract = variable of the FMU
    static_wheel_load = "Q0"
    "wheelset[{i}].lateral_displacement" = "ws{i}_y"
    "wheelset[{i}].vertical_displacement" = { name = "ws{i}_z_up_mm", factor = -1e-3 }

A value of the contract is ``factor`` times that of the FMU, plus ``offset``; with either of them it
has the contract's unit, whatever the FMU declares. ``{i}`` stands for the numbers 1 to 4 of which
the FMU has the variable. What the map does not name keeps its own name.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rail_cosim.contract import WHEELSET_LIMIT, known_units
from rail_cosim.description import FmuDescription, read_description
from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.slave import Renaming, Value, Variable
from rail_cosim.toml_files import read_toml

_NUMBER = "{i}"
_KEYS = ("name", "factor", "offset")


def described(path: Path, names: Path | None = None) -> FmuDescription:
    """Return the description of an FMU with the names of the contract.

    Parameters
    ----------
    path
        The FMU.
    names
        Its name map, ``None`` if it has the contract's names.

    Raises
    ------
    FmuFileError
        If the FMU cannot be read.
    ParameterError
        If the map cannot be read, or names what is not there, on either side.
    """
    description = read_description(path)
    if names is None:
        return description
    return renamed(description, _chosen(read_name_map(names), description))


def read_name_map(path: Path) -> list[Renaming]:
    """Return what a name map says, with ``{i}`` where it is written.

    Raises
    ------
    ParameterError
        If it cannot be read, or has anything else.
    """
    content = read_toml(path, "--map", ("names",))
    return [_renaming(name, given) for name, given in _flat(content.get("names", {}))]


def renamed(description: FmuDescription, renamings: Sequence[Renaming]) -> FmuDescription:
    """Return the description with these variables under the names of the contract.

    Raises
    ------
    ParameterError
        If a name is not there on either side, or is used twice.
    """
    by_own: dict[str, Renaming] = {}
    units, taken = known_units(), dict[str, str]()
    for renaming in renamings:
        name, own = renaming.name, renaming.own
        if name not in units:
            raise UnknownNameError(name, own, units, "variable in the contract")
        if own not in description.variables:
            what = f"variable in {description.path.name}"
            raise UnknownNameError(name, own, description.variables, what, own)
        if own in by_own:
            limit = f"this variable is already {by_own[own].name}"
            raise ParameterError(name, own, limit, "map each variable once")
        if name in taken:
            raise ParameterError(name, own, f"it is already {taken[name]}", "map each name once")
        by_own[own], taken[name] = renaming, own
    found: dict[str, Variable] = {}
    for variable in description.variables.values():
        new = variable
        if variable.name in by_own:
            new = _as(by_own[variable.name], variable, units)
        if new.name in found:
            limit = f"{description.path.name} has another variable of this name of its own"
            raise ParameterError(new.name, variable.name, limit, "map that one, too")
        found[new.name] = new
    return dataclasses.replace(description, variables=found)


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted names; ``wheelset.radius`` without quotes is a table in a table."""
    for name, value in table.items():
        if isinstance(value, Mapping) and not set(value) & set(_KEYS):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _renaming(name: str, given: Any) -> Renaming:
    if isinstance(given, str):
        return Renaming(name=name, own=given)
    if not isinstance(given, Mapping) or not isinstance(given.get("name"), str):
        limit = "must be the name of a variable of the FMU"
        raise ParameterError(name, given, limit, 'write "NAME" or { name = "NAME", factor = -1 }')
    for key, value in given.items():
        if key not in _KEYS:
            raise UnknownNameError(f"{name}.{key}", value, _KEYS, "entry", key, listed=True)
    numbers = {key: _number(f"{name}.{key}", given[key]) for key in _KEYS[1:] if key in given}
    if numbers.get("factor") == 0.0:
        raise ParameterError(f"{name}.factor", 0, "must not be 0", "give the conversion of units")
    return Renaming(name=name, own=given["name"], converted=bool(numbers), **numbers)


def _number(name: str, value: Any) -> float:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value):
        raise ParameterError(name, value, "must be a finite number")
    return float(value)


def _chosen(renamings: Sequence[Renaming], description: FmuDescription) -> list[Renaming]:
    """Return the renamings with numbers for ``{i}``, those of which the FMU has the variable."""
    chosen: list[Renaming] = []
    for renaming in renamings:
        if (_NUMBER in renaming.name) != (_NUMBER in renaming.own):
            limit = f"{_NUMBER} must be on both sides"
            raise ParameterError(renaming.name, renaming.own, limit)
        if _NUMBER not in renaming.name:
            chosen.append(renaming)
            continue
        each = [_numbered(renaming, i) for i in range(1, WHEELSET_LIMIT + 1)]
        there = [one for one in each if one.own in description.variables]
        chosen += there or each[:1]  # none: the first is refused
    return chosen


def _numbered(renaming: Renaming, number: int) -> Renaming:
    name, own = (text.replace(_NUMBER, str(number)) for text in (renaming.name, renaming.own))
    return dataclasses.replace(renaming, name=name, own=own)


def _as(renaming: Renaming, variable: Variable, units: Mapping[str, str]) -> Variable:
    """Return a variable as the contract sees it."""
    if renaming.converted and variable.kind != "real":
        limit = f"is {variable.kind}; only real variables have factor and offset"
        raise ParameterError(renaming.name, variable.name, limit)
    low, high = variable.minimum, variable.maximum
    if renaming.factor < 0.0:
        low, high = high, low

    def converted(value: Value | None) -> Any:
        return renaming.to_contract(value) if value is not None and renaming.scales else value

    return dataclasses.replace(
        variable,
        name=renaming.name,
        unit=units[renaming.name] if renaming.converted else variable.unit,
        start=converted(variable.start),
        minimum=converted(low),
        maximum=converted(high),
        renaming=renaming,
    )
