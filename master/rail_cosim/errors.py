"""Errors of the master: each says what was given, what is allowed, and what to do.

The master has its own, and imports nothing that an FMU also carries: a copy of
such a package loaded by the master would stand in the way of the FMU's own.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import xarray as xr

    from rail_cosim.slave import Message, Status

__all__ = [
    "BuildError",
    "DivergenceError",
    "FmuFileError",
    "ParameterError",
    "RailCosimError",
    "RefusalError",
    "ResultsError",
    "RunError",
    "RunInterrupted",
    "SlaveError",
    "StructureError",
    "UnknownNameError",
    "nearest",
]


class RailCosimError(Exception):
    """Base of all errors that are the user's to see; the text is complete as it is."""

    exit_status: ClassVar[int] = 1


class ParameterError(RailCosimError):
    """A parameter or option has a value that cannot be used.

    Attributes
    ----------
    name, value, limit, remedy
        The dotted name, the refused value, the rule it breaks, what to do.
    """

    exit_status = 2

    def __init__(self, name: str, value: object, limit: str, remedy: str = "") -> None:
        self.name, self.value, self.limit, self.remedy = name, value, limit, remedy
        shown = value if isinstance(value, str) and _is_number(value) else repr(value)
        super().__init__(f"{name} = {shown}: {limit}" + (f"; {remedy}" if remedy else ""))


class UnknownNameError(ParameterError):
    """A parameter, preset or algorithm that does not exist.

    ``wanted`` is what is looked up among ``names``: the name itself unless
    given (for an option whose *value* is the unknown name). With ``listed``
    all names are told, also beside a near one.
    """

    def __init__(
        self,
        name: str,
        value: object,
        names: Iterable[str],
        what: str,
        wanted: str | None = None,
        *,
        listed: bool = False,
    ) -> None:
        known = list(names)
        close = nearest(name if wanted is None else wanted, known)
        if close:
            remedy = "did you mean " + " or ".join(close) + "?"
            remedy += f" (there are {', '.join(known)})" if listed else ""
        elif 0 < len(known) <= 12:
            remedy = "there are " + ", ".join(known)
        else:
            remedy = f"see the list of names ({len(known)} of them)" if known else "there are none"
        super().__init__(name, value, f"there is no {what} of this name", remedy)


class FmuFileError(RailCosimError):
    """A file is no FMU that this master can run."""

    exit_status = 2


class StructureError(RailCosimError):
    """The slaves do not fit together."""

    exit_status = 2


class SlaveError(RailCosimError):
    """A slave returned a status that ends the run.

    Attributes
    ----------
    slave, call, status, time
        Name of the slave, the FMI function, what it returned, and the
        communication point in seconds (``None`` outside of stepping).
    """

    def __init__(
        self,
        slave: str,
        call: str,
        status: Status,
        messages: Sequence[Message] = (),
        time: float | None = None,
    ) -> None:
        self.slave, self.call, self.status, self.time = slave, call, status, time
        when = "" if time is None else f" at t = {time:.6g} s"
        said = "\n".join(message.text for message in messages)
        said = said or "it gave no reason; run it alone with logging on to see more"
        super().__init__(f"{slave}: {call} failed{when} (status {status.name.lower()}): {said}")


class RefusalError(SlaveError):
    """A slave refused the values of its parameters during set-up."""

    exit_status = 2


class DivergenceError(RailCosimError):
    """An exchanged quantity is no longer a finite number, or an iteration does not converge."""


class BuildError(RailCosimError):
    """An FMU could not be built."""


class ResultsError(RailCosimError):
    """Results could not be written where they were asked for."""


class RunError(RailCosimError):
    """A run ended early; what it recorded is in ``dataset`` (``None`` if nothing).

    Raised from the error that ended it.
    """

    def __init__(self, text: str, dataset: xr.Dataset | None) -> None:
        self.dataset = dataset
        super().__init__(text)


class RunInterrupted(RunError):  # noqa: N818 - it is no error, the user asked for it
    """The user stopped the run; what it recorded is in ``dataset``."""

    exit_status = 130


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def nearest(name: str, names: Iterable[str], count: int = 2) -> list[str]:
    """Return up to ``count`` of ``names`` that resemble ``name``, best first."""
    by_lower = {known.lower(): known for known in names}
    close = difflib.get_close_matches(name.lower(), list(by_lower), n=count, cutoff=0.6)
    return [by_lower[found] for found in close]
