"""Values for parameters: read from text, checked against the slave's description."""

from __future__ import annotations

import math
from collections.abc import Mapping

from rail_cosim.errors import ParameterError, UnknownNameError, nearest
from rail_cosim.slave import Value, Variable

SETTABLE = ("parameter", "input")
_TRUE, _FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def checked(
    owner: str, variables: Mapping[str, Variable], values: Mapping[str, object]
) -> dict[str, Value]:
    """Return ``values`` with each value in the type its variable has.

    Parameters
    ----------
    owner
        The slave's name; messages name ``owner.name``.
    variables
        The slave's variables.
    values
        Numbers, truth values or text (text is converted), by name.

    Raises
    ------
    UnknownNameError
        For a name the slave does not have; gives the nearest one.
    ParameterError
        For a value of the wrong type or out of its limits, or a variable that cannot be set.
    """
    result: dict[str, Value] = {}
    for name, value in values.items():
        full = f"{owner}.{name}"
        if name not in variables:
            known = (f"{owner}.{v.name}" for v in variables.values() if v.causality in SETTABLE)
            raise UnknownNameError(full, value, known, "parameter")
        variable = variables[name]
        if variable.causality not in SETTABLE:
            raise ParameterError(
                full, value, f"this is {_article(variable.causality)}", "only parameters can be set"
            )
        result[name] = _convert(full, variable, value)
    return result


def number_of(name: str, values: Mapping[str, Value], variables: Mapping[str, Variable]) -> float:
    """Return a number as it is set, else its start value; 0 for a variable that does not exist."""
    start = variables[name].start if name in variables else None
    return float(values.get(name, start or 0.0))


def _article(causality: str) -> str:
    words = {"calculatedParameter": "a calculated parameter", "local": "a local variable"}
    return words.get(causality, f"an {causality}")


def _convert(full: str, variable: Variable, value: object) -> Value:
    if variable.kind == "string":
        return _text(full, variable, value)
    if variable.kind == "boolean":
        return _truth(full, value)
    if variable.kind == "enumeration":
        return _choice(full, variable, value)
    return _number(full, variable, value)


def _text(full: str, variable: Variable, value: object) -> str:
    word = str(value)
    if "\0" in word:  # it would end the text on its way through C
        raise ParameterError(full, word, "must be text without the character NUL")
    if variable.choices and word not in variable.choices:
        close = nearest(word, variable.choices, 1)
        remedy = f"did you mean {close[0]}?" if close else ""
        raise ParameterError(full, word, "must be one of " + ", ".join(variable.choices), remedy)
    return word


def _truth(full: str, value: object) -> bool:
    word = str(value).strip().lower()
    if word not in _TRUE + _FALSE:
        raise ParameterError(full, value, "must be true or false")
    return word in _TRUE


def _choice(full: str, variable: Variable, value: object) -> int:
    if value in variable.choices.values():
        return int(value)  # type: ignore[call-overload]
    if value not in variable.choices:
        raise ParameterError(full, value, "must be one of " + ", ".join(variable.choices))
    return variable.choices[str(value)]


def _number(full: str, variable: Variable, value: object) -> float | int:
    meaning = f"meaning: {variable.description}".rstrip(".") if variable.description else ""
    unit = f" {variable.unit}" if variable.unit not in ("", "1") else ""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if isinstance(value, bool) or not math.isfinite(number):
        raise ParameterError(full, value, "must be a finite number" + _in(unit), meaning)
    if variable.kind == "integer" and number != int(number):
        raise ParameterError(full, value, "must be a whole number", meaning)
    if variable.kind == "integer" and not -(2**31) <= number < 2**31:
        raise ParameterError(full, value, "must be a whole number of 32 bits", meaning)
    low, high = variable.minimum, variable.maximum
    if (low is not None and number < low) or (high is not None and number > high):
        pairs = (("at least", low), ("at most", high))
        limits = " and ".join(f"{word} {limit:g}" for word, limit in pairs if limit is not None)
        raise ParameterError(full, value, f"must be {limits}{unit}", meaning)
    return int(number) if variable.kind == "integer" else number


def _in(unit: str) -> str:
    return f" in{unit}" if unit else ""


def parse_assignments(
    texts: list[str], owners: Mapping[str, Mapping[str, Variable]]
) -> dict[str, dict[str, str]]:
    """Return ``{owner: {name: text}}`` from texts ``owner.name=value``.

    Raises
    ------
    ParameterError
        If a text has no ``=``, or does not begin with an owner's name.
    """
    result: dict[str, dict[str, str]] = {owner: {} for owner in owners}
    form = " or ".join(f"{owner}.NAME=VALUE" for owner in owners)
    for text in texts:
        left, equals, value = text.partition("=")
        owner, dot, name = left.strip().partition(".")
        if not equals:
            raise ParameterError("--set", text, "there is no value", f"write {form}")
        if owner not in owners or not dot:
            having = [f"{o}.{left}" for o, variables in owners.items() if left in variables]
            known = having or (f"{o}.{n}" for o, variables in owners.items() for n in variables)
            limit = "must begin with the FMU it is for"
            if having:
                raise ParameterError(left, value, limit, "write " + " or ".join(having))
            raise UnknownNameError(left.strip(), value, known, f"parameter (write {form})")
        result[owner][name] = value.strip()
    return result
