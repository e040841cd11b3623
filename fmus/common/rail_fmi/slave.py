"""The FMI 2.0 co-simulation slave from which both FMUs are made."""

import dataclasses
import math
import threading
import weakref
from collections.abc import Mapping, MutableMapping, Sequence
from typing import Any, ClassVar
from xml.etree.ElementTree import Element

import numpy as np

from rail_fmi import host, state
from rail_fmi.description import ModelInformation, model_description
from rail_fmi.errors import RailFmiError, StateError, StepError
from rail_fmi.guard import GuardedSlave
from rail_fmi.identity import Identity, read_identity
from rail_fmi.storage import ValueView, VariableStore, contiguous_or_array
from rail_fmi.variables import Variable, VariableTable

STATUS_MESSAGE = Variable(
    "status.message",
    kind="string",
    description="Why the run stopped; empty while all is well. Readable without logging.",
)

_INSTANTIATED, _INITIALIZING, _RUNNING, _TERMINATED = (
    "instantiated",
    "initialization",
    "running",
    "terminated",
)


class RailSlave(GuardedSlave):
    """Base of the slaves: variables, checks, state and errors; no physics.

    Subclasses set :attr:`MODEL_NAME`, may set :attr:`PRESETS` and pythonfmu's
    ``description``, ``author``, ``version``, ``license``, ``copyright`` and
    ``default_experiment``, and write the hooks :meth:`declare`,
    :meth:`initialize`, :meth:`start`, :meth:`step`, :meth:`save` and
    :meth:`restore`. A hook may raise anything: the error is logged with its
    text, held, and every step from then on is refused.

    Attributes
    ----------
    table
        All variables, :data:`STATUS_MESSAGE` last.
    reals
        float64 array of all reals; value reference = position.
    values
        All values by name; slow beside ``reals``.
    time
        End of the last step in s.
    """

    MODEL_NAME: ClassVar[str]
    PRESETS: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.modelName = getattr(type(self), "MODEL_NAME", type(self).__name__)
        self._mode = _INSTANTIATED
        self._stale = False
        self._suspect = False
        self.time = 0.0
        self._built_from: dict[str, Any] | None = None
        # With a text that is not UTF-8, pythonfmu calls set_string while an error is pending, and
        # then Python finds it in the instance only.
        method = weakref.WeakMethod(self._set_strings)
        self.set_string = lambda vrs, values: (call := method()) and call(vrs, values)
        self._make_variables()
        self._identity = read_identity(self.resources, self.modelName, self.table.digest)
        self.guid = self._identity.guid

    def _make_variables(self) -> None:
        try:
            self.table = VariableTable([*self.declare(), STATUS_MESSAGE])
        except Exception as error:  # the constructor must not raise in the host
            self.table = VariableTable([STATUS_MESSAGE])
            self._hold(error)
        self._store = VariableStore(self.table)
        self.reals = self._store.reals
        self.values: MutableMapping[str, Any] = ValueView(self._store)
        self.values[STATUS_MESSAGE.name] = self._run_error

    # Hooks of the subclass

    def declare(self) -> Sequence[Variable]:
        """Return the table of variables; called once, in the constructor."""
        raise NotImplementedError(f"{type(self).__name__} must declare its variables")

    def initialize(self) -> None:
        """Build the model from the parameters and compute the initial outputs.

        Called in initialization mode when an output is read or the mode is
        left, again after each change of a parameter or input, and when a state
        with other parameters is set.
        """

    def start(self) -> None:
        """Do what remains when initialization mode is left."""

    def step(self, time: float, step_size: float) -> None:
        """Go from ``time`` to ``time + step_size``: read inputs, write outputs."""
        raise NotImplementedError(f"{type(self).__name__} must define step")

    def save(self) -> dict[str, Any]:
        """Return the model's state beyond the variables: a flat dict of arrays and scalars."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Take back what :meth:`save` returned; the arrays are the slave's own copies."""

    # What subclasses use

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

    # Initialisation

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Take the start time."""

        def work() -> None:
            self.time = start_time

        self._guarded(work)

    def enter_initialization_mode(self) -> None:
        """Enter the mode; the model is built at the first need."""

        def work() -> None:
            self._mode, self._stale = _INITIALIZING, True

        self._guarded(work)

    def exit_initialization_mode(self) -> None:
        """Build the model if need be, and get ready to step."""

        def work() -> None:
            if self._stale or self._mode != _INITIALIZING:
                self._refresh()
            self._mode = _RUNNING
            if not self.held_error:
                self.start()

        self._guarded(work)

    def _refresh(self) -> None:
        """Initialise the model with the present values; an error is held until they change."""
        self._stale, self._setup_error = False, ""
        try:
            for variable in self.table.with_causality("parameter"):
                variable.check(self.values[variable.name])
            self._check_finite("input")
            self.initialize()
            self._built_from = self.parameters()
            self._check_finite("output", "calculatedParameter")
        except BaseException as error:
            self._hold(error, setup=True)
        self._publish_status()

    def _check_finite(self, *causalities: Any) -> None:
        bad = self._store.not_finite(*causalities)
        if bad:
            more = f" and {len(bad) - 3} more" if len(bad) > 3 else ""
            raise StepError(f"values must be finite: {', '.join(bad[:3])}{more}")

    # Steps

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make one step; return whether it was made."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if self._run_error or self._setup_error:
                return False
            if self._mode != _RUNNING:
                raise StepError(f"a step was asked for in mode {self._mode}; initialise first")
            if self._suspect:
                self._check_finite("input", "parameter")
                self._suspect = False
            self.step(current_time, step_size)
            if not math.isfinite(np.add.reduce(self.reals)):
                self._check_finite("output")
            self.time = current_time + step_size
        except BaseException as error:
            self._hold(error)
            return False
        return True

    def terminate(self) -> None:
        """End the run."""

        def work() -> None:
            self._mode = _TERMINATED

        self._guarded(work)

    # Values

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return reals by value reference; not-a-number if a reference does not exist."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if self._stale:
                self._refresh()
            return self.reals[self._store.plan(vrs).index].tolist()
        except BaseException as error:
            self._hold(error)
            return [math.nan] * len(vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Write reals by value reference."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            plan = self._store.plan(vrs)
            if plan.readonly or (plan.fixed and self._mode == _RUNNING):
                raise self._refused(plan.readonly, plan.fixed)
            self.reals[plan.index] = values
            if not math.isfinite(sum(values)):
                self._suspect = True
            self._stale = self._mode == _INITIALIZING
        except BaseException as error:
            self._hold(error)

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
            if readonly or (fixed and self._mode == _RUNNING):
                raise self._refused(readonly, fixed)
            self._store.set(kind, vrs, wanted)
            self._stale = self._mode == _INITIALIZING

        self._guarded(work)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return integers by value reference."""
        return self._get("integer", vrs, 0)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return booleans by value reference."""
        return self._get("boolean", vrs, False)

    def get_string(self, vrs: list[int]) -> list[str]:
        """Return texts by value reference."""
        return [host.encodable(text) for text in self._get("string", vrs, "")]

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Write integers by value reference."""
        self._set("integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Write booleans by value reference."""
        self._set("boolean", vrs, values)

    def _set_strings(self, vrs: list[int], values: list[str]) -> None:
        self._set("string", vrs, values)

    # State (the names are those that pythonfmu's C++ layer calls)

    def _get_fmu_state(self) -> state.FmuState:  # type: ignore[override]
        empty = state.FmuState(
            model_hash=self._identity.model_hash,
            variable_count=len(self.table),
            refusal="the state could not be saved; see the log",
        )

        def work() -> state.FmuState:
            if self._stale:
                self._refresh()
            values = {f"variables.{k}": v for k, v in self._store.save().items()}
            values |= {"setup_error": self._setup_error, "built": self._built_from is not None}
            if self._built_from is not None:
                values |= {f"model.{name}": value for name, value in self.save().items()}
            return dataclasses.replace(
                empty,
                mode=self._mode,
                time=self.time,
                error=self._run_error,
                values=state.copied(values),
                refusal="",
            )

        return self._guarded(work, empty)

    def _set_fmu_state(self, saved: state.FmuState) -> None:  # type: ignore[override]
        def work() -> None:
            self._check_state(saved)
            values = state.copied(saved.values)
            self._store.load(_part(values, "variables."))
            self._suspect = True
            if values["built"]:
                if self._built_from is None or self._built_from != self.parameters():
                    self.initialize()
                    self._built_from = self.parameters()
                    if saved.mode == _RUNNING:
                        self.start()
                    self._store.load(_part(values, "variables."))
                self.restore(_part(values, "model."))
            self._mode, self.time, self._stale = saved.mode, saved.time, False
            self._run_error, self._setup_error = saved.error, str(values["setup_error"])
            self._last_logged = ""
            self._publish_status()

        self._guarded(work)

    def _check_state(self, saved: Any) -> None:
        if not isinstance(saved, state.FmuState):
            raise StateError("this is not a state of a rail_fmi slave")
        if saved.refusal:
            raise StateError(saved.refusal)
        if saved.model_hash != self._identity.model_hash:
            raise StateError(
                f"the state was saved by another model or version ({saved.model_hash[:12]}) than "
                f"{self.modelName} ({self._identity.model_hash[:12]}); "
                "run the version that saved it"
            )
        if saved.variable_count != len(self.table):
            raise StateError(
                f"the state has {saved.variable_count} variables, the model {len(self.table)}"
            )

    @staticmethod
    def _fmu_state_to_bytes(saved: state.FmuState) -> bytes:  # type: ignore[override]
        try:
            return saved.serialized
        except BaseException as error:
            # Read back, such bytes are refused with this text.
            return f"the state could not be written: {error}".encode("utf-8", "replace")

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> state.FmuState:  # type: ignore[override]
        try:
            return state.from_bytes(data)
        except BaseException as error:
            return state.FmuState(model_hash="", variable_count=0, refusal=str(error))

    # Description

    def to_xml(self, model_options: Mapping[str, str] | None = None) -> Element:
        """Return the model description; capabilities are facts, so no option changes them."""
        names = ("description", "author", "version", "copyright", "license")
        about = ModelInformation(
            name=self.modelName or "",
            guid=self._identity.guid,
            date=self._identity.date,
            tool=self._identity.tool,
            attributes={name: str(value) for name in names if (value := self._attribute(name))},
            experiment=self._experiment(),
            log_categories=self.log_categories,
        )
        if self.held_error:
            raise RailFmiError(self.held_error)
        return model_description(self.table, about)

    def _attribute(self, name: str) -> Any:
        """Return an attribute of the class, or of the instance (pythonfmu allows both)."""
        return getattr(type(self), name, None) or getattr(self, name, None)

    def _experiment(self) -> dict[str, str]:
        experiment = self._attribute("default_experiment")
        names = {
            "startTime": "start_time",
            "stopTime": "stop_time",
            "tolerance": "tolerance",
            "stepSize": "step_size",
        }
        values = {tag: getattr(experiment, name, None) for tag, name in names.items()}
        return {tag: repr(float(value)) for tag, value in values.items() if value is not None}

    @property
    def identity(self) -> Identity:
        """Hash, GUID and date of the FMU that this instance belongs to."""
        return self._identity


def _part(values: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    return {
        name.removeprefix(prefix): value
        for name, value in values.items()
        if name.startswith(prefix)
    }
