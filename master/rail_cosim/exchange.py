"""Ports: a slave with its vectors of inputs and outputs, and how they are linked."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from rail_cosim.slave import Slave, Vector


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Link:
    """Connected outputs of one port that are inputs of another.

    Attributes
    ----------
    source, target
        Positions in the source's output buffer and in the target's input
        buffer, both of shape (n,), or slices of length n.
    outputs
        The source's output buffer.
    """

    outputs: NDArray[np.float64]
    source: NDArray[np.intp] | slice
    target: NDArray[np.intp] | slice


@dataclasses.dataclass(kw_only=True, eq=False)
class Port:
    """A slave as an algorithm sees it.

    Attributes
    ----------
    slave
        The slave.
    inputs
        Its connected inputs.
    outputs
        All its real outputs, the connected ones first.
    counters
        All its integer outputs; these are recorded only.
    coupled
        How many of the outputs are connected.
    links
        Where the inputs come from.
    recorded
        Whether the coming step is recorded: then all outputs are read after
        it, else those that are connected.
    """

    slave: Slave
    inputs: Vector
    outputs: Vector
    counters: Vector
    coupled: int
    links: list[Link] = dataclasses.field(default_factory=list)
    recorded: bool = True

    def gather(self) -> None:
        """Copy the latest outputs of the others into the input buffer."""
        for link in self.links:
            self.inputs.values[link.target] = link.outputs[link.source]

    def set_inputs(self) -> None:
        """Gather the inputs and hand them to the slave."""
        self.gather()
        self.inputs.write()

    def step(self, time: float, step_size: float) -> None:
        """Advance the slave and read its outputs."""
        self.slave.do_step(time, step_size)
        if self.recorded:
            self.read_all()
        else:
            self.outputs.read(self.coupled)

    def read_all(self) -> None:
        """Read all outputs."""
        self.outputs.read()
        self.counters.read()
