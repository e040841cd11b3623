"""Values of all variables: a flat buffer for the reals, lists for the rest."""

import math
import struct
from collections.abc import Iterator, MutableMapping, Sequence
from typing import Any

import numpy as np

from rail_fmi.errors import StepError
from rail_fmi.variables import KINDS, Variable, VariableTable

_PLAN_LIMIT = 256


class AccessPlan:
    """How to reach one list of value references of reals.

    Hosts ask for the same lists at every step, so the checks and the index
    are made once for each list.
    """

    __slots__ = ("fixed", "index", "observed", "pack", "place", "readonly", "references", "view")

    def __init__(
        self, references: list[int], variables: Sequence[Variable], reals: np.ndarray
    ) -> None:
        chosen = [_variable(variables, reference) for reference in references]
        self.references = list(references)
        self.index = contiguous_or_array(references)
        # From a list, packing bytes is several times as fast as numpy is.
        span = isinstance(self.index, slice)
        self.pack = struct.Struct(f"{len(references)}d").pack_into if span else None
        self.view = reals[self.index]  # of no use where the references are not consecutive
        self.place = 8 * self.index.start if isinstance(self.index, slice) else 0
        self.readonly = next((v.name for v in chosen if not v.settable), "")
        self.fixed = next((v.name for v in chosen if v.variability == "fixed"), "")
        self.observed = any(v.causality == "local" for v in chosen)


def _variable(variables: Sequence[Variable], reference: int) -> Variable:
    if not 0 <= reference < len(variables):
        raise StepError(
            f"value reference {reference} does not exist: "
            f"there are {len(variables)} variables of this kind"
        )
    return variables[reference]


def contiguous_or_array(positions: Sequence[int]) -> slice | np.ndarray:
    """Return a slice for consecutive positions, else an index array."""
    first, count = (positions[0] if positions else 0), len(positions)
    if list(positions) == list(range(first, first + count)):
        return slice(first, first + count)
    return np.array(positions, dtype=np.intp)


class VariableStore:
    """The values of a table's variables.

    Attributes
    ----------
    reals
        float64 array; a real's value reference is its position.
    integers, booleans, strings
        Lists in the order of the value references.
    """

    def __init__(self, table: VariableTable) -> None:
        self.table = table
        self.reals = np.array([v.start for v in table.of_kind["real"]], dtype=np.float64)
        self.integers: list[int] = [v.start for v in table.of_kind["integer"]]
        self.booleans: list[bool] = [v.start for v in table.of_kind["boolean"]]
        self.strings: list[str] = [v.start for v in table.of_kind["string"]]
        self._lists: dict[str, list[Any]] = {
            "integer": self.integers,
            "boolean": self.booleans,
            "string": self.strings,
        }
        parameters = table.with_causality("parameter")
        self._fixed = {
            kind: [table.reference(v.name) for v in parameters if v.kind == kind] for kind in KINDS
        }
        self._plans: dict[tuple[int, int], AccessPlan] = {}

    def plan(self, references: list[int]) -> AccessPlan:
        """Return the plan of a list of value references of reals.

        Raises
        ------
        StepError
            For a value reference that does not exist.
        """
        key = (len(references), references[0] if references else -1)
        plan = self._plans.get(key)
        if plan is None or plan.references != references:
            plan = AccessPlan(references, self.table.of_kind["real"], self.reals)
            if len(self._plans) >= _PLAN_LIMIT:
                self._plans.clear()
            self._plans[key] = plan
        return plan

    def checked(self, kind: str, reference: int) -> int:
        """Return a value reference that exists.

        Raises
        ------
        StepError
            If it does not.
        """
        if not 0 <= reference < len(self._lists[kind]):
            _variable(self.table.of_kind[kind], reference)
        return reference

    def get(self, kind: str, references: Sequence[int]) -> list[Any]:
        """Return integers, booleans or strings by value reference."""
        self.variables(kind, references)
        return [self._lists[kind][reference] for reference in references]

    def set(self, kind: str, references: Sequence[int], values: Sequence[Any]) -> None:
        """Write integers, booleans or strings by value reference."""
        for reference, value in zip(references, values, strict=True):
            self._lists[kind][reference] = value

    def variables(self, kind: str, references: Sequence[int]) -> list[Variable]:
        """Return the variables of value references.

        Raises
        ------
        StepError
            For a value reference that does not exist.
        """
        return [_variable(self.table.of_kind[kind], reference) for reference in references]

    def value(self, name: str) -> Any:
        """Return the value of a variable by name."""
        kind, reference = self.table[name].kind, self.table.reference(name)
        if kind == "real":
            return float(self.reals[reference])
        return self._lists[kind][reference]

    def write(self, name: str, value: Any) -> None:
        """Write a value by name, in the variable's type, without checking limits."""
        kind, reference = self.table[name].kind, self.table.reference(name)
        if kind == "real":
            self.reals[reference] = value
        else:
            self._lists[kind][reference] = {"integer": int, "boolean": bool, "string": str}[kind](
                value
            )

    def not_finite(self, *causalities: Any) -> list[str]:
        """Return the names of the reals of these causalities that are not finite."""
        if np.isfinite(self.reals).all():
            return []
        return [
            f"{v.name} = {self.value(v.name)}"
            for v in self.table.with_causality(*causalities)
            if v.kind == "real" and not math.isfinite(self.value(v.name))
        ]

    def parameter_key(self) -> tuple[Any, ...]:
        """Return the values of all parameters in a form that compares quickly."""
        reals = self.reals[self._fixed["real"]].tobytes()
        return (
            reals,
            *(
                self._lists[kind][i]
                for kind in ("integer", "boolean", "string")
                for i in self._fixed[kind]
            ),
        )

    def save(self) -> dict[str, Any]:
        """Return all values as a flat dictionary of arrays and scalars."""
        saved: dict[str, Any] = {"reals": self.reals}
        saved["integers"] = np.array(self.integers, dtype=np.int64)
        saved["booleans"] = np.array(self.booleans, dtype=np.bool_)
        return saved | {f"string.{i}": text for i, text in enumerate(self.strings)}

    def load(self, saved: dict[str, Any]) -> None:
        """Write values saved by :meth:`save`."""
        self.reals[:] = saved["reals"]
        self.integers[:] = saved["integers"].tolist()
        self.booleans[:] = saved["booleans"].tolist()
        self.strings[:] = [saved[f"string.{i}"] for i in range(len(self.strings))]


class ValueView(MutableMapping[str, Any]):
    """Values by name: convenient, and slow beside the flat buffer."""

    def __init__(self, store: VariableStore) -> None:
        self._store = store

    def __getitem__(self, name: str) -> Any:
        return self._store.value(name)

    def __setitem__(self, name: str, value: Any) -> None:
        if name not in self._store.table:
            raise KeyError(name)
        self._store.write(name, value)

    def __delitem__(self, name: str) -> None:
        raise TypeError(f"{name}: variables cannot be deleted")

    def __iter__(self) -> Iterator[str]:
        return iter(self._store.table)

    def __len__(self) -> int:
        return len(self._store.table)
