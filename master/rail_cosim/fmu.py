"""Slaves that are FMI 2.0 co-simulation FMUs. The only file that uses fmpy.

fmpy loads the library and makes the rare calls. The calls of every macro step
go straight to the C functions with preallocated arrays, since fmpy's list
interface costs some five times the call itself. Every status is checked.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, cast

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException, printLogMessage
from fmpy.fmi2 import (
    FMU2Slave,
    defaultCallbacks,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from rail_cosim.description import FmuDescription, read_description
from rail_cosim.errors import FmuFileError, RefusalError, SlaveError, StructureError
from rail_cosim.extraction import extract
from rail_cosim.fmu_log import Log, deliver
from rail_cosim.slave import Message, Renaming, Status, Value, Variable

_VECTOR_CALL = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p
)
_STEP_CALL = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
)
_GETTERS = {
    "real": "getReal",
    "integer": "getInteger",
    "enumeration": "getInteger",
    "boolean": "getBoolean",
    "string": "getString",
}
_WORST_USABLE = Status.WARNING
_BUFFER = {"real": np.float64, "integer": np.int32}
HELD_ERROR = "status.message"
_SAME = Renaming(name="", own="")


def _receive(number: Any, instance: bytes, status: int, category: bytes, text: bytes) -> None:
    if not deliver(number, status, text):
        printLogMessage(number, instance, status, category, text or b"")


# One function for all instances: fmpy's proxy, which fills in the arguments of
# the FMU's format strings, knows a single receiver per process.
_RECEIVER = fmi2CallbackLoggerTYPE(_receive)


def _callbacks(log: Log) -> fmi2CallbackFunctions:
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = _RECEIVER
    callbacks.allocateMemory = defaultCallbacks.allocateMemory
    callbacks.freeMemory = defaultCallbacks.freeMemory
    callbacks.componentEnvironment = log.number
    addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


class FmuVector:
    """Variables of an :class:`FmuSlave` (see :class:`rail_cosim.slave.Vector`)."""

    def __init__(self, slave: FmuSlave, names: Sequence[str], kind: str) -> None:
        self.names = tuple(names)
        self.values = np.zeros(len(self.names), dtype=_BUFFER[kind])
        self._slave = slave
        references = [slave.variables[name].reference for name in self.names]
        self._references = np.array(references, dtype=np.uint32)  # keeps the memory alive
        self._reference_pointer = ctypes.c_void_p(self._references.ctypes.data)
        renamings = [slave.variables[name].renaming or _SAME for name in self.names]
        self._raw = np.zeros(len(self.names)) if any(r.scales for r in renamings) else None
        self._factors = np.array([r.factor for r in renamings])
        self._offsets = np.array([r.offset for r in renamings])
        self.place(self.values)
        word = kind.capitalize()
        self._getter, self._setter = f"fmi2Get{word}", f"fmi2Set{word}"
        self._get, self._set = (slave.vector_call(f) for f in (self._getter, self._setter))
        self._count = len(self.names)

    def place(self, buffer: NDArray) -> None:
        """Take this array, of the same shape and type, as the buffer."""
        self.values = buffer
        exchanged = buffer if self._raw is None else self._raw
        self._value_pointer = ctypes.c_void_p(exchanged.ctypes.data)

    def addresses(self) -> tuple[int, int, int, int]:
        """Return where getter, setter, value references and buffer are in memory."""
        functions = (ctypes.cast(f, ctypes.c_void_p).value or 0 for f in (self._get, self._set))
        getter, setter = functions
        return getter, setter, self._references.ctypes.data, self.values.ctypes.data

    def read(self, count: int | None = None) -> None:
        """Copy values from the FMU into the buffer."""
        number = self._count if count is None else count
        if number == 0:
            return
        status = self._get(
            self._slave.component, self._reference_pointer, number, self._value_pointer
        )
        if status > _WORST_USABLE:
            self._slave.fail(self._getter, status)
        if self._raw is not None:
            scaled = self._factors[:number] * self._raw[:number] + self._offsets[:number]
            self.values[:number] = scaled

    def write(self) -> None:
        """Copy the buffer into the FMU."""
        if self._count == 0:
            return
        if self._raw is not None:
            self._raw[:] = (self.values - self._offsets) / self._factors
        status = self._set(
            self._slave.component, self._reference_pointer, self._count, self._value_pointer
        )
        if status > _WORST_USABLE:
            self._slave.fail(self._setter, status)


class FmuSlave:
    """One instance of an FMU (see :class:`rail_cosim.slave.Slave`).

    A context manager: the instance is terminated and released exactly once on
    leaving, whatever happened.

    Parameters
    ----------
    path
        The FMU file.
    name
        Instance name; messages begin with it.

    Attributes
    ----------
    time
        Start of the last step in s; ``None`` before the first.
    rolls_back
        Whether a state was ever saved: then steps may have to be taken back.

    Raises
    ------
    FmuFileError
        If the file is no FMI 2.0 co-simulation FMU for this platform.
    SlaveError
        If it cannot be instantiated.
    """

    def __init__(self, path: Path, name: str, *, description: FmuDescription | None = None) -> None:
        self.name = name
        self.description = description or read_description(path)
        self.component: ctypes.c_void_p | None = None
        self._log = Log()
        self.time: float | None = None
        self.rolls_back = False
        self._usable, self._may_free = True, True
        self._fmu = self._load(extract(path, self.description.guid))
        self._instantiate()

    def _load(self, directory: Path) -> FMU2Slave:
        here = os.getcwd()
        try:
            return FMU2Slave(
                guid=self.description.guid,
                unzipDirectory=str(directory),
                modelIdentifier=self.description.identifier,
                instanceName=self.name,
            )
        except Exception as error:  # fmpy raises nothing more exact
            binaries = directory / "binaries"
            there = sorted(p.name for p in binaries.iterdir()) if binaries.is_dir() else []
            raise FmuFileError(
                f"{self.description.path}: its library cannot be loaded on this platform "
                f"({fmpy.platform}; the FMU has {', '.join(there) or 'no binaries'}): {error}"
            ) from error
        finally:
            os.chdir(here)  # fmpy leaves the directory changed when loading fails

    def _instantiate(self) -> None:
        try:
            self._fmu.instantiate(callbacks=_callbacks(self._log), loggingOn=True)
        except Exception as error:  # fmpy raises nothing more exact
            self._log.close()
            raise SlaveError(
                self.name, "fmi2Instantiate", Status.ERROR, self._log.problems()
            ) from error
        self.component = ctypes.c_void_p(cast(int, self._fmu.component))
        self._do_step = _STEP_CALL(("fmi2DoStep", self._fmu.dll))

    def addresses(self) -> tuple[int, int]:
        """Return where the instance and its ``fmi2DoStep`` are in memory."""
        step = ctypes.cast(self._do_step, ctypes.c_void_p).value
        return (self.component.value or 0 if self.component else 0), step or 0

    def address(self, name: str) -> int:
        """Return where a C function that gets or sets variables is in memory."""
        return ctypes.cast(self.vector_call(name), ctypes.c_void_p).value or 0

    def vector_call(self, name: str) -> Any:
        """Return the C function that gets or sets variables of one kind."""
        return _VECTOR_CALL((name, self._fmu.dll))

    @property
    def variables(self) -> Mapping[str, Variable]:
        """All variables by name."""
        return self.description.variables

    @property
    def scales(self) -> bool:
        """Whether values are converted on their way to or from the FMU."""
        return any(variable.scaled for variable in self.variables.values())

    def vector(self, names: Sequence[str], kind: Literal["real", "integer"] = "real") -> FmuVector:
        """Return a vector of variables, all of one kind."""
        return FmuVector(self, names, kind)

    def get(self, names: Sequence[str]) -> dict[str, Value]:
        """Return values of any kind by name (slow)."""
        found: dict[str, Value] = {}
        for kind, getter in _GETTERS.items():
            chosen = [name for name in names if self.variables[name].kind == kind]
            if chosen:
                values = self._call(getter, [self.variables[name].reference for name in chosen])
                found.update(zip(chosen, map(_python_value(kind), values), strict=True))
        for name in found:
            if (renaming := self.variables[name].renaming) is not None and renaming.scales:
                found[name] = renaming.to_contract(found[name])
        return {name: found[name] for name in names}

    def set(self, values: Mapping[str, Value]) -> None:
        """Set values of any kind by name (slow)."""
        for name, value in values.items():
            variable = self.variables[name]
            setter = _GETTERS[variable.kind].replace("get", "set")
            if variable.renaming is not None and variable.renaming.scales:
                value = variable.renaming.to_own(value)
            self._call(setter, [variable.reference], [value])

    def setup(self, start_time: float, stop_time: float) -> None:
        """Announce the span of time."""
        self._call("setupExperiment", None, start_time, stop_time)

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self._call("enterInitializationMode")
        self._check_held_error("fmi2EnterInitializationMode")

    def exit_initialization(self) -> None:
        """Leave initialization mode."""
        self._check_held_error("fmi2ExitInitializationMode")  # before it comes as fmi2Fatal
        self._call("exitInitializationMode")

    def do_step(self, time: float, step_size: float) -> None:
        """Advance from ``time`` by ``step_size`` seconds."""
        self.time = time
        status = self._do_step(self.component, time, step_size, not self.rolls_back)
        if status != Status.OK and status != Status.WARNING:
            self.fail("fmi2DoStep", status)

    def save_state(self) -> ctypes.c_void_p:
        """Return a handle to a copy of the complete state."""
        if not self.description.can_save_state:
            raise StructureError(
                f"{self.name}: {self.description.path.name} cannot save its state, which this "
                "algorithm needs; take gauss-seidel or jacobi"
            )
        self.rolls_back = True
        return self._call("getFMUstate")

    def restore_state(self, state: ctypes.c_void_p) -> None:
        """Go back to a saved state."""
        self._call("setFMUstate", state)

    def free_state(self, state: ctypes.c_void_p) -> None:
        """Release a handle of :meth:`save_state`."""
        self._call("freeFMUstate", state)

    def state_bytes(self) -> bytes:
        """Return a copy of the complete state, written out in full."""
        state = self.save_state()
        try:
            return bytes(self._call("serializeFMUstate", state))
        finally:
            self.free_state(state)

    def restore_bytes(self, data: bytes) -> None:
        """Go back to a state that :meth:`state_bytes` wrote, perhaps in another process."""
        state = self._call("deSerializeFMUstate", data)
        self.restore_state(state)
        self._check_held_error("fmi2SetFMUstate")
        self.free_state(state)

    def take_warnings(self) -> list[str]:
        """Return warnings that were not returned before."""
        return self._log.take_warnings()

    def _call(self, name: str, *arguments: Any) -> Any:
        try:
            return getattr(self._fmu, name)(*arguments)
        except FMICallException as error:
            self.fail(error.function, error.status, error)

    def _check_held_error(self, call: str) -> None:
        """Raise what a slave made with ``rail_fmi`` would refuse with ``fmi2Fatal``."""
        variable = self.variables.get(HELD_ERROR)
        if (
            variable is not None
            and variable.kind == "string"
            and self.get([HELD_ERROR])[HELD_ERROR]
        ):
            self.fail(call, Status.DISCARD)

    def fail(self, call: str, status: int, cause: Exception | None = None) -> None:
        """Raise the error for a status that ends the run, with what the FMU said."""
        known = Status(status) if status in list(Status) else Status.FATAL
        self._usable = known not in (Status.ERROR, Status.FATAL)
        # What was made with rail_fmi has no other status for an error of one instance.
        self._may_free = known is not Status.FATAL or HELD_ERROR in self.variables
        said = self._log.problems()
        refused = self.time is None and self._names_parameter(said)
        kind = RefusalError if refused else SlaveError
        raise kind(self.name, call, known, said, self.time) from cause

    def _names_parameter(self, messages: Sequence[Message]) -> bool:
        """Whether the FMU says which of its parameters it does not like."""
        words = {word for m in messages for word in re.findall(r"[\w.\[\]]*\w", m.text)}
        return any(
            v.causality == "parameter" and (v.renaming.own if v.renaming else v.name) in words
            for v in self.variables.values()
        )

    def close(self) -> None:
        """Terminate and release the instance; does nothing the second time.

        After an error FMI allows the release only, and after a fatal one
        nothing: the instance is then left to the end of the process.
        """
        if self.component is None:
            return
        self.component = None
        if self._usable:
            try:
                self._fmu.terminate()
            except FMICallException as error:
                self._may_free = error.status != Status.FATAL
        if self._may_free:
            self._fmu.freeInstance()
            self._log.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


def _python_value(kind: str) -> Any:
    if kind == "string":
        return lambda value: value.decode("utf-8") if isinstance(value, bytes) else value or ""
    return {"real": float, "boolean": bool}.get(kind, int)
