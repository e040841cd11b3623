"""Contact forces over a communication step, from values at communication points.

A co-simulation master hands over one value per step. It stands for the start
of the step (the step's forces are then extrapolated) or for its end (they are
interpolated). Both use the polynomial through up to three values at unequal
times; over a step it is written as
``start + (end - start) s + bow s (s - 1)``, as ``VehicleModel.step`` takes it.
"""

import dataclasses
import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rail_vehicle.compiled import entry

Array = NDArray[np.float64]

INPUT_TIMES = ("step_start", "step_end")


class ForcePolynomial(NamedTuple):
    """Forces over a step: values at both ends and quadratic part, each (wheelsets, 6)."""

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
        The values, shape (n, 4, 6), N and N.m.
    """

    ages: Array
    forces: Array

    @classmethod
    def begin(cls, forces: Array) -> Self:
        """Start with one value: ``forces``, shape (4, 6), N and N.m."""
        return cls(np.zeros(1), np.array(forces, dtype=float)[None])

    def append(self, forces: Array, elapsed: float) -> Self:
        """Return the history with a value ``elapsed`` s after the newest.

        ``forces`` has shape (4, 6), N and N.m. With ``elapsed`` 0 the newest value is
        replaced: at a communication point only the last value counts.
        """
        memory = ForceMemory(self)
        memory.append(np.ascontiguousarray(forces, dtype=float).ravel(), elapsed)
        made = memory.history
        return type(self)(made.ages, made.forces)

    def extrapolate(self, step: float, order: int) -> ForcePolynomial:
        """Return the forces over a step of ``step`` (in s) from the newest value on.

        ``order`` 0 holds the value, 1 goes on along the last line, 2 along the
        last parabola; early in a run as many values are used as there are.
        """
        return _polynomial(ForceMemory(self).over_step(step, order, at_end=False))

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
        return _polynomial(ForceMemory(self).over_step(float(self.ages[1]), order, at_end=True))


def _polynomial(rows: Array) -> ForcePolynomial:
    start, end, bow = rows.reshape(3, -1, 6)
    return ForcePolynomial(start, end, bow)


class ForceMemory:
    """A :class:`ForceHistory` that is written over: for the step, which makes no arrays.

    Parameters
    ----------
    history
        What it starts with.
    unit
        What counts as a large force or moment in :attr:`surprise`, N and N.m, six numbers;
        infinite where nothing is asked.
    surprise
        To start with, see there.
    """

    def __init__(
        self,
        history: ForceHistory,
        unit: tuple[float, ...] = (math.inf,) * 6,
        surprise: float = 0.0,
    ) -> None:
        count, width = history.ages.size, history.forces[0].size
        self._unit = np.tile(np.array(unit), width // 6)
        self._memory = np.zeros(_FORCES + 3 * width + 1)
        self._memory[-1] = surprise
        self._memory[0] = count
        self._memory[_AGES : _AGES + count] = history.ages
        self._memory[_FORCES : _FORCES + width * count] = history.forces.ravel()
        self._curve = np.zeros((3, width))

    @property
    def history(self) -> ForceHistory:
        """A copy of what it holds."""
        count, width = int(self._memory[0]), self._curve.shape[1]
        values = self._memory[_FORCES : _FORCES + width * count]
        return ForceHistory(
            self._memory[_AGES : _AGES + count].copy(), values.copy().reshape(count, -1, 6)
        )

    @property
    def surprise(self) -> float:
        """How far the values are from the parabola through the three before each of them.

        Root mean square over the wheelsets in parts of the unit, at most 1 for each step; mean over
        some :data:`MEMORY` steps. Forces that are followed are near 0, those that turn from step
        to step near 1.
        """
        return float(self._memory[-1])

    def append(self, forces: Array, elapsed: float) -> None:
        """Take in a value, six numbers per wheelset, ``elapsed`` seconds after the newest."""
        _append(self._memory, forces, elapsed)

    def take(
        self, forces: Array, elapsed: float, step: float, order: int, *, at_end: bool
    ) -> Array:
        """Return what :meth:`over_step` does, after :meth:`append`; faster than both."""
        _take(self._memory, forces, elapsed, step, order, at_end, self._unit, self._curve)
        return self._curve

    def over_step(self, step: float, order: int, *, at_end: bool) -> Array:
        """Return start, end and bow of the forces over a step, shape (3, 6 per wheelset).

        The newest value is that of the step's end or of its start. The array is
        written over by the next call.
        """
        _over_step(self._memory, step, order, at_end, self._curve)
        return self._curve


LEAST_SPAN = 0.5
"""Shortest time from the start of a step back to a value that its polynomial uses, in parts of the
step, as long as there are earlier ones."""

MEMORY = 200
"""Steps over which the surprise is a mean."""

# The memory as one vector: how many values it holds, their ages, the values, the surprise.
_AGES, _FORCES = 1, 4


@entry
def _take(
    memory: Array,
    newest: Array,
    elapsed: float,
    step: float,
    order: int,
    at_end: bool,
    unit: Array,
    curve: Array,
) -> None:
    # The value before the start of the step is left out where it is near and there is another:
    # the parabola would magnify its error with the ratio of the times.
    before = 1 if at_end else 0
    distance = memory[_AGES + 1] if at_end else elapsed
    forgets = 0.0 < distance < LEAST_SPAN * step and memory[0] > before + 1.0
    if forgets and at_end:
        _forget(memory, newest.size, before)
    if elapsed > 0.0 and memory[0] > 2.0:
        _compare(memory, newest, elapsed, unit)
    if forgets and not at_end:
        _forget(memory, newest.size, before)
    _append(memory, newest, elapsed)
    _over_step(memory, step, order, at_end, curve)


@entry
def _compare(memory: Array, newest: Array, elapsed: float, unit: Array) -> None:
    """Add to the surprise how far a value is from the parabola through the three before it."""
    width, total = newest.size, 0.0
    before, earlier = memory[_AGES + 1], memory[_AGES + 2]
    for column in range(width):
        last, second, third = (
            memory[_FORCES + column],
            memory[_FORCES + width + column],
            memory[_FORCES + 2 * width + column],
        )
        slope = (last - second) / before
        curvature = (slope - (second - third) / (earlier - before)) / earlier
        expected = last + elapsed * (slope + (elapsed + before) * curvature)
        total += ((newest[column] - expected) / unit[column]) ** 2
    size = min(1.0, math.sqrt(6.0 * total / width))
    memory[memory.size - 1] += (size - memory[memory.size - 1]) / MEMORY


@entry
def _forget(memory: Array, width: int, value: int) -> None:
    """Forget a value, 0 for the newest; those before it stay."""
    memory[0] -= 1.0
    for later in range(value, 2):
        memory[_AGES + later] = memory[_AGES + later + 1]
        for column in range(width):
            place = _FORCES + width * later + column
            memory[place] = memory[place + width]


@entry
def _append(memory: Array, newest: Array, elapsed: float) -> None:
    width = newest.size
    if elapsed > 0.0:
        memory[0] = min(3.0, memory[0] + 1.0)
        for value in range(2, 0, -1):
            memory[_AGES + value] = memory[_AGES + value - 1] + elapsed
            for column in range(width):
                place = _FORCES + width * value + column
                memory[place] = memory[place - width]
    memory[_AGES] = 0.0
    for column in range(width):
        memory[_FORCES + column] = newest[column]


@entry
def _over_step(memory: Array, step: float, order: int, at_end: bool, curve: Array) -> None:
    """Write the polynomial through the newest values (Newton's divided differences)."""
    width = curve.shape[1]
    count = min(order + 1, int(memory[0]))
    before, earlier = memory[_AGES + 1], memory[_AGES + 2]
    for column in range(width):
        newest = memory[_FORCES + column]
        slope, curvature = 0.0, 0.0
        if count > 1:
            slope = (newest - memory[_FORCES + width + column]) / before
        if count > 2:
            other = memory[_FORCES + width + column] - memory[_FORCES + 2 * width + column]
            curvature = (slope - other / (earlier - before)) / earlier
        if at_end:
            curve[0, column] = memory[_FORCES + width + column] if count > 1 else newest
            curve[1, column] = newest
        else:
            reach = step + (before if memory[0] > 1.0 else 0.0)
            curve[0, column] = newest
            curve[1, column] = newest + step * (slope + reach * curvature)
        curve[2, column] = step * step * curvature
