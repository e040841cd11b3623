"""Sets of parameters: checked when made, flattened to dotted names and back."""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Self, TypeVar

from rail_quantities.errors import UnknownParameterError
from rail_quantities.quantity import Quantity, quantity_of

T = TypeVar("T", bound="ParameterSet")


@dataclasses.dataclass(frozen=True, kw_only=True)
class ParameterSet:
    """Base of all parameter sets.

    Subclasses are ``@dataclass(frozen=True, kw_only=True)``; fields are made
    with :func:`rail_quantities.quantity` or are parameter sets themselves.
    ``GROUP`` is the first part of the dotted names, for error messages.
    Override :meth:`check` for rules between several values.
    """

    GROUP: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            about = quantity_of(field)
            if about is not None:
                name = f"{self.GROUP}.{field.name}" if self.GROUP else field.name
                value = about.check(name, getattr(self, field.name), type(field.default))
                object.__setattr__(self, field.name, value)
        self.check()

    def check(self) -> None:
        """Raise :class:`rail_quantities.ParameterError` if values contradict each other."""

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some fields changed (and all checks made again)."""
        return dataclasses.replace(self, **changes)


def _walk(parameters: ParameterSet, prefix: str) -> Iterator[tuple[str, Quantity, Any]]:
    for field in dataclasses.fields(parameters):
        value = getattr(parameters, field.name)
        about = quantity_of(field)
        if about is not None:
            yield prefix + field.name, about, value
        elif isinstance(value, ParameterSet):
            yield from _walk(value, f"{prefix}{field.name}.")


def flatten(parameters: ParameterSet) -> dict[str, tuple[Quantity, Any]]:
    """Return ``{dotted name: (description, value)}`` in order of declaration."""
    return {name: (about, value) for name, about, value in _walk(parameters, "")}


def with_values(parameters: T, values: Mapping[str, Any]) -> T:
    """Return a copy of ``parameters`` with the dotted names in ``values`` changed.

    Raises
    ------
    UnknownParameterError
        For a name that does not exist; the message gives the nearest one.
    ParameterError
        For a value out of its limits.
    """
    known = flatten(parameters)
    for name, value in values.items():
        if name not in known:
            raise UnknownParameterError(name, value, known)
    return _replace_nested(parameters, dict(values))


def _replace_nested(parameters: T, values: dict[str, Any]) -> T:
    changes: dict[str, Any] = {}
    nested: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        head, _, rest = name.partition(".")
        if rest:
            nested.setdefault(head, {})[rest] = value
        else:
            changes[head] = value
    for head, inner in nested.items():
        changes[head] = _replace_nested(getattr(parameters, head), inner)
    return dataclasses.replace(parameters, **changes)
