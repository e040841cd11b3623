"""Implicit coupling by repetition of the step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rail_cosim.algorithms.base import STEP_END
from rail_cosim.errors import DivergenceError, ParameterError
from rail_cosim.exchange import Port


class IterativeGaussSeidel:
    """Gauss-Seidel repeated within each step until the exchanged values agree.

    The first slave gets the inputs of the *end* of the step: first guessed by
    linear extrapolation, then from the others' step. Before each repetition
    all slaves go back to the state at the start of the step. For checking the
    other algorithms; the slaves must be able to save their state.

    Parameters
    ----------
    tolerance
        The step is accepted when no output of the first slave (no contact
        force) differs between two repetitions by more than this share of the
        largest of them.
    limit
        Largest number of repetitions of a step.
    """

    name: ClassVar[str] = "iterative-gauss-seidel"
    order: ClassVar[str] = "iterated"

    def __init__(self, *, tolerance: float = 1e-9, limit: int = 30) -> None:
        if not 0.0 < tolerance < 1.0:
            raise ParameterError("tolerance", tolerance, "must be greater than 0 and less than 1")
        if limit < 2:
            raise ParameterError("limit", limit, "must be at least 2")
        self.tolerance, self.limit = tolerance, limit
        self._previous: NDArray[np.float64] | None = None
        self._steps = self._passes = 0

    def input_times(self, slaves: Sequence[str]) -> dict[str, str]:
        """Return ``step_end`` for all."""
        return dict.fromkeys(slaves, STEP_END)

    def step(self, ports: Sequence[Port], time: float, step_size: float) -> None:
        """Advance all slaves from ``time`` by ``step_size`` seconds.

        Raises
        ------
        DivergenceError
            If the values do not agree after ``limit`` repetitions.
        """
        first = ports[0]
        first.gather()
        start = first.inputs.values.copy()
        before = start if self._previous is None else self._previous
        first.inputs.values[:] = 2.0 * start - before
        saved = [port.slave.save_state() for port in ports]
        self._repeat(ports, saved, time, step_size)  # after an error FMI allows no freeing
        for port, state in zip(ports, saved, strict=True):
            port.slave.free_state(state)
        self._previous = start
        self._steps += 1

    def _repeat(
        self, ports: Sequence[Port], saved: Sequence[object], time: float, step_size: float
    ) -> None:
        first, coupled = ports[0], ports[0].coupled
        last = first.outputs.values[:coupled].copy()
        change = np.inf
        for count in range(self.limit):
            if count > 0:
                for port, state in zip(ports, saved, strict=True):
                    port.slave.restore_state(state)
                first.gather()
            first.inputs.write()
            first.step(time, step_size)
            for port in ports[1:]:
                port.set_inputs()
                port.step(time, step_size)
            self._passes += 1
            new = first.outputs.values[:coupled]
            change = float(np.max(np.abs(new - last), initial=0.0))
            scale = float(np.max(np.abs(new), initial=0.0))
            if count > 0 and change <= self.tolerance * scale:
                return
            last[:] = new
        raise DivergenceError(
            f"the iteration at t = {time:.6g} s does not converge: after {self.limit} repetitions "
            f"the outputs of {first.slave.name} still change by {change:.3g}; "
            "take a smaller macro step"
        )

    def report(self) -> dict[str, float]:
        """Return the mean number of passes per step."""
        return {"passes_per_step": self._passes / self._steps if self._steps else 0.0}

    def memory(self) -> dict[str, NDArray]:
        """Return the inputs of the step before, and the counts."""
        previous = np.empty(0) if self._previous is None else self._previous
        return {"previous": previous, "counts": np.array([self._steps, self._passes])}

    def recall(self, memory: Mapping[str, NDArray]) -> None:
        """Take back what :meth:`memory` returned."""
        previous = np.array(memory["previous"])
        self._previous = previous if previous.size else None
        self._steps, self._passes = (int(count) for count in memory["counts"])
