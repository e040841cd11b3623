"""The evaluation window of a run: which records statistics are made of, and how it is asked for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError, UnknownNameError

Array = NDArray[np.float64]
SETTLED_SHARE = 0.5
LONGEST = 200_000
"""Records at the end of a run that its evaluation window is chosen from."""

ATTRIBUTE = "evaluation_window"
"""Of a statistic in a data set: over what it was evaluated."""

OPTION = "window"
_ENTRIES = ("from", "to", "last_slabs")
_FEWEST = 2  # records
_REMEDY = "choose another window, or a longer distance"


@dataclasses.dataclass(frozen=True, kw_only=True)
class EvaluationWindow:
    """The part of a run that statistics are made of.

    Attributes
    ----------
    start, stop
        Distance travelled by the leading wheelset in m.
    rows
        The records in it.
    periods, of
        It is ``periods`` whole lengths of ``of``: ``"slab"`` or ``"bay"``;
        0 and ``""`` if it is shorter than a bay or the bay is not known.
    """

    start: float
    stop: float
    rows: slice
    periods: int = 0
    of: str = ""

    @property
    def text(self) -> str:
        """The window in words."""
        plural = "s" if self.periods > 1 else ""
        whole = f", {self.periods} whole {self.of} length{plural}" if self.periods else ""
        return f"{self.start:.2f} to {self.stop:.2f} m{whole}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class WindowChoice:
    """An evaluation window as a user asks for it; nothing given: the whole run.

    Attributes
    ----------
    start, stop
        Distance travelled in m; ``None`` for that of the first and of the last record.
    last_slabs
        The last so many slab lengths instead; ``None`` for a window by distance.

    Raises
    ------
    ParameterError
        For anything that makes no sense.
    """

    start: float | None = None
    stop: float | None = None
    last_slabs: int | None = None

    def __post_init__(self) -> None:
        for name, value in (("from", self.start), ("to", self.stop)):
            if value is None:
                continue
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise ParameterError(f"{OPTION}.{name}", value, "must be a number, in m")
            if not (math.isfinite(value) and value >= 0.0):
                raise ParameterError(f"{OPTION}.{name}", value, "must be at least 0 m")
            if self.last_slabs is not None:
                limit = "is a window by distance, last_slabs another one"
                raise ParameterError(f"{OPTION}.{name}", value, limit, "give one of them")
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            limit = f"must be less than {OPTION}.to = {self.stop:g} m"
            raise ParameterError(f"{OPTION}.from", self.start, limit)
        slabs = self.last_slabs
        if slabs is not None and (isinstance(slabs, bool) or not isinstance(slabs, int)):
            raise ParameterError(f"{OPTION}.last_slabs", slabs, "must be a whole number")
        if slabs is not None and slabs < 1:
            raise ParameterError(f"{OPTION}.last_slabs", slabs, "must be at least 1")

    @classmethod
    def of(cls, entries: Mapping[str, Any]) -> WindowChoice:
        """Return the choice that these entries make: ``from``, ``to`` (m) or ``last_slabs``.

        Raises
        ------
        ParameterError
            For an unknown entry, or a value that makes no sense.
        """
        for name, value in entries.items():
            if name not in _ENTRIES:
                raise UnknownNameError(
                    f"{OPTION}.{name}", value, _ENTRIES, "entry", name, listed=True
                )
        return cls(
            start=entries.get("from"), stop=entries.get("to"), last_slabs=entries.get("last_slabs")
        )

    @property
    def text(self) -> str:
        """The choice in words."""
        if self.last_slabs is not None:
            return (
                "last slab length"
                if self.last_slabs == 1
                else f"last {self.last_slabs} slab lengths"
            )
        if self.start is None and self.stop is None:
            return "whole run"
        stop = "the end" if self.stop is None else f"{self.stop:g} m"
        return f"distance travelled {self.start or 0.0:g} m to {stop}"

    def check(self, end: float) -> None:
        """Refuse a window that goes beyond the end of a run at this distance (m).

        Raises
        ------
        ParameterError
            If it does.
        """
        for name, value in (("from", self.start), ("to", self.stop)):
            if value is not None and value > end:
                limit = f"the run ends at {end:.4g} m"
                raise ParameterError(f"{OPTION}.{name}", value, limit, _REMEDY)

    def on(self, run: xr.Dataset) -> EvaluationWindow:
        """Return the window that this is in a run.

        Raises
        ------
        ParameterError
            If the run does not have it.
        """
        if self.last_slabs is not None:
            return last_slabs(run, self.last_slabs)
        distance = distances(run)
        step = (distance[-1] - distance[0]) / (len(distance) - 1)
        start = distance[0] if self.start is None else self.start
        stop = distance[-1] if self.stop is None else self.stop
        self.check(float(distance[-1] + 1.5 * step))  # a run may end within a step of its distance
        first, last = np.searchsorted(distance, (start - 1e-9, stop + 1e-9))
        if last - first < _FEWEST:
            limit = f"there are {last - first} records from there to {stop:.6g} m"
            raise ParameterError(f"{OPTION}.from", float(start), limit, _REMEDY)
        rows = slice(int(first), int(last))
        return EvaluationWindow(
            start=float(distance[first]), stop=float(distance[last - 1]), rows=rows
        )


def distances(dataset: xr.Dataset) -> Array:
    """Return the distance travelled by the leading wheelset in m, shape (n,).

    For a vehicle without the output of its position it is speed times time.
    """
    if "distance" in dataset:
        return dataset["distance"].to_numpy()
    return dataset["time"].to_numpy() * float(dataset.attrs["speed_km_h"]) / 3.6


def last_records(dataset: xr.Dataset) -> xr.Dataset:
    """Return the last :data:`LONGEST` records of a run, all of a shorter one."""
    if dataset.sizes.get("time", 0) <= LONGEST:
        return dataset
    return dataset.isel(time=slice(-LONGEST, None))


def time_between(dataset: xr.Dataset) -> float:
    """Return the time between two records in s, on average."""
    time = dataset["time"]
    return float(time[-1] - time[0]) / (time.size - 1)


def periods(dataset: xr.Dataset) -> tuple[float, float]:
    """Return bay length and slab pitch in m from the track's parameters; NaN if not known."""
    about = dataset.attrs
    bay = float(about.get("track.fastener.spacing", math.nan))
    return bay, bay * float(about.get("track.fastener.count_per_slab", math.nan))


