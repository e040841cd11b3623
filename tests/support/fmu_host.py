"""A real FMI host for tests: fmpy, with the messages kept and statuses returned."""

import ctypes
import shutil
import tempfile
from typing import Any

import fmpy
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from fmpy.logging import addLoggerProxy

_log: dict[str, list[tuple[int, str]]] = {}


def _logged(_env: Any, name: bytes, status: int, _category: bytes, text: bytes) -> None:
    _log.setdefault(name.decode(), []).append((status, text.decode()))


def _callbacks() -> fmi2.fmi2CallbackFunctions:
    """Return callbacks; one set for all, because fmpy's proxy knows one logger only."""
    made = fmi2.fmi2CallbackFunctions()
    made.logger = fmi2.fmi2CallbackLoggerTYPE(_logged)
    made.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    made.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
    addLoggerProxy(ctypes.byref(made))
    return made


_shared_callbacks = _callbacks()


class Host:
    """One instance of an FMU, extracted and loaded anew."""

    def __init__(self, path: str, name: str = "one", *, logging: bool = True) -> None:
        self.folder = tempfile.mkdtemp(prefix="fmu_host_")
        self.about = fmpy.read_model_description(path)
        fmpy.extract(path, self.folder)
        self.vars = {v.name: v for v in self.about.modelVariables}
        self.log = _log.setdefault(name, [])
        self.fmu = fmi2.FMU2Slave(
            guid=self.about.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.about.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate(callbacks=_shared_callbacks, loggingOn=logging)
        self.time = 0.0

    def set(self, **values: Any) -> "Host":
        """Set variables by name; ``__`` stands for a dot."""
        for name, value in values.items():
            variable = self.vars[name.replace("__", ".")]
            getattr(self.fmu, f"set{variable.type}")([variable.valueReference], [value])
        return self

    def get(self, name: str) -> Any:
        variable = self.vars[name]
        value = getattr(self.fmu, f"get{variable.type}")([variable.valueReference])[0]
        return value.decode() if isinstance(value, bytes) else value

    def initialize(self, **values: Any) -> "Host":
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.set(**values)
        self.fmu.exitInitializationMode()
        return self

    def step(self, count: int = 1, size: float = 1e-3) -> int:
        """Make steps; return the status of the last one made."""
        for _ in range(count):
            try:
                status = self.fmu.doStep(self.time, size)
            except FMICallException as error:
                return error.status
            self.time += size
        return status

    def refusal(self, call: str, *arguments: Any, **values: Any) -> int:
        """Call a method that must fail; return the status that it fails with."""
        try:
            getattr(self, call, getattr(self.fmu, call, None))(*arguments, **values)
        except FMICallException as error:
            return error.status
        raise AssertionError(f"{call} did not fail")

    def outputs(self) -> tuple[Any, ...]:
        return tuple(self.get(v.name) for v in self.about.modelVariables if v.causality == "output")

    def texts(self, status: int = 3) -> list[str]:
        """Return the messages of one status (3 is error)."""
        return [text for number, text in self.log if number == status]

    def close(self) -> None:
        """End the run, and leave nothing behind."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)
