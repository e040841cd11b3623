"""Entry script of SingleWheelset.fmu: a wheelset that carries a mass on a spring and a damper."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import numpy as np
from rail_fmi import RailSlave, Variable, parameter_variables
from rail_quantities import ParameterSet, flatten, quantity, with_values
from scipy.linalg import expm

GRAVITY = 9.81  # m/s2
W = "wheelset[1]."
MOTION = {
    "longitudinal_position": "m",
    "lateral_displacement": "m",
    "vertical_displacement": "m",
    "roll_angle": "rad",
    "yaw_angle": "rad",
    "longitudinal_velocity": "m/s",
    "lateral_velocity": "m/s",
    "vertical_velocity": "m/s",
    "roll_rate": "rad/s",
    "yaw_rate": "rad/s",
    "pitch_rate": "rad/s",
}
FORCES = {
    "longitudinal_force": "N",
    "lateral_force": "N",
    "vertical_force": "N",
    "roll_moment": "N.m",
    "pitch_moment": "N.m",
    "yaw_moment": "N.m",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wheelset(ParameterSet):
    """The wheelset."""

    GROUP = "wheelset"
    mass: float = quantity(1881.0, "kg", "Mass of the wheelset", above=0.0)
    radius: float = quantity(0.46, "m", "Rolling radius of the wheels", above=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sprung(ParameterSet):
    """What the wheelset carries."""

    GROUP = "sprung"
    mass: float = quantity(12229.0, "kg", "Mass that the wheelset carries", above=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Suspension(ParameterSet):
    """Spring and damper between the two."""

    GROUP = "suspension"
    vertical_stiffness: float = quantity(
        2.08e6, "N/m", "Stiffness of both springs together; 0 for a constant load", at_least=0.0
    )
    vertical_damping: float = quantity(40e3, "N.s/m", "Damping of both dampers", at_least=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Parameters(ParameterSet):
    """All parameters."""

    wheelset: Wheelset = Wheelset()
    sprung: Sprung = Sprung()
    suspension: Suspension = Suspension()
    speed: float = quantity(300.0 / 3.6, "m/s", "Running speed", above=0.0)
    initial_position: float = quantity(0.0, "m", "Position on the line at the start")


class SingleWheelset(RailSlave):
    """Runs on at its speed, straight and upright; only the vertical motion is free.

    Lateral, longitudinal and rolling forces and moments of the contact are taken by
    a guide. State: heights of wheelset and sprung mass about the datum and their
    rates, advanced exactly for a force that is linear over the step.
    """

    MODEL_NAME: ClassVar[str] = "SingleWheelset"
    description = "One wheelset under a sprung mass"

    def declare(self) -> list[Variable]:
        """Return the table of variables."""
        load = _wheel_load(Parameters())
        return [
            *(
                Variable(
                    f"{W}contact.{name}",
                    causality="input",
                    unit=unit,
                    start=-2.0 * load if name == "vertical_force" else 0.0,
                    description=f"Contact {name.replace('_', ' ')} on the wheelset",
                )
                for name, unit in FORCES.items()
            ),
            *parameter_variables(Parameters()),
            Variable(
                f"{W}initial_vertical_displacement",
                causality="parameter",
                unit="m",
                description="Height of the wheelset at the start, downwards from the datum",
            ),
            Variable(
                "coupling.input_time",
                kind="string",
                causality="parameter",
                choices=("step_start", "step_end"),
                description="Instant of the step that the contact forces stand for",
            ),
            Variable(
                "static_wheel_load",
                causality="calculatedParameter",
                unit="N",
                start=load,
                description="Load of one wheel at rest",
            ),
            *(
                Variable(
                    f"{W}{name}", causality="output", unit=unit, description=name.replace("_", " ")
                )
                for name, unit in MOTION.items()
            ),
            *(
                Variable(
                    f"axle_box[1].{side}.vertical_acceleration",
                    causality="output",
                    unit="m/s2",
                    description="Acceleration of the wheelset, downwards",
                )
                for side in ("left", "right")
            ),
        ]

    def initialize(self) -> None:
        """Start at rest on the spring, at the height given."""
        known = flatten(Parameters())
        p = with_values(Parameters(), {name: self.values[name] for name in known})
        self._speed, self._masses = p.speed, np.array([p.wheelset.mass, p.sprung.mass])
        self.values["static_wheel_load"] = _wheel_load(p)
        self._weight = 2.0 * _wheel_load(p)
        link = np.array([[1.0, -1.0], [-1.0, 1.0]]) / self._masses[:, None]
        self._system = np.zeros((6, 6))  # heights, rates, force and its slope
        self._system[0:2, 2:4] = np.eye(2)
        self._system[2:4, 0:2] = -p.suspension.vertical_stiffness * link
        self._system[2:4, 2:4] = -p.suspension.vertical_damping * link
        self._system[2, 4] = 1.0 / p.wheelset.mass
        self._system[4, 5] = 1.0
        self._size, self._advance = 0.0, np.eye(6)
        height = self.values[f"{W}initial_vertical_displacement"]
        self._state = np.array([height, height, 0.0, 0.0])
        self._way = p.initial_position
        self._last = self._surplus()
        self.values[f"{W}longitudinal_velocity"] = p.speed
        self.values[f"{W}pitch_rate"] = -p.speed / p.wheelset.radius
        self._publish(self._last)

    def step(self, time: float, step_size: float) -> None:
        """Advance by a step with the contact force linear in it."""
        force = self._surplus()
        start, end = force, 2.0 * force - self._last
        if self.values["coupling.input_time"] == "step_end":
            start, end = self._last, force
        self._last = force
        if step_size != self._size:
            self._size, self._advance = step_size, expm(self._system * step_size)
        full = np.concatenate([self._state, [start, (end - start) / step_size]])
        self._state = (self._advance @ full)[:4]
        self._way += self._speed * step_size
        self._publish(end)

    def _surplus(self) -> float:
        """Return the contact force beyond the weight, downwards, N."""
        return self.values[f"{W}contact.vertical_force"] + self._weight

    def _publish(self, force: float) -> None:
        full = np.concatenate([self._state, [force, 0.0]])
        acceleration = float(self._system[2] @ full)
        self.values[f"{W}longitudinal_position"] = self._way
        self.values[f"{W}vertical_displacement"] = float(self._state[0])
        self.values[f"{W}vertical_velocity"] = float(self._state[2])
        for side in ("left", "right"):
            self.values[f"axle_box[1].{side}.vertical_acceleration"] = acceleration

    def save(self) -> dict[str, Any]:
        """Return the state."""
        return {"state": self._state, "way": self._way, "last": self._last}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state back."""
        self._state = state["state"]
        self._way, self._last = float(state["way"]), float(state["last"])


def _wheel_load(parameters: Parameters) -> float:
    return 0.5 * GRAVITY * (parameters.wheelset.mass + parameters.sprung.mass)
