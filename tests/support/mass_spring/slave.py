"""The test slave: a mass on a spring and a damper, with errors on demand."""

import dataclasses
import math
import threading
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from rail_fmi import KEEP_FIRST_INPUTS, RailSlave, StepError, Variable, parameter_variables
from rail_quantities import ParameterError, ParameterSet, quantity, with_values


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spring(ParameterSet):
    GROUP = "spring"
    stiffness: float = quantity(1.0e4, "N/m", "Stiffness of the spring", above=0.0)
    damping: float = quantity(10.0, "N.s/m", "Damping beside the spring", at_least=0.0)
    law: str = quantity("linear", description="Force law", choices=("linear", "cubic"))
    hertz_constant: float = quantity(1.0e-7, "m/N^(2/3)", "A unit without integer exponents")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Parameters(ParameterSet):
    mass: float = quantity(100.0, "kg", "Mass", above=0.0, below=1.0e6)
    substeps: int = quantity(4, "1", "Internal steps in one step", at_least=1, at_most=1000)
    gravity: bool = quantity(False, description="Whether weight acts")
    spring: Spring = Spring()


class MassSpringSlave(RailSlave):
    """One mass, m z'' + c z' + f(z) = F + m g."""

    MODEL_NAME = "MassSpring"
    PRESETS: ClassVar = {
        "heavy": {"mass": 500.0, "spring.law": "cubic", "spring.hertz_constant": 2.0e-7}
    }
    description = "A mass on a spring, for the tests of rail_fmi."
    version = "1.0"
    GUIDE: ClassVar = {"Masses": "What if the spring is stiff? Then steps are short."}
    EXPERIMENT: ClassVar = {"startTime": 0.0, "stepSize": 1e-3}

    def declare(self) -> Sequence[Variable]:
        self.info("declared 100 %")
        self.local = threading.local()  # lives as long as the thread's Python state
        self.history = np.zeros(0)
        return [
            Variable("force", causality="input", unit="N", nominal=1.0e3, description="Force"),
            Variable("error", kind="string", causality="input", description="Error on demand"),
            *parameter_variables(Parameters()),
            KEEP_FIRST_INPUTS,
            Variable("omega", causality="calculatedParameter", unit="rad/s"),
            Variable("position", causality="output", unit="m", description="Deflection"),
            Variable("velocity", causality="output", unit="m/s"),
            Variable("steps", kind="integer", causality="output"),
            Variable("moving", kind="boolean", causality="output"),
            Variable("say", kind="string", causality="output"),
        ]

    def initialize(self) -> None:
        if self.values["error"] == "initialize":
            raise RuntimeError("cannot set up, 100 % sure %s %n")
        own = {n: v for n, v in self.parameters().items() if n != KEEP_FIRST_INPUTS.name}
        self.model = with_values(Parameters(), own)
        if self.model.mass > 1000.0 and self.model.spring.law == "cubic":
            raise ParameterError("mass", self.model.mass, "too heavy for the cubic law", "5 % less")
        self.values["omega"] = math.sqrt(self.model.spring.stiffness / self.model.mass)
        self.values["position"] = self.values["force"] / self.model.spring.stiffness
        self.z = np.array([self.values["position"], 0.0])
        self.out = self.slice_of("position", "velocity")
        self.history = np.zeros(0)

    def start(self) -> None:
        self.info("started at 100 %")

    def step(self, time: float, step_size: float) -> None:
        if not hasattr(self.local, "known"):
            self.local.known = True
            self.info("first step of a thread state")
        self._demanded(self.values["error"])
        h = step_size / self.model.substeps
        k, c, m = self.model.spring.stiffness, self.model.spring.damping, self.model.mass
        for _ in range(self.model.substeps):
            stretch = self.z[0] if self.model.spring.law == "linear" else self.z[0] ** 3
            weight = 9.81 * m if self.model.gravity else 0.0
            self.z[1] += h * (self.values["force"] + weight - k * stretch - c * self.z[1]) / m
            self.z[0] += h * self.z[1]
        self.history = np.append(self.history, self.z[0])[-50:]
        self.reals[self.out] = self.z
        self.values["steps"] += 1
        self.values["moving"] = abs(self.z[1]) > 0.0
        self.values["say"] = f"mean {self.history.mean():.3e} m, \u00fcber"

    def _demanded(self, error: str) -> None:
        if error == "step":
            raise StepError("the wheel left the window;\nmove it 10 % back")
        if error == "bug":
            raise ZeroDivisionError("%s%n 50 %")
        if error == "exit":
            raise SystemExit("enough")
        if error == "nan":
            self.reals[self.slice_of("velocity")] = math.nan
            self.z[:] = math.nan
        if error == "talk":
            self.warn("100 %\n%s %n \udcff\0" + "long " * 5000)

    def save(self) -> dict[str, Any]:
        return {"z": self.z, "history": self.history}

    def restore(self, state: dict[str, Any]) -> None:
        self.z, self.history = state["z"], state["history"]
