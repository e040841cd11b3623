"""The FMI 2.0 co-simulation slave from which both FMUs are made."""

import dataclasses
import math
import threading
from collections.abc import Collection, Mapping
from typing import Any, ClassVar
from xml.etree.ElementTree import Element

import numpy as np

from rail_fmi import state
from rail_fmi.description import ModelInformation, model_description, text
from rail_fmi.errors import RailFmiError, StateError, StepError
from rail_fmi.identity import Identity, read_identity
from rail_fmi.slave_values import Mode, ValueSlave
from rail_fmi.variables import KEEP_FIRST_INPUTS

TIME_TOLERANCE = 1e-3
"""How far a step may begin from where the last one ended, as a part of it: hosts round."""


class RailSlave(ValueSlave):
    """Base of the slaves: variables, checks, state and errors; no physics.

    Subclasses set :attr:`MODEL_NAME`, may set :attr:`PRESETS`, :attr:`GUIDE`,
    :attr:`EXPERIMENT` and pythonfmu's ``description``, ``author``, ``version``,
    ``license`` and ``copyright``, and write the hooks :meth:`declare`,
    :meth:`initialize`, :meth:`start`, :meth:`step`, :meth:`observe`,
    :meth:`initial_inputs`, :meth:`save` and :meth:`restore`. A hook may raise
    anything: the error is logged with its text and held, the host's call ends with
    a status of error, as does every step from then on, and outputs are not-a-number.

    Attributes
    ----------
    GUIDE
        Sections of the FMU's documentation, text by heading: what a user has to know.
    EXPERIMENT
        Attributes of ``DefaultExperiment``, in s.
    CHECKS_OUTPUTS
        True if :meth:`step` itself refuses results that are not finite.
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
    GUIDE: ClassVar[Mapping[str, str]] = {}
    EXPERIMENT: ClassVar[Mapping[str, float]] = {}
    CHECKS_OUTPUTS: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Put what a macro step calls into the class itself.

        pythonfmu looks a method up by a new string each time, so Python walks through all base
        classes each time.
        """
        super().__init_subclass__(**kwargs)
        for name in ("do_step", "get_real", "set_real", "get_integer", "get_string"):
            setattr(cls, name, getattr(cls, name))

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.time = 0.0
        self._checked = self.reals[: self._last_of("input", "parameter", "output") + 1]
        self._zeros = np.zeros(self._checked.size)
        self._built_from: tuple[Any, ...] | None = None
        self._first_inputs: np.ndarray | None = None
        self._identity = read_identity(self.resources, self.modelName, self.table.digest)
        self.guid = self._identity.guid

    def _last_of(self, *causalities: Any) -> int:
        """Return the last position in :attr:`reals` that has one of these causalities."""
        places = [
            self.table.reference(v.name)
            for v in self.table.with_causality(*causalities)
            if v.kind == "real"
        ]
        return max(places, default=-1)

    # Hooks of the subclass, besides ``declare``

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

    def observe(self) -> None:
        """Write the local reals; called when one is read, so unread ones cost nothing."""

    def initial_inputs(self) -> Mapping[str, Collection[str]]:
        """Return by output the inputs it depends on in initialization mode, whatever is set.

        For the model description; an output that is left out depends on all inputs.
        """
        return {}

    def save(self) -> dict[str, Any]:
        """Return the model's state beyond the variables: a flat dict of arrays and scalars."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Take back what :meth:`save` returned; the arrays are the slave's own copies."""

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
            self._mode, self._stale = Mode.INITIALIZING, True

        self._guarded(work)

    def exit_initialization_mode(self) -> None:
        """Build the model if need be, and get ready to step."""

        def work() -> None:
            if self._stale or self._mode != Mode.INITIALIZING:
                self._refresh()
            self._mode = Mode.RUNNING
            if not self.held_error:
                self.start()
            self._first_inputs = None
            if KEEP_FIRST_INPUTS.name in self.table and self.values[KEEP_FIRST_INPUTS.name]:
                self._first_inputs = self.reals[self._real_inputs()]

        self._guarded(work)
        if self.held_error:
            self._refuse()

    def _real_inputs(self) -> np.ndarray:
        inputs = self.table.with_causality("input")
        return self.indices([variable.name for variable in inputs if variable.kind == "real"])

    def _refresh(self) -> None:
        """Initialise the model with the present values; an error is held until they change."""
        self._stale, self._setup_error, self._built_from = False, "", None
        try:
            for variable in self.table.with_causality("parameter"):
                variable.check(self.values[variable.name])
            self._check_finite("input")
            self.initialize()
            self._built_from = self._store.parameter_key()
            self._check_finite("output", "calculatedParameter")
        except BaseException as error:
            self._hold(error, setup=True)
        self._publish_status()

    def _observe(self) -> None:
        if self._built_from is not None:
            self.observe()

    # Steps

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make one step; return whether it was made (a host gets a status of error if not)."""
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            if not (self._run_error or self._setup_error):
                self._make_step(current_time, step_size)
                return True
        except BaseException as error:
            self._hold(error)
        self._refuse()
        return False

    def _make_step(self, current_time: float, step_size: float) -> None:
        if self._mode != Mode.RUNNING:
            raise StepError(f"a step was asked for in mode {self._mode}; initialise first")
        if not 0.0 < step_size < math.inf:
            raise StepError(f"the step size must be positive and finite, not {step_size!r} s")
        if not abs(current_time - self.time) <= TIME_TOLERANCE * step_size + math.ulp(self.time):
            raise StepError(
                f"a step from t = {current_time!r} s was asked for, but the FMU is at "
                f"t = {self.time!r} s: go on from there, or set a state (fmi2SetFMUstate) first"
            )
        if self._first_inputs is not None:
            self.reals[self._real_inputs()] = self._first_inputs
            self._first_inputs = None
        if self._suspect:
            self._check_finite("input", "parameter")
            self._check_sizes()
            self._suspect = False
        self.step(current_time, step_size)
        if not self.CHECKS_OUTPUTS and self._zeros.dot(self._checked) != 0.0:
            self._check_finite("output")  # for the product is no number if one of them is not
        self.time = current_time + step_size

    def terminate(self) -> None:
        """End the run."""

        def work() -> None:
            self._mode = Mode.TERMINATED

        self._guarded(work)

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
            if self._first_inputs is not None:
                values["first_inputs"] = self._first_inputs
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
                if self._built_from != self._store.parameter_key():
                    self.initialize()
                    self._built_from = self._store.parameter_key()
                    if saved.mode == Mode.RUNNING:
                        self.start()
                    self._store.load(_part(values, "variables."))
                self.restore(_part(values, "model."))
            self._mode, self.time, self._stale = saved.mode, saved.time, False
            self._first_inputs = None
            if "first_inputs" in values:
                self._first_inputs = np.asarray(values["first_inputs"])
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
            experiment={tag: text(value) for tag, value in self.EXPERIMENT.items()},
            log_categories=self.log_categories,
            initial_inputs=self.initial_inputs(),
        )
        if self.held_error:
            raise RailFmiError(self.held_error)
        return model_description(self.table, about)

    def _attribute(self, name: str) -> Any:
        """Return an attribute of the class, or of the instance (pythonfmu allows both)."""
        return getattr(type(self), name, None) or getattr(self, name, None)

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
