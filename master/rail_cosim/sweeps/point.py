"""One point of a sweep, run in a worker process."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import xarray as xr

from rail_cosim.cache import cache_directory
from rail_cosim.description import FmuDescription, read_description
from rail_cosim.errors import RailCosimError
from rail_cosim.runner import simulate
from rail_cosim.sweeps.plan import FmuFile, Task
from rail_cosim.sweeps.quantities import evaluate, histories


@dataclasses.dataclass(frozen=True, kw_only=True)
class PointResult:
    """What a point gave.

    Attributes
    ----------
    data
        Its quantities; without variables if it failed.
    error
        Why it failed, empty if it did not.
    remarks
        Warnings of the FMUs.
    lasting
        Whether it would come out so again; not so where the worker died.
    """

    data: xr.Dataset
    error: str = ""
    remarks: tuple[str, ...] = ()
    lasting: bool = True


class _Remarks:
    """Reporter that keeps the warnings."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def stage(self, text: str) -> None:
        """Say nothing."""

    def progress(self, done: int, planned: int) -> None:
        """Say nothing."""

    def notice(self, text: str) -> None:
        """Keep it."""
        self.texts.append(text)


def received(file: FmuFile) -> Path:
    """Return where a worker keeps an FMU that it was sent."""
    return cache_directory() / "received" / file.identity / file.name


@functools.cache
def _description(path: Path) -> FmuDescription:
    return read_description(path)


def run_point(task: Task) -> PointResult:
    """Run one point; whatever the FMUs say against it is in the result."""
    remarks = _Remarks()
    try:
        descriptions = {name: _description(received(file)) for name, file in task.fmus.items()}
        run, outcome = simulate(task.options, descriptions, task.parameters, remarks)
        if outcome.error is not None:
            raise outcome.error
        data = xr.merge(
            [
                evaluate(run, task.keep),
                histories(run, task.history, task.history_every),
                _facts(run),
            ]
        )
    except RailCosimError as error:
        return PointResult(data=xr.Dataset(), error=str(error), remarks=tuple(remarks.texts))
    return PointResult(data=data, remarks=tuple(remarks.texts))


def _facts(run: xr.Dataset) -> xr.Dataset:
    """Return how far the run went, and whether it was steady in the end."""
    steady = {"units": "1", "long_name": "1: the run had become steady, 0: not by its end"}
    change = {"units": "1", "long_name": "relative change over the last slab length"}
    way = {"units": "m", "long_name": "way of the leading wheelset"}
    facts = (
        xr.Dataset({"way": ((), float(run["distance"][-1]), way)})
        if "distance" in run
        else (xr.Dataset())
    )
    if "steady" in run.attrs:
        facts["steady"] = ((), int(run.attrs["steady"]), steady)
        facts["steady_change"] = ((), float(run.attrs["steady_change"]), change)
    return facts
