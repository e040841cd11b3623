"""Parallel coupling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rail_cosim.algorithms.base import STEP_START, Forgetful
from rail_cosim.exchange import Port


class Jacobi(Forgetful):
    """All slaves from the same instant, as most co-simulation tools do.

    Every slave extrapolates its inputs over the step. Calls per step: set the
    inputs of all slaves; then step each of them and read its outputs.
    """

    name: ClassVar[str] = "jacobi"
    order: ClassVar[str] = "simultaneous"

    def input_times(self, slaves: Sequence[str]) -> dict[str, str]:
        """Return ``step_start`` for all."""
        return dict.fromkeys(slaves, STEP_START)

    def step(self, ports: Sequence[Port], time: float, step_size: float) -> None:
        """Advance all slaves from ``time`` by ``step_size`` seconds."""
        for port in ports:
            port.set_inputs()
        for port in ports:
            port.step(time, step_size)

    def report(self) -> dict[str, float]:
        """Return nothing: there is nothing to tell."""
        return {}
