"""What an entry of a compiled core takes: arrays, numbers and named tuples of them.

The annotations of an entry say it, and nothing else: :data:`Vector`, :data:`Matrix`, ... for
arrays, ``float``, ``int`` and ``bool`` for numbers, a ``NamedTuple`` class for a group. All are
laid out in five tables, in the order in which they are named: pointers to arrays of reals,
pointers to arrays of integers, the arrays' sizes, reals, integers. The tables are the whole of the
C interface, so a caller needs neither numba nor numpy, and an image of a parameter set is the
tables with offsets instead of pointers.
"""

import dataclasses
import typing
from collections.abc import Callable, Iterator
from typing import Annotated, Any

import numpy as np


@dataclasses.dataclass(frozen=True)
class ArrayKind:
    """Element type and number of dimensions of a C-contiguous array."""

    dtype: str
    ndim: int


Vector = Annotated[np.ndarray, ArrayKind("float64", 1)]
Matrix = Annotated[np.ndarray, ArrayKind("float64", 2)]
Array3 = Annotated[np.ndarray, ArrayKind("float64", 3)]
Array4 = Annotated[np.ndarray, ArrayKind("float64", 4)]
Indices = Annotated[np.ndarray, ArrayKind("int64", 1)]
IndexMatrix = Annotated[np.ndarray, ArrayKind("int64", 2)]

Leaf = ArrayKind | type
"""An array, or ``float``, ``int`` or ``bool``."""


@dataclasses.dataclass(frozen=True)
class Group:
    """A named tuple: its class and what its fields hold."""

    kind: type
    fields: tuple[tuple[str, "Leaf | Group"], ...]


def parameters(function: Callable[..., Any]) -> tuple[tuple[str, Leaf | Group], ...]:
    """Return name and kind of each argument of an entry.

    Raises
    ------
    TypeError
        For an annotation that has no place in the tables.
    """
    hints = typing.get_type_hints(function, include_extras=True)
    hints.pop("return", None)
    return tuple((name, _kind_of(hint, name)) for name, hint in hints.items())


def result(function: Callable[..., Any]) -> type:
    """Return ``int``, ``float``, ``bool`` or ``NoneType``: what an entry's C function returns."""
    hint = typing.get_type_hints(function).get("return", type(None))
    return type(None) if typing.get_origin(hint) is tuple else hint


def results(function: Callable[..., Any]) -> int:
    """Return how many numbers an entry returns as a tuple of ``float``; 0 if it returns none.

    They are written to a vector that comes after all arguments.
    """
    hint = typing.get_type_hints(function).get("return", None)
    return len(typing.get_args(hint)) if typing.get_origin(hint) is tuple else 0


def _kind_of(hint: Any, name: str) -> Leaf | Group:
    if isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields"):
        of = typing.get_type_hints(hint, include_extras=True)
        return Group(hint, tuple((field, _kind_of(of[field], field)) for field in hint._fields))
    for extra in getattr(hint, "__metadata__", ()):
        if isinstance(extra, ArrayKind):
            return extra
    if hint in (float, int, bool):
        return hint
    raise TypeError(f"{name}: {hint!r} is neither array, number nor named tuple of these")


def leaves(kind: Leaf | Group, value: Any) -> Iterator[tuple[Leaf, Any]]:
    """Return kind and value of all arrays and numbers, in the order of the tables."""
    if isinstance(kind, Group):
        for (_, of), part in zip(kind.fields, value, strict=True):
            yield from leaves(of, part)
    else:
        yield kind, value
