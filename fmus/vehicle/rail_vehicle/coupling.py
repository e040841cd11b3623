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
from numba import njit
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
        skipped = 0 if elapsed > 0.0 else 1
        count = min(3, self.ages.size + 1 - skipped)
        added = type(self)(np.empty(count), np.empty((count, 4, 6)))
        newest = np.ascontiguousarray(forces, dtype=float)
        _shift(self.ages, self.forces, newest, elapsed, skipped, added.ages, added.forces)
        return added

    def extrapolate(self, step: float, order: int) -> ForcePolynomial:
        """Return the forces over a step of ``step`` seconds from the newest value on.

        ``order`` 0 holds the value, 1 goes on along the last line, 2 along the
        last parabola; early in a run as many values are used as there are.
        """
        end, bow = np.empty((4, 6)), np.empty((4, 6))
        _ahead(self.ages, self.forces, step, order, end, bow)
        return ForcePolynomial(self.forces[0], end, bow)

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
        bow = np.empty((4, 6))
        _behind(self.ages, self.forces, order, bow)
        return ForcePolynomial(self.forces[1 if order else 0], self.forces[0], bow)


# Results go into arrays made by the caller: returning one from numba costs more than all the rest.


@njit(cache=True)
def _shift(
    ages: Array,
    forces: Array,
    newest: Array,
    elapsed: float,
    skipped: int,
    new_ages: Array,
    new_forces: Array,
) -> None:
    for index in range(new_ages.size):
        source = index + skipped - 1
        new_ages[index] = ages[source] + elapsed if index > 0 else 0.0
        for wheelset in range(4):
            for column in range(6):
                new_forces[index, wheelset, column] = (
                    forces[source, wheelset, column] if index > 0 else newest[wheelset, column]
                )


@njit(cache=True)
def _differences(
    ages: Array, forces: Array, order: int, wheelset: int, column: int
) -> tuple[float, float]:
    """First and second divided differences at the newest value, zero beyond ``order``."""
    count = min(order + 1, ages.size)
    if count < 2:
        return 0.0, 0.0
    newest, before = forces[0, wheelset, column], forces[1, wheelset, column]
    slope = (newest - before) / ages[1]
    if count < 3:
        return slope, 0.0
    earlier = (before - forces[2, wheelset, column]) / (ages[2] - ages[1])
    return slope, (slope - earlier) / ages[2]


@njit(cache=True)
def _ahead(ages: Array, forces: Array, step: float, order: int, end: Array, bow: Array) -> None:
    reach = step + (ages[1] if ages.size > 1 else 0.0)
    for wheelset in range(4):
        for column in range(6):
            slope, curvature = _differences(ages, forces, order, wheelset, column)
            gain = step * (slope + reach * curvature)
            end[wheelset, column] = forces[0, wheelset, column] + gain
            bow[wheelset, column] = step * step * curvature


@njit(cache=True)
def _behind(ages: Array, forces: Array, order: int, bow: Array) -> None:
    for wheelset in range(4):
        for column in range(6):
            _, curvature = _differences(ages, forces, order, wheelset, column)
            bow[wheelset, column] = ages[1] ** 2 * curvature
