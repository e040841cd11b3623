"""Entry script of MiniVehicle.fmu: one wheel that runs along and moves up and down."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import numpy as np
from rail_fmi import RailSlave, Variable, parameter_variables
from rail_quantities import ParameterSet, flatten, quantity, with_values

W = "wheelset[1]."


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wheel(ParameterSet):
    GROUP = "wheel"
    mass: float = quantity(900.0, "kg", "mass of the wheel", above=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Parameters(ParameterSet):
    wheel: Wheel = Wheel()
    speed: float = quantity(300.0 / 3.6, "m/s", "running speed", above=0.0)


class MiniVehicle(RailSlave):
    """A wheel under a constant load."""

    MODEL_NAME: ClassVar[str] = "MiniVehicle"
    PRESETS: ClassVar[dict[str, Any]] = {
        "paper": {"wheel.mass": 900.0},
        "heavy": {"wheel.mass": 1800.0},
    }

    def declare(self) -> list[Variable]:
        """Return the table of variables."""
        outputs = (
            (f"{W}longitudinal_position", "m"),
            (f"{W}vertical_displacement", "m"),
            (f"{W}longitudinal_velocity", "m/s"),
            (f"{W}vertical_velocity", "m/s"),
            ("axle_box[1].left.vertical_acceleration", "m/s2"),
        )
        return [
            *parameter_variables(Parameters()),
            Variable(f"{W}initial_vertical_displacement", causality="parameter", unit="m"),
            Variable(
                "coupling.input_time",
                kind="string",
                causality="parameter",
                choices=("step_start", "step_end"),
            ),
            Variable("static_wheel_load", causality="calculatedParameter", unit="N"),
            Variable(f"{W}contact.vertical_force", causality="input", unit="N"),
            *(
                Variable(name, causality="output", unit=unit, description=name)
                for name, unit in outputs
            ),
        ]

    def initialize(self) -> None:
        """Start at the given height."""
        with_values(Parameters(), {name: self.values[name] for name in flatten(Parameters())})
        self.load = 9.81 * 77.0 * self.values["wheel.mass"] / 9.81
        self.values["static_wheel_load"] = self.load
        self.z = np.array([self.values[f"{W}initial_vertical_displacement"], 0.0])
        self.old = self.values[f"{W}contact.vertical_force"]
        self.publish(0.0, 0.0)

    def start(self) -> None:
        """Warn of a light wheel."""
        if self.values["wheel.mass"] < 100.0:
            self.warn("the wheel is light, 50 % of it is air")

    def publish(self, position: float, acceleration: float) -> None:
        """Set all outputs."""
        self.values[f"{W}longitudinal_position"] = position
        self.values[f"{W}longitudinal_velocity"] = self.values["speed"]
        self.values[f"{W}vertical_displacement"] = float(self.z[0])
        self.values[f"{W}vertical_velocity"] = float(self.z[1])
        self.values["axle_box[1].left.vertical_acceleration"] = acceleration

    def step(self, time: float, step_size: float) -> None:
        """Integrate with the force linear over the step."""
        force, h, m = (
            self.values[f"{W}contact.vertical_force"],
            step_size,
            self.values["wheel.mass"],
        )
        start, end = force, 2.0 * force - self.old
        if self.values["coupling.input_time"] == "step_end":
            start, end = self.old, force
        self.old = force
        a, b = (start + self.load) / m, (end + self.load) / m
        self.z = np.array(
            [self.z[0] + h * self.z[1] + h * h * (a / 3.0 + b / 6.0), self.z[1] + h * (a + b) / 2.0]
        )
        self.publish(self.values["speed"] * (time + step_size), b)

    def save(self) -> dict[str, Any]:
        """Return the state."""
        return {"z": self.z, "old": self.old, "load": self.load}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state back."""
        self.z, self.old, self.load = state["z"], state["old"], state["load"]
