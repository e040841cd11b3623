"""Keep where a run is, so that it can go on after whatever stopped it.

Beside ``run.nc`` lie, while the run goes on, ``run.nc.records`` (the records, see
:mod:`rail_cosim.spool`) and ``run.nc.checkpoint``: the states of both FMUs as they serialise
them, what the master itself remembers, and how many records belong to it. The checkpoint is
written anew every so often, whole or not at all. A run that is continued from it gives the
same numbers, bit for bit, as one that was never stopped. Both files go when the run is complete.

The file is a zip archive of arrays and one text (numpy's npz): nothing in it is executed.
"""

from __future__ import annotations

import dataclasses
import json
import os
import time as clock
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rail_cosim.errors import ParameterError, RailCosimError, ResultsError
from rail_cosim.fmu import FmuSlave
from rail_cosim.options import RunOptions
from rail_cosim.simulation import Simulation

FORMAT = 1
INTERVAL = 60.0
"""Seconds between two checkpoints."""
_FREE = ("out", "plot", "animate", "slow_motion", "exaggeration", "command", "resume")
_FREE += ("checkpoint_interval", "variables")


class CheckpointError(RailCosimError):
    """A run cannot be continued."""

    exit_status = 2


def checkpoint_path(out: Path) -> Path:
    """Return where the checkpoint of a run with these results is."""
    return out.with_name(f"{out.name}.checkpoint")


def records_path(out: Path) -> Path:
    """Return where the records of a run with these results are while it goes on."""
    return out.with_name(f"{out.name}.records")


def fixed_options(options: RunOptions) -> dict[str, Any]:
    """Return the options that a continued run must have in common with the one begun.

    It may go further than planned, unless the distance decides about the way itself.
    """
    values = dataclasses.asdict(options)
    if options.final_speed is None and options.irregularity is None:
        del values["distance"]
    fixed = {name: value for name, value in values.items() if name not in _FREE}
    return {
        name: list(value)
        if isinstance(value, tuple | list)
        else str(value)
        if isinstance(value, Path)
        else value
        for name, value in fixed.items()
    }


@dataclasses.dataclass(frozen=True, kw_only=True)
class Checkpoint:
    """What is read from a checkpoint.

    Attributes
    ----------
    options
        Those of :func:`fixed_options`.
    fmus
        GUID of each FMU by slave.
    records
        Number of records that belong to it.
    states
        Serialised state of each FMU by slave.
    memory
        What the simulation remembers (:meth:`rail_cosim.simulation.Simulation.memory`).
    """

    options: Mapping[str, Any]
    fmus: Mapping[str, str]
    records: int
    states: Mapping[str, bytes]
    memory: Mapping[str, np.ndarray]

    def check_options(self, options: RunOptions) -> None:
        """Refuse options that are not those of the run begun.

        Raises
        ------
        ParameterError
            For the first that differs.
        """
        for name, value in fixed_options(options).items():
            begun = self.options.get(name)
            if begun != value:
                shown = "--set" if name == "settings" else f"--{name.replace('_', '-')}"
                limit = f"the run to be resumed was begun with {begun!r}"
                raise ParameterError(shown, str(value), limit, "give the same command again")

    def restore(self, slaves: Mapping[str, FmuSlave], simulation: Simulation) -> None:
        """Put initialised slaves and the simulation where they were.

        Raises
        ------
        CheckpointError
            If these are other FMUs.
        """
        for name, slave in slaves.items():
            if self.fmus.get(name) != slave.description.guid:
                raise CheckpointError(
                    f"{slave.description.path}: the run was begun with another version of the "
                    f"{name} (GUID {self.fmus.get(name)}); begin it anew without --resume"
                )
            slave.restore_bytes(self.states[name])
        simulation.recall(self.memory)


def read_checkpoint(out: Path) -> Checkpoint:
    """Read the checkpoint of a run whose results go to ``out``.

    Raises
    ------
    CheckpointError
        If there is none, or it cannot be read.
    """
    path = checkpoint_path(out)
    if not path.is_file():
        raise CheckpointError(
            f"--resume: there is no {path}; the run is complete, was not begun, or was stopped "
            "before its first checkpoint: leave --resume out to begin it"
        )
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            if about["format"] != FORMAT:
                raise CheckpointError(
                    f"{path}: has format {about['format']}, this version reads {FORMAT}; "
                    "begin the run anew without --resume"
                )
            return Checkpoint(
                options=about["options"],
                fmus=about["fmus"],
                records=int(about["records"]),
                states={n: file[f"state.{n}"].tobytes() for n in about["fmus"]},
                memory={
                    name.removeprefix("memory."): file[name]
                    for name in file.files
                    if name.startswith("memory.")
                },
            )
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile, EOFError) as error:
        raise CheckpointError(
            f"{path}: is no checkpoint, or damaged ({error}); begin the run anew without --resume"
        ) from error


class Keeper:
    """Writes checkpoints of a run while it goes on.

    Parameters
    ----------
    options
        Of the run; ``out`` says where.
    slaves
        By name.
    interval
        Seconds between two.
    """

    def __init__(
        self, options: RunOptions, slaves: Mapping[str, FmuSlave], interval: float
    ) -> None:
        if options.out is None:
            raise ValueError("checkpoints lie beside the results, which need a file")
        self._path = checkpoint_path(options.out)
        self._options, self._slaves, self._interval = options, slaves, interval
        self._last = clock.monotonic()

    @property
    def possible(self) -> bool:
        """Whether all FMUs can write their state."""
        return all(slave.description.can_serialize_state for slave in self._slaves.values())

    def offer(self, simulation: Simulation) -> None:
        """Write a checkpoint if it is time."""
        if self.possible and clock.monotonic() - self._last >= self._interval:
            self.write(simulation)

    def write(self, simulation: Simulation) -> None:
        """Write a checkpoint now.

        Raises
        ------
        ResultsError
            If it could not be written; the one before is then still there.
        """
        recorder = simulation.recorder
        recorder.flush()
        arrays: dict[str, Any] = {
            f"memory.{name}": value for name, value in simulation.memory().items()
        }
        for name, slave in self._slaves.items():
            arrays[f"state.{name}"] = np.frombuffer(slave.state_bytes(), dtype=np.uint8)
        about = {
            "format": FORMAT,
            "options": fixed_options(self._options),
            "fmus": {name: slave.description.guid for name, slave in self._slaves.items()},
            "records": len(recorder),
        }
        scratch = self._path.with_name(f".{self._path.name}.{os.getpid()}.part")
        try:
            with open(scratch, "wb") as file:
                np.savez(file, allow_pickle=False, about=np.array(json.dumps(about)), **arrays)
                file.flush()
                os.fsync(file.fileno())
            os.replace(scratch, self._path)
        except OSError as error:
            raise ResultsError(
                f"{self._path}: the checkpoint could not be written ({error.strerror or error})"
            ) from error
        finally:
            scratch.unlink(missing_ok=True)
        self._last = clock.monotonic()

    def remove(self) -> None:
        """Remove the checkpoint of a run that is complete."""
        self._path.unlink(missing_ok=True)
