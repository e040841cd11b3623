"""What the algorithms know of a slave: names, vectors, steps, states.

Everything above (system structure, algorithms, recorder) is written against
the protocols of this file, so that it runs on mock slaves as on FMUs.
"""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol

from numpy.typing import NDArray

Kind = Literal["real", "integer", "boolean", "string", "enumeration"]
Value = float | int | bool | str


class Status(enum.IntEnum):
    """Return values of FMI 2.0 functions."""

    OK = 0
    WARNING = 1
    DISCARD = 2
    ERROR = 3
    FATAL = 4
    PENDING = 5


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Message:
    """One line of a slave's log."""

    status: Status
    text: str


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Renaming:
    """Which variable of an FMU stands for a name of the contract.

    Attributes
    ----------
    name
        In the contract.
    own
        In the FMU.
    factor, offset
        A value of the contract is ``factor`` times that of the FMU plus ``offset``.
    converted
        Whether it then has the contract's unit; else it has the one that the FMU declares.
    """

    name: str
    own: str
    factor: float = 1.0
    offset: float = 0.0
    converted: bool = False

    @property
    def scales(self) -> bool:
        """Whether the numbers differ."""
        return (self.factor, self.offset) != (1.0, 0.0)

    def to_contract(self, value: Any) -> Any:
        """Return the contract's value for that of the FMU, a number or an array."""
        return self.factor * value + self.offset

    def to_own(self, value: Any) -> Any:
        """Return the FMU's value for that of the contract, a number or an array."""
        return (value - self.offset) / self.factor


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Variable:
    """A variable as the slave's description declares it.

    Attributes
    ----------
    name, kind, causality, variability, unit, description, start
        As in FMI; ``unit`` is ``""`` where none is declared, ``start`` is
        ``None`` where there is none.
    minimum, maximum
        Closed limits of a number, ``None`` for none.
    choices
        Allowed words of an enumeration, with their numbers, or of a text;
        empty for any text.
    reference
        FMI value reference; only the slave itself uses it.
    renaming
        Where it came by this name, ``None`` if the description has it; all other attributes
        are then those of the contract's value (see :mod:`rail_cosim.name_map`).
    """

    name: str
    kind: Kind = "real"
    causality: str = "local"
    variability: str = "continuous"
    unit: str = ""
    description: str = ""
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    choices: Mapping[str, int] = dataclasses.field(default_factory=dict)
    reference: int = 0
    renaming: Renaming | None = None

    @property
    def scaled(self) -> bool:
        """Whether its values are not the numbers that the FMU has."""
        return self.renaming is not None and self.renaming.scales


class Vector(Protocol):
    """Some variables of one slave and one kind, in a fixed order, and a buffer for their values.

    Attributes
    ----------
    names
        The variables' names.
    values
        Buffer, shape (n,), of float64 for reals and int32 for integers; the same
        array until :meth:`place` gives another.
    """

    names: tuple[str, ...]
    values: NDArray[Any]

    def place(self, buffer: NDArray[Any]) -> None:
        """Take this array, of the same shape and type, as the buffer."""
        ...

    def read(self, count: int | None = None) -> None:
        """Copy the first ``count`` (default: all) values from the slave into the buffer."""
        ...

    def write(self) -> None:
        """Copy the buffer into the slave."""
        ...


class Slave(Protocol):
    """A simulator of one part of the system, between instantiation and release.

    Calls that fail raise :class:`rail_cosim.errors.SlaveError`.
    """

    name: str

    @property
    def variables(self) -> Mapping[str, Variable]:
        """All variables by name, in the slave's own order."""
        ...

    def vector(self, names: Sequence[str], kind: Literal["real", "integer"] = "real") -> Vector:
        """Return a vector of variables, all of one kind."""
        ...

    def get(self, names: Sequence[str]) -> dict[str, Value]:
        """Return values of any kind by name (slow)."""
        ...

    def set(self, values: Mapping[str, Value]) -> None:
        """Set values of any kind by name (slow)."""
        ...

    def setup(self, start_time: float, stop_time: float) -> None:
        """Announce the span of time."""
        ...

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        ...

    def exit_initialization(self) -> None:
        """Leave initialization mode: the slave is ready to step."""
        ...

    def do_step(self, time: float, step_size: float) -> None:
        """Advance from ``time`` by ``step_size`` seconds."""
        ...

    def save_state(self) -> Any:
        """Return a handle to a copy of the complete state."""
        ...

    def restore_state(self, state: Any) -> None:
        """Go back to a saved state; the handle stays valid."""
        ...

    def free_state(self, state: Any) -> None:
        """Release a handle of :meth:`save_state`."""
        ...

    def take_warnings(self) -> list[str]:
        """Return warnings that were not returned before, each text once in a run."""
        ...
