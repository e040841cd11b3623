"""Sequential coupling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rail_cosim.algorithms.base import STEP_END, STEP_START, Forgetful
from rail_cosim.exchange import Port


class GaussSeidel(Forgetful):
    """One slave after the other, each with the newest outputs of the others.

    With the track first it extrapolates the smooth wheelset motion, and the
    vehicle integrates with contact forces known at both ends of the step.
    Calls per step, for ports (track, vehicle): set inputs of the track, step
    it, read its outputs; then the same for the vehicle.
    """

    name: ClassVar[str] = "gauss-seidel"
    order: ClassVar[str] = "sequential"

    def input_times(self, slaves: Sequence[str]) -> dict[str, str]:
        """Return ``step_start`` for the first slave, ``step_end`` for those after it."""
        return {name: STEP_START if i == 0 else STEP_END for i, name in enumerate(slaves)}

    def step(self, ports: Sequence[Port], time: float, step_size: float) -> None:
        """Advance all slaves from ``time`` by ``step_size`` seconds."""
        for port in ports:
            port.set_inputs()
            port.step(time, step_size)

    def report(self) -> dict[str, float]:
        """Return nothing: there is nothing to tell."""
        return {}
