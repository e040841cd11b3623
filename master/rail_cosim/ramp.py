"""A run at growing or falling speed: the vehicle's speed setpoint over time."""

from __future__ import annotations

import math

from rail_cosim.errors import ParameterError
from rail_cosim.initialisation import SPEED_SETPOINT
from rail_cosim.slave import Slave

OPTION = "--final-speed"
LIMIT = "speed_constraint.acceleration_limit"
_KM_H = 3.6


class SpeedRamp:
    """Uniform acceleration from one speed to another over a distance.

    ``v^2 = v0^2 + 2 a s``; the setpoint of a step is the speed at its end, so that a vehicle
    which follows it at once accelerates by ``a`` in every step.

    Parameters
    ----------
    vehicle
        Initialised slave with the input ``speed_setpoint``.
    start, end
        Speeds in m/s.
    distance
        In m.

    Attributes
    ----------
    acceleration
        In m/s2, negative for braking.
    duration
        In s.

    Raises
    ------
    ParameterError
        If the vehicle has no such input, or does not accelerate so fast.
    """

    def __init__(self, vehicle: Slave, *, start: float, end: float, distance: float) -> None:
        self._start, self._end = start, end
        self.acceleration = 0.5 * (end**2 - start**2) / distance
        self.duration = 2.0 * distance / (start + end)
        if SPEED_SETPOINT not in vehicle.variables:
            limit = f"the vehicle FMU has no input {SPEED_SETPOINT}"
            raise ParameterError(OPTION, end * _KM_H, limit, "its speed cannot be varied")
        if LIMIT in vehicle.variables:
            limit = float(vehicle.get([LIMIT])[LIMIT])
            if abs(self.acceleration) > limit:
                raise ParameterError(
                    OPTION,
                    end * _KM_H,
                    f"needs {abs(self.acceleration):.3g} m/s2, more than vehicle.{LIMIT} = "
                    f"{limit:g} m/s2",
                    "take a longer --distance",
                )
        self._input = vehicle.vector([SPEED_SETPOINT])

    def speed(self, time: float) -> float:
        """Return the speed (m/s) at ``time`` (s)."""
        return self._start + self.acceleration * min(time, self.duration)

    def step_count(self, step_size: float) -> int:
        """Return the number of steps to the end of the distance."""
        return max(1, math.ceil(self.duration / step_size * (1.0 - 1e-12)))

    def apply(self, time: float, step_size: float) -> None:
        """Set the vehicle's setpoint for the step from ``time`` by ``step_size`` seconds."""
        self._input.values[0] = self.speed(time + step_size)
        self._input.write()
