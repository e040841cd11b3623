"""One run from its first record, or from its checkpoint, to the file of its results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from rail_cosim.checkpoint import Checkpoint, Keeper, read_checkpoint, records_path
from rail_cosim.fmu import FmuSlave
from rail_cosim.options import RunOptions
from rail_cosim.recorder import Recorder
from rail_cosim.results import stream_netcdf, to_dataset, write_netcdf
from rail_cosim.simulation import Outcome, Simulation
from rail_cosim.spool import Spool
from rail_cosim.system import SystemStructure

LARGEST_IN_MEMORY = 1 << 27
"""Bytes of records up to which results are made in memory."""


def begun_run(options: RunOptions) -> Checkpoint | None:
    """Return where the run to be resumed is; None for a new one.

    Raises
    ------
    RailCosimError
        If it cannot be resumed, or was begun with other options.
    """
    if not options.resume or options.out is None:
        return None
    begun = read_checkpoint(options.out)
    begun.check_options(options)
    return begun


class Session:
    """Where the records of a run go, and what is kept so that it can go on.

    Without a file for the results all stays in memory.

    Parameters
    ----------
    options
        Of the run.
    system
        Its slaves, initialised.
    slaves
        The same by name.
    begun
        Where the run is that is continued.

    Attributes
    ----------
    recorder
        Of the run.
    """

    def __init__(
        self,
        options: RunOptions,
        system: SystemStructure,
        slaves: Mapping[str, FmuSlave],
        begun: Checkpoint | None,
    ) -> None:
        self._options, self._system, self._slaves, self._begun = options, system, slaves, begun
        self._spool = self._keeper = None
        if options.out is not None:
            width = Recorder(system.ports).width
            rows = begun.records if begun else 0
            self._spool = Spool(records_path(options.out), width, rows=rows)
            self._keeper = Keeper(options, slaves, options.checkpoint_interval)
            if begun is None:
                self._keeper.remove()
        self.recorder = Recorder(system.ports, every=options.record_every, spool=self._spool)

    def go_on(self, simulation: Simulation) -> None:
        """Put slaves and simulation where the run was stopped, if it is continued."""
        if self._begun is not None:
            self._begun.restore(self._slaves, simulation)

    def offer(self, simulation: Simulation) -> None:
        """Write a checkpoint if it is time."""
        if self._keeper is not None:
            self._keeper.offer(simulation)

    def finish(
        self, simulation: Simulation, outcome: Outcome, attributes: Mapping[str, Any]
    ) -> xr.Dataset:
        """Write the results and return them; a long run's are read from the file when used.

        What a run needs to go on is kept if the user stopped it, else removed.
        """
        out, variables = self._options.out, self._options.variables
        if out is None or self._spool is None or self._keeper is None:
            return to_dataset(self._system, self.recorder, attributes, variables=variables)
        stopped = isinstance(outcome.error, KeyboardInterrupt)
        if stopped and self._keeper.possible:
            self._keeper.write(simulation)
        if len(self.recorder) * self.recorder.width * 8 <= LARGEST_IN_MEMORY:
            dataset = to_dataset(self._system, self.recorder, attributes, variables=variables)
            write_netcdf(dataset, out)
        else:
            stream_netcdf(self._system, self.recorder, attributes, out, variables)
            dataset = xr.open_dataset(out, engine="h5netcdf")
        self._spool.close()
        if not (stopped and self._keeper.possible):
            self._spool.path.unlink(missing_ok=True)
            self._keeper.remove()
        return dataset
