"""Record the outputs of all slaves at communication points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError
from rail_cosim.exchange import Port
from rail_cosim.spool import Spool

_ROWS = 4096
Array = NDArray[np.float64]


class Recorder:
    """Observer that keeps the output buffers of every ``every``-th step.

    A record is one row: the time, then the real and the integer outputs of each port. Rows go
    to arrays allocated ahead, so that a step costs one vector copy per slave, and what was
    recorded is whole at any time. With a spool full arrays go to disk and are used again: then
    the memory does not grow with the length of the run.

    Parameters
    ----------
    ports
        The slaves' ports; all their outputs are recorded.
    every
        Record each step (1), each second (2), ...; the start is always recorded.
    spool
        Where rows go; ``None`` keeps all in memory. Rows that it has count as recorded.

    Raises
    ------
    ParameterError
        If ``every`` is less than 1.
    """

    def __init__(
        self, ports: Sequence[Port], *, every: int = 1, spool: Spool | None = None
    ) -> None:
        if every < 1:
            raise ParameterError("--record-every", every, "must be at least 1")
        self.every = every
        self.spool = spool
        self._ports = tuple(ports)
        self._names = {p.slave.name: p.outputs.names + p.counters.names for p in self._ports}
        self._columns: dict[str, slice] = {}
        self._sources: list[tuple[slice, NDArray]] = []
        self._lay_out()
        self._full: list[Array] = []
        self._block = np.empty((_ROWS, self.width))
        self._row = 0

    def _lay_out(self) -> None:
        end = 1
        for port in self._ports:
            first = end
            for values in (port.outputs.values, port.counters.values):
                if len(values):
                    self._sources.append((slice(end, end + len(values)), values))
                end += len(values)
            self._columns[port.slave.name] = slice(first, end)
        self.width = end

    def due(self, step: int) -> bool:
        """Whether the point at the end of this step (1, 2, ...) is to be recorded."""
        return step % self.every == 0

    def record(self, time: float) -> None:
        """Record the ports' output buffers as those of ``time`` (s).

        Raises
        ------
        ResultsError
            If the disk does not take the records; those in memory are kept.
        """
        if self._row == _ROWS:
            self._put_away()
        row = self._block[self._row]
        row[0] = time
        for columns, values in self._sources:
            row[columns] = values
        self._row += 1  # last: an interrupted row does not count

    def append(self, rows: Array) -> None:
        """Take in records made elsewhere, shape (n, width)."""
        while len(rows):
            if self._row == _ROWS:
                self._put_away()
            count = min(len(rows), _ROWS - self._row)
            self._block[self._row : self._row + count] = rows[:count]
            self._row += count
            rows = rows[count:]

    def places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the columns of all real outputs, and of all integer outputs, port by port."""
        reals, counters = [], []
        for port in self._ports:
            first = self._columns[port.slave.name].start
            middle = first + len(port.outputs.names)
            reals += range(first, middle)
            counters += range(middle, middle + len(port.counters.names))
        return np.array(reals, dtype=np.intp), np.array(counters, dtype=np.intp)

    def _put_away(self) -> None:
        if self.spool is None:
            self._full.append(self._block)
            self._block = np.empty((_ROWS, self.width))
        else:
            self.spool.append(self._block[: self._row])
        self._row = 0

    def flush(self) -> None:
        """Hand everything to the spool, if there is one, and make it survive a loss of power."""
        if self.spool is not None:
            if self._row:
                self._put_away()
            self.spool.sync()

    def __len__(self) -> int:
        return self._settled + self._row

    @property
    def _settled(self) -> int:
        return _ROWS * len(self._full) if self.spool is None else len(self.spool)

    @property
    def times(self) -> Array:
        """Recorded points in s, shape (n,)."""
        return self.rows(0, len(self))[:, 0]

    def rows(self, start: int, stop: int) -> Array:
        """Return records ``start`` to ``stop``, shape (n, width): time, then all outputs."""
        settled = self._settled
        parts = [self._block[max(start - settled, 0) : min(max(stop - settled, 0), self._row)]]
        if start < settled:
            end = min(stop, settled)
            if self.spool is not None:
                parts.insert(0, self.spool.rows(start, end))
            else:
                first, last = start // _ROWS, -(-end // _ROWS)
                joined = np.concatenate(self._full[first:last])
                parts.insert(0, joined[start - first * _ROWS : end - first * _ROWS])
        return np.concatenate(parts)

    def latest(self, slave: str, columns: Sequence[int], count: int) -> Array:
        """Return the last ``count`` records of some real outputs, or as many as there are.

        Parameters
        ----------
        slave
            Its name.
        columns
            Positions among the slave's outputs, as in :meth:`names`.
        count
            Number of records.

        Returns
        -------
        ndarray
            Shape (n, len(columns)).
        """
        first = self._columns[slave].start
        end = len(self)
        return self.rows(max(0, end - count), end)[:, [first + column for column in columns]]

    def names(self, slave: str) -> tuple[str, ...]:
        """Return the names of a slave's outputs in the order of its columns."""
        return self._names[slave]

    def columns(self, slave: str) -> slice:
        """Return where a slave's outputs are in a row of :meth:`rows`."""
        return self._columns[slave]

    def values(self, slave: str) -> tuple[tuple[str, ...], Array]:
        """Return names and values, shape (n, number of outputs), of one slave."""
        return self._names[slave], self.rows(0, len(self))[:, self._columns[slave]]
