"""Entry script of MiniTrack.fmu: a rail without mass that is softer between the sleepers."""

from __future__ import annotations

import dataclasses
import math
import os
import signal
from typing import Any, ClassVar

from rail_fmi import RailSlave, StepError, Variable, parameter_variables
from rail_quantities import ParameterSet, quantity

W = "wheelset[1]."


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fastener(ParameterSet):
    GROUP = "fastener"
    vertical_stiffness: float = quantity(8e7, "N/m", "stiffness of the support", above=0.0)
    vertical_damping: float = quantity(8e4, "N.s/m", "damping of the support", at_least=0.0)
    spacing: float = quantity(0.629, "m", "distance of two fasteners", above=0.0)
    count_per_slab: int = quantity(8, "1", "fasteners of a slab, in a row", at_least=1)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Parameters(ParameterSet):
    fastener: Fastener = Fastener()
    fails_after: float = quantity(0.0, "s", "time of a failure; 0 for never", at_least=0.0)
    diverges_after: float = quantity(0.0, "s", "time of a huge force; 0 for never", at_least=0.0)
    interrupted_after: float = quantity(0.0, "s", "time of a Ctrl-C; 0 for never", at_least=0.0)


class MiniTrack(RailSlave):
    """A spring and a damper under the wheel."""

    MODEL_NAME: ClassVar[str] = "MiniTrack"
    PRESETS: ClassVar[dict[str, Any]] = {
        "HD": {"fastener.spacing": 0.629, "fastener.count_per_slab": 8},
        "ZX": {"fastener.spacing": 0.63, "fastener.count_per_slab": 9},
    }

    def declare(self) -> list[Variable]:
        """Return the table of variables."""
        motions = (
            (f"{W}longitudinal_position", "m"),
            (f"{W}vertical_displacement", "m"),
            (f"{W}longitudinal_velocity", "m/s"),
            (f"{W}vertical_velocity", "m/s"),
        )
        outputs = (f"{W}contact.vertical_force", f"{W}left.normal_force", f"{W}right.normal_force")
        return [
            *parameter_variables(Parameters()),
            Variable("static_wheel_load", causality="parameter", unit="N", start=1.0, minimum=0.0),
            Variable(
                "coupling.input_time",
                kind="string",
                causality="parameter",
                choices=("step_start", "step_end"),
            ),
            *(Variable(name, causality="input", unit=unit) for name, unit in motions),
            Variable("rail_head[1].left.vertical_force", causality="input", unit="N"),
            *(Variable(name, causality="output", unit="N", description=name) for name in outputs),
            Variable(f"{W}static_vertical_displacement", causality="output", unit="m"),
        ]

    def initialize(self) -> None:
        """Find the static height, and the force at the given one."""
        load = self.values["static_wheel_load"]
        if load > 1e6:
            raise StepError(f"static_wheel_load = {load:g} N: the rail breaks at 1e6 N, 100 %")
        stiffness = self.stiffness(self.values[f"{W}longitudinal_position"])
        self.values[f"{W}static_vertical_displacement"] = load / stiffness
        self.publish(0.0)

    def stiffness(self, position: float) -> float:
        """Return the stiffness at a place: 2 % less between two fasteners."""
        phase = 2.0 * math.pi * position / self.values["fastener.spacing"]
        return self.values["fastener.vertical_stiffness"] * (0.99 + 0.01 * math.cos(phase))

    def publish(self, ahead: float) -> None:
        """Set the forces for the motion extrapolated by ``ahead`` seconds."""
        v = self.values
        position = v[f"{W}longitudinal_position"] + ahead * v[f"{W}longitudinal_velocity"]
        height = v[f"{W}vertical_displacement"] + ahead * v[f"{W}vertical_velocity"]
        damping = v["fastener.vertical_damping"] * v[f"{W}vertical_velocity"]
        force = max(0.0, self.stiffness(position) * height + damping)
        v[f"{W}contact.vertical_force"] = -force
        v[f"{W}left.normal_force"] = v[f"{W}right.normal_force"] = 0.5 * force

    def step(self, time: float, step_size: float) -> None:
        """Evaluate the force, or fail as asked for."""
        end = time + step_size
        if 0.0 < self.values["fails_after"] <= end:
            raise StepError("the rail is broken, 100 %;\nweld it")
        if 0.0 < self.values["interrupted_after"] <= end:
            self.values["interrupted_after"] = 0.0
            os.kill(os.getpid(), signal.SIGINT)
        at_end = self.values["coupling.input_time"] == "step_end"
        self.publish(0.0 if at_end else step_size)
        if 0.0 < self.values["diverges_after"] <= end:
            self.values[f"{W}contact.vertical_force"] = 1e30

    def save(self) -> dict[str, Any]:
        """Return the state: there is none beside the variables."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state back."""
