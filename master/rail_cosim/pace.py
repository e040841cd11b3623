"""How fast a run is, and how many macro steps it takes."""

from __future__ import annotations

import math
from collections.abc import Mapping

from rail_cosim.description import FmuDescription
from rail_cosim.errors import ParameterError
from rail_cosim.initialisation import SPEED
from rail_cosim.options import KM_H, RunOptions
from rail_cosim.slave import Slave, Value
from rail_cosim.system import SystemStructure

_LEADING_SPEED = "wheelset[1].longitudinal_velocity"


def planned_time(
    options: RunOptions,
    parameters: Mapping[str, Mapping[str, Value]],
    vehicle: FmuDescription,
) -> float:
    """Return the planned end of the run as far as it is known before initialisation."""
    default = vehicle.variables[SPEED].start if SPEED in vehicle.variables else None
    speed = float(parameters["vehicle"].get(SPEED, default or 0.0))
    if options.final_speed is not None:
        speed = 0.5 * (speed + options.final_speed * KM_H)
    count = step_count(options.distance, speed, options.macro_step) if speed > 0.0 else 1
    return count * options.macro_step


def running_speed(system: SystemStructure) -> float:
    """Return the speed (m/s) of the initialised vehicle.

    Raises
    ------
    ParameterError
        If it stands still or runs backwards: then no distance is ever covered.
    """
    outputs = system.port("vehicle").outputs
    if _LEADING_SPEED in outputs.names:
        speed = float(outputs.values[outputs.names.index(_LEADING_SPEED)])
    else:
        speed = _parameter(system["vehicle"], SPEED)
    if not speed > 0.0:
        raise ParameterError("vehicle.speed", speed, "must be greater than 0 m/s")
    return speed


def _parameter(slave: Slave, name: str) -> float:
    if name not in slave.variables:
        raise ParameterError(
            f"{slave.name}.{name}",
            None,
            f"the FMU has neither this parameter nor the output {_LEADING_SPEED}",
            "so it is not known how many steps the distance takes; give the FMU one of them",
        )
    return float(slave.get([name])[name])


def step_count(distance: float, speed: float, step_size: float) -> int:
    """Return the number of steps in which ``distance`` (m) is covered, at least 1."""
    return max(1, math.ceil(distance / (speed * step_size) * (1.0 - 1e-12)))
