"""Variables of a slave as FMI sees them: declared once, read and written by value reference."""

import math
import threading
import weakref
from collections.abc import MutableMapping, Sequence
from typing import Any

import numpy as np

from rail_fmi import host
from rail_fmi.errors import StepError
from rail_fmi.guard import GuardedSlave
from rail_fmi.storage import ValueView, VariableStore, contiguous_or_array
from rail_fmi.variables import Variable, VariableTable

LARGEST = 1e12
"""No input comes near this in SI units."""

LARGEST_SQUARE = LARGEST**2

STATUS_MESSAGE = Variable(
    "status.message",
    kind="string",
    description="Why the run stopped; empty while all is well. Readable without logging.",
)


PACKED_OUTPUTS = Variable(
    "outputs.packed",
    kind="string",
    description="All real outputs, then all integer ones, in the order of this description, as "
    "float64, little-endian, in hexadecimal digits: for hosts that take down all outputs at every "
    "step, to which single values cost more than the text",
)


class Mode:
    """Where in its life a slave is."""

    INSTANTIATED = "instantiated"
    INITIALIZING = "initialization"
    RUNNING = "running"
    TERMINATED = "terminated"


class ValueSlave(GuardedSlave):
    """A guarded slave with a table of variables and their values.

    Attributes
    ----------
    table
        All variables, :data:`STATUS_MESSAGE` last.
    reals
        float64 array of all reals; value reference = position.
    values
        All values by name; slow beside ``reals``.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.modelName = getattr(type(self), "MODEL_NAME", type(self).__name__)
        self._mode = Mode.INSTANTIATED
        self._stale = False
        self._suspect = False
        # With a text that is not UTF-8, pythonfmu calls set_string while an error is pending.
        # Then Python finds it in the instance only, and newer ones run little before they trip.
        method, forget = weakref.WeakMethod(self._set_strings), host.forget_pending_error

        def set_string(vrs: list[int], values: list[str]) -> None:
            forget()
            if call := method():
                call(vrs, values)

        self.set_string = set_string
        self._make_variables()

    def _make_variables(self) -> None:
        try:
            self.table = VariableTable([*self.declare(), PACKED_OUTPUTS, STATUS_MESSAGE])
        except Exception as error:  # the constructor must not raise in the host
            self.table = VariableTable([STATUS_MESSAGE])
            self._hold(error)
        self._store = VariableStore(self.table)
        self.reals = self._store.reals
        self._buffer = self.reals.data
        self.values: MutableMapping[str, Any] = ValueView(self._store)
        self.values[STATUS_MESSAGE.name] = self._run_error
        self._find_outputs()

    def _find_outputs(self) -> None:
        """Find what is calculated, and what :data:`PACKED_OUTPUTS` consists of."""
        self._calculated = np.array([not v.settable for v in self.table.of_kind["real"]], bool)
        outputs = self.table.with_causality("output")
        places = {
            kind: [self.table.reference(v.name) for v in outputs if v.kind == kind]
            for kind in ("real", "integer")
        }
        self._real_outputs = contiguous_or_array(places["real"])
        self._integer_outputs = list(enumerate(places["integer"], len(places["real"])))
        self._packed = np.zeros(len(places["real"]) + len(places["integer"]), dtype="<f8")
        self._packed_reals = self._packed[: len(places["real"])]
        self._packed_request = [
            self.table.reference(name) for name in (PACKED_OUTPUTS.name,) if name in self.table
        ]

    def declare(self) -> Sequence[Variable]:
        """Return the table of variables; called once, in the constructor."""
        raise NotImplementedError(f"{type(self).__name__} must declare its variables")

    def parameters(self) -> dict[str, Any]:
        """Return the values of all parameters by name, in order of declaration."""
        return {v.name: self.values[v.name] for v in self.table.with_causality("parameter")}

    def indices(self, names: Sequence[str]) -> np.ndarray:
        """Return the positions of reals in :attr:`reals`, shape (n,), as integers."""
        for name in names:
            if self.table[name].kind != "real":
                raise KeyError(f"{name} is not a real variable")
        return np.array([self.table.reference(name) for name in names], dtype=np.intp)

    def slice_of(self, *names: str) -> slice:
        """Return the slice of :attr:`reals` that holds these reals, in this order.

        Raises
        ------
        KeyError
            If they were not declared one after the other.
        """
        place = contiguous_or_array(self.indices(names).tolist())
        if not isinstance(place, slice):
            raise KeyError(f"{names[0]} ... {names[-1]} were not declared one after the other")
        return place

    def _publish_status(self) -> None:
        if hasattr(self, "_store"):
            self.values[STATUS_MESSAGE.name] = self._run_error or self._setup_error

    def _refresh(self) -> None:
        """Compute the values that follow from those the host has set."""
        self._stale = False

    def _observe(self) -> None:
        """Compute the local reals, one of which is about to be read."""

    def _check_finite(self, *causalities: Any) -> None:
        bad = self._store.not_finite(*causalities)
        if bad:
            more = f" and {len(bad) - 3} more" if len(bad) > 3 else ""
            raise StepError(f"values must be finite: {', '.join(bad[:3])}{more}")

    def _check_sizes(self) -> None:
        """Refuse inputs that no partner in its senses gives."""
        for variable in self.table.with_causality("input"):
            if variable.kind == "real" and abs(value := self.values[variable.name]) >= LARGEST:
                raise StepError(
                    f"{variable.name} = {value:g} {variable.unit}: no physical value; what gives "
                    "this input has diverged"
                )

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return reals by value reference; not-a-number if a reference does not exist."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if self._stale:
                self._refresh()
            plan = self._store.plan(vrs)
            if plan.observed:
                self._observe()
            return self._shown(plan.index).tolist()
        except BaseException as error:
            self._hold(error)
        self._refuse()
        return [math.nan] * len(vrs)

    def _shown(self, index: Any) -> np.ndarray:
        """Return reals as a host may see them: after an error no output looks like a result."""
        values = self.reals[index]
        if self._run_error or self._setup_error:
            return np.where(self._calculated[index], math.nan, values)
        return values

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Write reals by value reference."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            plan = self._store.plan(vrs)
            if plan.readonly or (plan.fixed and self._mode == Mode.RUNNING):
                raise self._refused(plan.readonly, plan.fixed)
            if plan.pack is None:
                self.reals[plan.index] = values
                given = self.reals[plan.index]
            else:
                plan.pack(self._buffer, plan.place, *values)
                given = plan.view
            if not given.dot(given) < LARGEST_SQUARE:  # nor is it with one that is no number
                self._suspect = True
            self._stale = self._mode == Mode.INITIALIZING
            return
        except BaseException as error:
            self._hold(error)
        self._refuse()

    @staticmethod
    def _refused(readonly: str, fixed: str) -> StepError:
        if readonly:
            return StepError(f"{readonly} is calculated by the model and cannot be set")
        return StepError(f"{fixed} is a fixed parameter: set it before initialization mode ends")

    def _get(self, kind: str, vrs: list[int], default: Any) -> list[Any]:
        def work() -> list[Any]:
            if self._stale:
                self._refresh()
            return self._store.get(kind, vrs)

        return self._guarded(work, [default] * len(vrs))

    def _set(self, kind: str, vrs: list[int], values: Sequence[Any]) -> None:
        def work() -> None:
            wanted = host.texts_from_host(values) if kind == "string" else values
            chosen = self._store.variables(kind, vrs)
            readonly = next((v.name for v in chosen if not v.settable), "")
            fixed = next((v.name for v in chosen if v.variability == "fixed"), "")
            if readonly or (fixed and self._mode == Mode.RUNNING):
                raise self._refused(readonly, fixed)
            self._store.set(kind, vrs, wanted)
            self._stale = self._mode == Mode.INITIALIZING

        self._guarded(work)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return integers by value reference."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if self._stale:
                self._refresh()
            return [self._store.integers[self._store.checked("integer", vr)] for vr in vrs]
        except BaseException as error:
            self._hold(error)
        self._refuse()
        return [0] * len(vrs)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return booleans by value reference."""
        return self._get("boolean", vrs, False)

    def get_string(self, vrs: list[int]) -> list[str]:
        """Return texts by value reference."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if self._stale:
                self._refresh()
            if vrs == self._packed_request:
                return [self._pack_outputs()]
            texts = [host.encodable(text) for text in self._store.get("string", vrs)]
            for place, vr in enumerate(vrs):
                if vr in self._packed_request:
                    texts[place] = self._pack_outputs()
            return texts
        except BaseException as error:
            self._hold(error)
        self._refuse()
        return [""] * len(vrs)

    def _pack_outputs(self) -> str:
        self._packed_reals[:] = self._shown(self._real_outputs)
        for place, reference in self._integer_outputs:
            self._packed[place] = self._store.integers[reference]
        return self._packed.data.hex()

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Write integers by value reference."""
        self._set("integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Write booleans by value reference."""
        self._set("boolean", vrs, values)

    def _set_strings(self, vrs: list[int], values: list[str]) -> None:
        self._set("string", vrs, values)
