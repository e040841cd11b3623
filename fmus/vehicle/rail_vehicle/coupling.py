"""Contact forces over a communication step, from values at communication points.

A co-simulation master hands over one value per step. It stands for the start
of the step (the step's forces are then extrapolated) or for its end (they are
interpolated). Both use the polynomial through up to three values at unequal
times; over a step it is written as
``start + (end - start) s + bow s (s - 1)``, as ``VehicleModel.step`` takes it.
"""

import dataclasses
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

INPUT_TIMES = ("step_start", "step_end")


class ForcePolynomial(NamedTuple):
    """Forces over a step: values at both ends and quadratic part, each (4, 6)."""

    start: Array
    end: Array
    bow: Array


@dataclasses.dataclass(frozen=True)
class ForceHistory:
    """The last three communicated values, newest first.

    Attributes
    ----------
    ages
        How long before the newest value each was valid, s, shape (n,), n <= 3,
        increasing from 0.
    forces
        The values, shape (n, 4, 6).
    """

    ages: Array
    forces: Array

    @classmethod
    def begin(cls, forces: Array) -> Self:
        """Start with one value."""
        return cls(np.zeros(1), np.array(forces, dtype=float)[None])

    def append(self, forces: Array, elapsed: float) -> Self:
        """Return the history with a value ``elapsed`` seconds after the newest.

        With ``elapsed`` 0 the newest value is replaced: at a communication
        point only the last value counts.
        """
        kept = slice(None, 2) if elapsed > 0.0 else slice(1, 3)
        ages = np.concatenate([[0.0], self.ages[kept] + elapsed])
        return type(self)(
            ages, np.concatenate([np.asarray(forces, dtype=float)[None], self.forces[kept]])
        )

    def extrapolate(self, step: float, order: int) -> ForcePolynomial:
        """Return the forces over a step of ``step`` seconds from the newest value on.

        ``order`` 0 holds the value, 1 goes on along the last line, 2 along the
        last parabola; early in a run as many values are used as there are.
        """
        start = self.forces[0]
        slope, curvature = self._differences(order)
        ahead = self.ages[1] if self.ages.size > 1 else 0.0
        end = start + step * (slope + (step + ahead) * curvature)
        return ForcePolynomial(start, end, step * step * curvature)

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
        end = self.forces[0]
        _, curvature = self._differences(order)
        return ForcePolynomial(
            end if order == 0 else self.forces[1], end, self.ages[1] ** 2 * curvature
        )

    def _differences(self, order: int) -> tuple[Array, Array]:
        """First and second divided differences at the newest value, zero beyond ``order``."""
        count = min(order + 1, self.ages.size)
        zero = np.zeros(self.forces.shape[1:])
        if count < 2:
            return zero, zero
        forces, ages = self.forces, self.ages
        slope = (forces[0] - forces[1]) / ages[1]
        if count < 3:
            return slope, zero
        before = (forces[1] - forces[2]) / (ages[2] - ages[1])
        return slope, (slope - before) / ages[2]
