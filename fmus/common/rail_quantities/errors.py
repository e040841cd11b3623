"""Errors that say what was given, what is allowed, and what to do."""

import difflib
from collections.abc import Iterable


class ParameterError(ValueError):
    """A parameter has a value that the model cannot take.

    Attributes
    ----------
    name, value, limit, remedy
        The dotted name, the refused value, the rule it breaks, what to do.
    """

    def __init__(self, name: str, value: object, limit: str, remedy: str = "") -> None:
        self.name, self.value, self.limit, self.remedy = name, value, limit, remedy
        super().__init__(f"{name} = {value!r}: {limit}" + (f"; {remedy}" if remedy else ""))


class UnknownParameterError(ParameterError):
    """A name that no parameter has."""

    def __init__(self, name: str, value: object, names: Iterable[str]) -> None:
        close = nearest(name, names)
        remedy = "did you mean " + " or ".join(close) + "?" if close else "see the list of names"
        super().__init__(name, value, "there is no parameter of this name", remedy)


def nearest(name: str, names: Iterable[str], count: int = 2) -> list[str]:
    """Return up to ``count`` of ``names`` that resemble ``name``, best first."""
    return difflib.get_close_matches(name, list(names), n=count, cutoff=0.6)
