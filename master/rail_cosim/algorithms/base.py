"""What an algorithm is: it advances all slaves by one macro step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Protocol

from numpy.typing import NDArray

from rail_cosim.exchange import Port

STEP_START, STEP_END = "step_start", "step_end"


class Algorithm(Protocol):
    """A way to step coupled slaves.

    The outputs in the ports' buffers are those of ``time`` before a step and
    those of ``time + step_size`` after it.
    """

    name: ClassVar[str]
    order: ClassVar[str]
    """``sequential``, ``simultaneous`` or ``iterated``: how a step is made of calls."""

    def input_times(self, slaves: Sequence[str]) -> dict[str, str]:
        """Return what instant of a step each slave's inputs stand for.

        ``step_start``: the slave extrapolates over the step. ``step_end``: it
        interpolates from the inputs of the step before. ``slaves`` are in
        stepping order.
        """
        ...

    def step(self, ports: Sequence[Port], time: float, step_size: float) -> None:
        """Advance all slaves from ``time`` by ``step_size`` seconds."""
        ...

    def report(self) -> dict[str, float]:
        """Return figures of the algorithm's own for the run's attributes."""
        ...

    def memory(self) -> dict[str, NDArray]:
        """Return what it remembers from step to step, arrays by name."""
        ...

    def recall(self, memory: Mapping[str, NDArray]) -> None:
        """Take back what :meth:`memory` returned."""
        ...


class Forgetful:
    """An algorithm that remembers nothing from step to step."""

    def memory(self) -> dict[str, NDArray]:
        """Return nothing."""
        return {}

    def recall(self, memory: Mapping[str, NDArray]) -> None:
        """Take back nothing."""
