"""The one table of variables of a slave."""

import dataclasses
import hashlib
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal, get_args

from rail_quantities import ParameterError, ParameterSet, flatten

from rail_fmi.errors import TableError
from rail_fmi.units import base_exponents

Kind = Literal["real", "integer", "boolean", "string"]
Causality = Literal["parameter", "calculatedParameter", "input", "output", "local"]
Variability = Literal["fixed", "tunable", "discrete", "continuous"]

KINDS: tuple[Kind, ...] = get_args(Kind)

_TYPES: dict[str, type] = {"real": float, "integer": int, "boolean": bool, "string": str}
_ALLOWED = {
    "parameter": ("fixed", "tunable"),
    "calculatedParameter": ("fixed", "tunable"),
    "input": ("continuous", "discrete"),
    "output": ("continuous", "discrete"),
    "local": ("continuous", "discrete", "fixed", "tunable"),
}
_NAME = re.compile(
    r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*", flags=re.ASCII
)
_INTEGER_LIMIT = 2**31


@dataclasses.dataclass(frozen=True)
class Variable:
    """One FMI variable.

    Attributes
    ----------
    name
        Structured name, such as ``wheelset[1].contact.vertical_force``.
    kind
        ``real``, ``integer``, ``boolean`` or ``string``. A choice of words is a
        string with ``choices``, so that every tool can set it by name.
    causality, variability
        As in FMI 2.0; an empty ``variability`` takes the usual one.
    unit
        SI unit of a real, ``"1"`` for none.
    start
        Default of parameters and inputs; for the others the value held before
        the first initialisation. ``None`` means zero, false or no text.
    minimum, maximum
        Closed limits; ``None`` for none. An open limit is checked by the model.
    nominal
        A typical magnitude, for tools that scale.
    description
        Meaning in one sentence.
    choices
        The allowed words of a string; empty for any text.
    """

    name: str
    _: dataclasses.KW_ONLY
    kind: Kind = "real"
    causality: Causality = "local"
    variability: Variability | Literal[""] = ""
    unit: str = "1"
    start: Any = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    description: str = ""
    choices: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise TableError(f"{self.name!r} is not a structured FMI name")
        if self.kind not in KINDS:
            raise TableError(f"{self.name}: kind {self.kind!r} is not one of {', '.join(KINDS)}")
        if self.causality not in _ALLOWED:
            raise TableError(
                f"{self.name}: causality {self.causality!r} is not one of {', '.join(_ALLOWED)}"
            )
        self._set_variability()
        base_exponents(self.unit)
        if self.choices and self.kind != "string":
            raise TableError(f"{self.name}: only a string can have choices")
        self._set_start()

    def _set_variability(self) -> None:
        usual = "fixed" if "arameter" in self.causality else "discrete"
        if usual == "discrete" and self.kind == "real":
            usual = "continuous"
        variability = self.variability or usual
        allowed = _ALLOWED[self.causality]
        if variability not in allowed or (variability == "continuous" and self.kind != "real"):
            raise TableError(
                f"{self.name}: FMI 2.0 allows no {variability} {self.causality} of kind {self.kind}"
            )
        object.__setattr__(self, "variability", variability)

    def _set_start(self) -> None:
        start = self.start
        if start is None:
            start = self.choices[0] if self.choices else _TYPES[self.kind]()
            if self.kind in ("real", "integer") and self.start is None:
                start = _TYPES[self.kind](self._nearest_to_zero())
        try:
            object.__setattr__(self, "start", self.check(start))
        except ParameterError as error:
            raise TableError(f"start value: {error}") from error

    def _nearest_to_zero(self) -> float:
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        return min(max(0.0, low), high)

    @property
    def settable(self) -> bool:
        """Whether a tool may set it: parameters and inputs."""
        return self.causality in ("parameter", "input")

    @property
    def limits(self) -> str:
        """The allowed values in words, empty if all."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        low, high = self.minimum, self.maximum
        if low is not None and high is not None:
            return f"from {low:g} to {high:g}"
        if low is not None:
            return f"at least {low:g}"
        return "" if high is None else f"at most {high:g}"

    def check(self, value: Any) -> Any:
        """Return ``value`` in the type of this variable.

        Raises
        ------
        rail_quantities.ParameterError
            If it has another type, is not finite or out of the limits.
        """
        if self.kind == "string":
            return self._check_text(value)
        if self.kind == "boolean":
            if not isinstance(value, bool | int) or value not in (0, 1):
                raise ParameterError(self.name, value, "must be true or false")
            return bool(value)
        return self._check_number(value)

    def _check_text(self, value: Any) -> str:
        if not isinstance(value, str):
            raise ParameterError(self.name, value, "must be text")
        if self.choices and value not in self.choices:
            raise ParameterError(self.name, value, "must be " + self.limits)
        return value

    def _check_number(self, value: Any) -> float | int:
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            number = math.nan
        if isinstance(value, bool | str) or not math.isfinite(number):
            raise ParameterError(self.name, value, "must be a finite number")
        if self.kind == "integer" and not (
            number.is_integer() and -_INTEGER_LIMIT <= number < _INTEGER_LIMIT
        ):
            raise ParameterError(self.name, value, "must be a whole number of 32 bits")
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= number <= high:
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise ParameterError(
                self.name, value, f"must be {self.limits}{unit}", self.description.rstrip(".")
            )
        return _TYPES[self.kind](number)


KEEP_FIRST_INPUTS = Variable(
    "coupling.keep_first_inputs",
    kind="boolean",
    causality="parameter",
    description="Go through the first step with the inputs that initialization ended with, "
    "whatever was set since: for tools that pass nothing on before the first step",
)
"""A slave that declares it has it: the base does the rest."""


class VariableTable(Mapping[str, Variable]):
    """All variables of a slave by name, in order of declaration.

    Value references count from 0 in each kind, which FMI 2.0 allows; that of a
    real is its place in the flat buffer.

    Raises
    ------
    TableError
        If a name occurs twice.
    """

    def __init__(self, variables: Iterable[Variable]) -> None:
        self._variables: dict[str, Variable] = {}
        self._references: dict[str, int] = {}
        self.of_kind: dict[str, list[Variable]] = {kind: [] for kind in KINDS}
        for variable in variables:
            if variable.name in self._variables:
                raise TableError(f"{variable.name} is declared twice")
            self._variables[variable.name] = variable
            self._references[variable.name] = len(self.of_kind[variable.kind])
            self.of_kind[variable.kind].append(variable)

    def __getitem__(self, name: str) -> Variable:
        return self._variables[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def reference(self, name: str) -> int:
        """Return the FMI value reference of a name (unique in its kind)."""
        return self._references[name]

    def with_causality(self, *causalities: Causality) -> list[Variable]:
        """Return the variables of these causalities, in order."""
        return [v for v in self._variables.values() if v.causality in causalities]

    @property
    def digest(self) -> str:
        """SHA-256 of everything that the table says."""
        rows = [dataclasses.asdict(variable) for variable in self._variables.values()]
        return hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).hexdigest()


def parameter_variables(parameters: ParameterSet) -> list[Variable]:
    """Return one fixed parameter for each quantity of a parameter set.

    Kind and start are those of the value. FMI has closed limits only: an open
    limit is given as a closed one, and the parameter set itself refuses the
    end value at initialisation.
    """
    kinds: dict[type, Kind] = {float: "real", int: "integer", bool: "boolean", str: "string"}
    table = []
    for name, (about, value) in flatten(parameters).items():
        kind = kinds[type(value)]
        table.append(
            Variable(
                name,
                kind=kind,
                causality="parameter",
                unit=about.unit,
                start=value,
                minimum=about.at_least if about.above is None else about.above,
                maximum=about.at_most if about.below is None else about.below,
                nominal=about.nominal,
                description=about.description,
                choices=about.choices,
            )
        )
    return table
