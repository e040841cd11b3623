"""Contact forces over a communication step, from values at communication points.

A co-simulation master hands over one value per step. It stands for the start
of the step (the step's forces are then extrapolated) or for its end (they are
interpolated). Both use the polynomial through up to three values at unequal
times; over a step it is written as
``start + (end - start) s + quadratic s (s - 1)``, as ``VehicleModel.step`` takes it.
"""

import dataclasses
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rail_vehicle.kernels import HISTORY_COUNT, PARABOLA_ERROR

Array = NDArray[np.float64]

INPUT_TIMES = ("step_start", "step_end")


class ForcePolynomial(NamedTuple):
    """Forces over a step: values at both ends and quadratic part, each (wheelsets, 6)."""

    start: Array
    end: Array
    quadratic: Array


@dataclasses.dataclass(frozen=True)
class ForceHistory:
    """The last three communicated values, newest first.

    Attributes
    ----------
    ages
        How long before the newest value each was valid, s, shape (n,), n <= 3,
        increasing from 0.
    forces
        The values, shape (n, 4, 6), N and N.m.
    extrapolation_errors
        How far values are from parabola and straight line through those before each of them: root
        mean square over the wheelsets in parts of a large force, at most 1 for the parabola in a
        step; averaged over some :data:`rail_vehicle.kernels.AVERAGING_STEPS` steps. Forces that are
        followed are near 0, those that turn from step to step near 1.
    """

    ages: Array
    forces: Array
    extrapolation_errors: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def begin(cls, forces: Array) -> Self:
        """Start with one value: ``forces``, shape (4, 6), N and N.m."""
        return cls(np.zeros(1), np.array(forces, dtype=float)[None])

    def append(self, forces: Array, elapsed: float) -> Self:
        """Return the history with a value ``elapsed`` s after the newest.

        ``forces`` has shape (4, 6), N and N.m. With ``elapsed`` 0 the newest value is
        replaced: at a communication point only the last value counts.
        """
        newest = np.array(forces, dtype=float)[None]
        if elapsed <= 0.0:
            return type(self)(self.ages, np.concatenate([newest, self.forces[1:]]))
        ages = np.concatenate([[0.0], self.ages + elapsed])
        return type(self)(ages[:3], np.concatenate([newest, self.forces])[:3])

    def packed(self) -> Array:
        """Return it as :func:`rail_vehicle.kernels.append_force` takes it, (HISTORY_COUNT,)."""
        count, packed = self.ages.size, np.zeros(HISTORY_COUNT)
        packed[0], packed[1 : 1 + count] = count, self.ages
        packed[4 : 4 + self.forces.size] = self.forces.ravel()
        packed[PARABOLA_ERROR:] = self.extrapolation_errors
        return packed

    @classmethod
    def of_packed(cls, packed: Array) -> Self:
        """Return the history of what :meth:`packed` gave: ``packed`` (HISTORY_COUNT,), s and N."""
        count = int(packed[0])
        forces = packed[4:PARABOLA_ERROR].reshape(3, -1, 6)
        parabola, line = (float(error) for error in packed[PARABOLA_ERROR:])
        return cls(packed[1 : 1 + count].copy(), forces[:count].copy(), (parabola, line))

    def extrapolate(self, step: float, order: int) -> ForcePolynomial:
        """Return the forces over a step of ``step`` (in s) from the newest value on.

        ``order`` 0 holds the value, 1 goes on along the last line, 2 along the
        last parabola; early in a run as many values are used as there are.
        """
        start, slope, curvature = self._differences(order)
        reach = step + (self.ages[1] if self.ages.size > 1 else 0.0)
        end = start + step * (slope + reach * curvature)
        return ForcePolynomial(start, end, step**2 * curvature)

    def interpolate(self, order: int) -> ForcePolynomial:
        """Return the forces over the step that began at the value before and ends at the newest.

        ``order`` 0 takes the newest value for all of the step, 1 the line
        between the two, 2 the parabola through the value before as well.

        Raises
        ------
        ValueError
            If there is only one value.
        """
        if self.ages.size < 2:
            raise ValueError("interpolation needs the values at both ends of the step")
        newest, _, curvature = self._differences(order)
        start = self.forces[1] if order > 0 else newest
        return ForcePolynomial(start, newest, float(self.ages[1]) ** 2 * curvature)

    def _differences(self, order: int) -> tuple[Array, Array, Array]:
        """Return the newest value, slope and curvature: Newton's divided differences."""
        count, forces, ages = min(order + 1, self.ages.size), self.forces, self.ages
        slope = curvature = np.zeros_like(forces[0])
        if count > 1:
            slope = (forces[0] - forces[1]) / ages[1]
        if count > 2:
            before = (forces[1] - forces[2]) / (ages[2] - ages[1])
            curvature = (slope - before) / ages[2]
        return forces[0], slope, curvature
