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
        weights_end = self._weights(step, order)
        end = np.tensordot(weights_end, self.forces[: weights_end.size], axes=1)
        middle_weights = self._weights(0.5 * step, order)
        middle = np.tensordot(middle_weights, self.forces[: middle_weights.size], axes=1)
        start = self.forces[0]
        return ForcePolynomial(start, end, 2.0 * (start + end) - 4.0 * middle)

    def interpolate(self, order: int) -> ForcePolynomial:
        """Return the forces over the step that began at the value before and ends at the newest.

        ``order`` 0 takes the newest value for all of the step, 1 the line
        between the two, 2 the parabola through the value before as well.
        """
        if self.ages.size < 2:
            raise ValueError("interpolation needs the values at both ends of the step")
        end, start = self.forces[0], self.forces[1]
        if order == 0:
            return ForcePolynomial(end, end, np.zeros_like(end))
        step = self.ages[1]
        if order == 1 or self.ages.size < 3:
            return ForcePolynomial(start, end, np.zeros_like(end))
        weights = self._weights(-0.5 * step, 2)
        middle = np.tensordot(weights, self.forces, axes=1)
        return ForcePolynomial(start, end, 2.0 * (start + end) - 4.0 * middle)

    def _weights(self, ahead: float, order: int) -> Array:
        """Lagrange weights of the newest values for a time ``ahead`` of the newest, s."""
        count = min(order + 1, self.ages.size)
        times = -self.ages[:count]
        weights = np.ones(count)
        for index in range(count):
            for other in range(count):
                if other != index:
                    weights[index] *= (ahead - times[other]) / (times[index] - times[other])
        return weights