def choose_window(distance: Array, bay: float, slab: float) -> EvaluationWindow:
    """Return the last whole slab lengths (or bays) in the second half of a run.

    Parameters
    ----------
    distance
        Distance travelled in m, shape (n,).
    bay, slab
        Lengths in m; NaN if not known.
    """
    end = float(distance[-1])
    settled = (1.0 - SETTLED_SHARE) * (end - float(distance[0]))
    for of, length in (("slab", slab), ("bay", bay)):
        # Comparisons with NaN are false: lengths that are not known are passed over.
        if length > 0.0 and settled >= length:
            count = int(settled / length * (1.0 + 1e-9))
            start = end - count * length
            # Half-open, so that the end points of a period are not counted twice.
            first = int(np.searchsorted(distance, start + 1e-9 * length, side="right"))
            rows = slice(first, len(distance))
            return EvaluationWindow(start=start, stop=end, rows=rows, periods=count, of=of)
    first = min(int(np.searchsorted(distance, end - settled)), len(distance) - 2)
    return EvaluationWindow(
        start=float(distance[first]), stop=end, rows=slice(first, len(distance))
    )


def evaluation_window(dataset: xr.Dataset) -> EvaluationWindow:
    """Return the window that the statistics of a run are made of unless another is asked for.

    Of a run that ended because it was steady the last two slab lengths, over which that was
    found; else the last whole slab lengths (bays, in a short run) within the second half of the
    distance, the first half being left to the initial transients. Of a long run only the last
    :data:`LONGEST` records count.
    """
    if dataset.attrs.get("steady", 0):
        return last_slabs(dataset, 2)
    tail = last_records(dataset)
    before = dataset.sizes["time"] - tail.sizes["time"]
    window = choose_window(distances(tail), *periods(dataset))
    rows = slice(window.rows.start + before, window.rows.stop + before)
    return dataclasses.replace(window, rows=rows)


def last_slabs(run: xr.Dataset, slabs: int = 1) -> EvaluationWindow:
    """Return the window of the last slab lengths, a whole number of records.

    One slab length is the second half of a run that is too short for it, or of a track that
    does not tell its slabs.

    Raises
    ------
    ParameterError
        If there are not so many.
    """
    distance, step = distances(run), time_between(run)
    count, pitch = len(distance), periods(run)[1]
    speed = (distance[-1] - distance[0]) / (step * (count - 1))
    if pitch > 0.0 and round(slabs * pitch / speed / step) < count:
        first, whole = count - round(slabs * pitch / speed / step), slabs
    elif slabs == 1:
        first, whole = int((1.0 - SETTLED_SHARE) * count), 0
    else:
        held = int((distance[-1] - distance[0]) / pitch) if pitch > 0.0 else 0
        limit = f"the run has {held} whole slab lengths" if held else "the run has no slab lengths"
        raise ParameterError(f"{OPTION}.last_slabs", slabs, limit, _REMEDY)
    return EvaluationWindow(
        start=float(distance[max(first - 1, 0)]) if whole else float(distance[first]),
        stop=float(distance[-1]),
        rows=slice(first, count),
        periods=whole,
        of="slab" if whole else "",
    )
