"""A choice of the variables that the results of a run have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from rail_cosim.errors import UnknownNameError

ALWAYS = "distance"


def chosen(name: str, patterns: Sequence[str]) -> bool:
    """Say whether a variable is recorded by this choice of names; an empty one chooses all."""
    if not patterns or name == ALWAYS:
        return True
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def check_variables(patterns: Sequence[str], known: Iterable[str]) -> None:
    """Refuse a choice in which a name or pattern is none of the known variables.

    Raises
    ------
    UnknownNameError
        For the first that is not, with the nearest names.
    """
    names = list(known)
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise UnknownNameError("--variables", pattern, names, "variable in a run", pattern)
