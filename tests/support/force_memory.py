"""The force history of the vehicle's compiled step, as an object."""

import math

import numpy as np
from rail_vehicle.coupling import ForceHistory
from rail_vehicle.kernels import alternates, force_curve
from rail_vehicle.step_limits import LARGEST_EXTRAPOLATION_ERROR


class ForceMemory:
    """Takes in contact forces (24,) and gives those over a step, as the step does.

    Parameters
    ----------
    history
        What it starts with.
    unit
        What counts as a large force or moment, N and N.m, six numbers.
    """

    def __init__(self, history: ForceHistory, unit=(math.inf,) * 6):
        self._packed, self._curve = history.packed(), np.zeros((3, 24))
        self._unit = np.tile(np.array(unit, dtype=float), 4)

    @property
    def history(self) -> ForceHistory:
        return ForceHistory.of_packed(self._packed)

    @property
    def extrapolation_errors(self) -> tuple[float, float]:
        return self.history.extrapolation_errors

    @property
    def alternates(self) -> bool:
        return bool(alternates(self._packed, LARGEST_EXTRAPOLATION_ERROR))

    def take(self, forces, elapsed, step, order, *, at_end):
        newest = np.ascontiguousarray(forces, dtype=float).ravel()
        force_curve(
            self._packed,
            newest,
            float(elapsed),
            float(step),
            order,
            at_end,
            self._unit,
            self._curve,
        )
        return self._curve
