"""One point of a sweep, run in a worker process."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import xarray as xr

from rail_cosim.cache import cache_directory
from rail_cosim.description import FmuDescription, read_description
from rail_cosim.errors import RailCosimError
from rail_cosim.events import events_outside
from rail_cosim.extremes import extremes
from rail_cosim.name_map import renamed
from rail_cosim.runner import simulate
from rail_cosim.sweeps.plan import FmuFile, Task
from rail_cosim.sweeps.quantities import evaluate, histories, window_of
from rail_cosim.window import WindowChoice


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
        Warnings of the FMUs; what the statistics do not tell.
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
        descriptions = {
            name: renamed(_description(received(file)), file.renamings)
            for name, file in task.fmus.items()
        }
        run, outcome = simulate(task.options, descriptions, task.parameters, remarks)
        if outcome.error is not None:
            raise outcome.error
        evaluated = evaluate(run, task.keep, task.window)
        records = histories(run, task.history, task.history_every)
        data = xr.merge([evaluated, records, _facts(run, task.window)])
        remarks.texts += _unseen(run, task.window)
    except RailCosimError as error:
        return PointResult(data=xr.Dataset(), error=str(error), remarks=tuple(remarks.texts))
    return PointResult(data=data, remarks=tuple(remarks.texts))


def _facts(run: xr.Dataset, choice: WindowChoice | None) -> xr.Dataset:
    """Return how far the run went, over what it was evaluated, and whether it was steady."""
    window = window_of(run, choice)[0]
    found: dict[str, tuple[float, str, str]] = {
        "window_start": (window.start, "m", "distance travelled, start of the evaluation window"),
        "window_stop": (window.stop, "m", "distance travelled, end of the evaluation window"),
    }
    if "distance" in run:
        way = float(run["distance"][-1])
        found["distance_travelled"] = (way, "m", "distance travelled by the leading wheelset")
    if "steady" in run.attrs:
        words = "1: the run had become steady, 0: not by its end"
        found["steady"] = (int(run.attrs["steady"]), "1", words)
        words = "relative change over the last slab length"
        found["steady_change"] = (float(run.attrs["steady_change"]), "1", words)
    return xr.Dataset(
        {n: ((), value, {"units": unit, "long_name": w}) for n, (value, unit, w) in found.items()}
    )


def _unseen(run: xr.Dataset, choice: WindowChoice | None) -> list[str]:
    """Return what the statistics of a run do not tell: that it is not steady, events outside."""
    window, _ = window_of(run, choice)
    found: list[str] = []
    if not run.attrs.get("steady", 1):
        found.append("not steady at the end of the run (see steady_change)")
    events = events_outside(run, extremes(run), window)
    if events:
        found.append(f"outside the evaluation window ({window.text}): " + "; ".join(events))
    return found
