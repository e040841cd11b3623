"""Record the outputs of all slaves at communication points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError
from rail_cosim.exchange import Port

_ROWS = 4096


class Recorder:
    """Observer that keeps the output buffers of every ``every``-th step.

    Values go to arrays allocated ahead in blocks, so that a step costs one
    vector copy per slave, and what was recorded is whole at any time.

    Parameters
    ----------
    ports
        The slaves' ports; all their outputs are recorded.
    every
        Record each step (1), each second (2), ...; the start is always recorded.

    Raises
    ------
    ParameterError
        If ``every`` is less than 1.
    """

    def __init__(self, ports: Sequence[Port], *, every: int = 1) -> None:
        if every < 1:
            raise ParameterError("--record-every", every, "must be at least 1")
        self.every = every
        self._ports = tuple(ports)
        self._widths = [len(p.outputs.names) + len(p.counters.names) for p in self._ports]
        self._times: list[float] = []
        self._blocks: list[tuple[NDArray[np.float64], ...]] = []

    def due(self, step: int) -> bool:
        """Whether the point at the end of this step (1, 2, ...) is to be recorded."""
        return step % self.every == 0

    def record(self, time: float) -> None:
        """Record the ports' output buffers as those of ``time`` (s)."""
        row = len(self._times) % _ROWS
        if row == 0:
            self._blocks.append(tuple(np.empty((_ROWS, width)) for width in self._widths))
        for block, port in zip(self._blocks[-1], self._ports, strict=True):
            reals = len(port.outputs.values)
            block[row, :reals] = port.outputs.values
            if reals < block.shape[1]:
                block[row, reals:] = port.counters.values
        self._times.append(time)  # last: an interrupted row does not count

    def __len__(self) -> int:
        return len(self._times)

    @property
    def times(self) -> NDArray[np.float64]:
        """Recorded points in s, shape (n,)."""
        return np.array(self._times)

    def latest(self, slave: str, columns: Sequence[int], count: int) -> NDArray[np.float64]:
        """Return the last ``count`` records of some real outputs, or as many as there are.

        Parameters
        ----------
        slave
            Its name.
        columns
            Positions among the slave's outputs, as in the names of :meth:`values`.
        count
            Number of records.

        Returns
        -------
        ndarray
            Shape (n, len(columns)).
        """
        position = [port.slave.name for port in self._ports].index(slave)
        first = max(0, len(self) - count)
        skipped = first // _ROWS
        kept = [block[position][:, columns] for block in self._blocks[skipped:]]
        rows = slice(first - skipped * _ROWS, len(self) - skipped * _ROWS)
        return np.concatenate([np.empty((0, len(columns))), *kept])[rows]

    def values(self, slave: str) -> tuple[tuple[str, ...], NDArray[np.float64]]:
        """Return names and values, shape (n, number of outputs), of one slave."""
        for position, port in enumerate(self._ports):
            if port.slave.name == slave:
                empty = np.empty((0, self._widths[position]))
                blocks = [block[position] for block in self._blocks]
                names = port.outputs.names + port.counters.names
                return names, np.concatenate([empty, *blocks])[: len(self)]
        raise KeyError(slave)
