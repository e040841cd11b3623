"""Extremes and losses of contact of each wheel over all records of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.window import distances, time_between

Array = NDArray[np.float64]
FORCE, BOX = "normal_force", "axle_box_vertical_acceleration"
CHUNK = 65_536
"""Records in memory at a time."""

_SCORES: dict[str, tuple[str, Callable[[Array], Array], Callable[[Array], Array], str]] = {
    "wheel_force_max": (FORCE, np.positive, np.positive, "largest wheel force"),
    "wheel_force_min": (FORCE, np.negative, np.negative, "smallest wheel force"),
    "axle_box_acceleration_peak": (BOX, np.abs, np.positive, "peak axle-box acceleration"),
}
"""Variable, function whose largest value is looked for and back from it, words, by name."""


def wheels(dataset: xr.Dataset, name: str) -> Array:
    """Return records of a variable, shape (n, wheelset, side); NaN (n, 1, 1) if there are none."""
    if name not in dataset:
        return np.full((dataset.sizes["time"], 1, 1), math.nan)
    return dataset[name].transpose("time", "wheelset", "side").to_numpy()


def labelled(values: NDArray[Any], unit: str, words: str) -> xr.Variable:
    """Return values of the wheels (wheelset, side) with their unit and meaning."""
    return xr.Variable(("wheelset", "side"), values, {"units": unit, "long_name": words})


def extremes(dataset: xr.Dataset) -> xr.Dataset:
    """Return extremes and losses of contact over all records, read part by part.

    Parameters
    ----------
    dataset
        A run of two records or more.

    Returns
    -------
    xarray.Dataset
        Dimensions (wheelset, side). ``wheel_force_max``, ``wheel_force_min`` (N) and
        ``axle_box_acceleration_peak`` (m/s2), each with the distance travelled by the leading
        wheelset at that instant (``_distance``, m); ``loss_of_contact_count`` and the
        ``_longest`` and ``_total`` duration (s). Without what the run does not have.
    """
    scores = {name: about for name, about in _SCORES.items() if about[0] in dataset}
    best = {name: _Largest() for name in scores}
    lost: list[NDArray[np.intp]] = []
    shape = ()
    for start in range(0, dataset.sizes["time"], CHUNK):
        part = dataset.isel(time=slice(start, start + CHUNK))
        way = distances(part)
        values = {name: wheels(part, name) for name in (FORCE, BOX) if name in part}
        for name, (variable, score, _, _) in scores.items():
            best[name].take(score(values[variable]), way)
        if FORCE in values:
            shape = values[FORCE].shape[1:]
            lost.append(np.argwhere(values[FORCE] <= 0.0) + np.array([start, 0, 0]))
    found = xr.Dataset()
    for name, (_, _, value, words) in scores.items():
        unit = "N" if name.startswith("wheel_force") else "m/s2"
        found[name] = labelled(value(best[name].score), unit, words)
        words = f"distance travelled at the {words}"
        found[f"{name}_distance"] = labelled(best[name].distance, "m", words)
    if shape:
        found.update(_losses(np.concatenate(lost), shape, time_between(dataset)))
    return found.assign_coords(
        {d: dataset[d] for d in ("wheelset", "side") if d in dataset.coords and d in found.dims}
    )


class _Largest:
    """The largest score so far and the distance there, by wheel; NaN counts for nothing."""

    def __init__(self) -> None:
        self.score = self.distance = np.array(math.nan)

    def take(self, scores: Array, distance: Array) -> None:
        """Take in scores (n, wheelset, side) at these distances (n,)."""
        rows = np.where(np.isnan(scores), -np.inf, scores).argmax(axis=0)
        largest = np.take_along_axis(scores, rows[np.newaxis], axis=0)[0]
        better = ~np.isnan(largest) & ~(largest <= self.score)  # a number is better than none
        self.score = np.where(better, largest, self.score)
        self.distance = np.where(better, distance[rows], self.distance)


def _losses(lost: NDArray[np.intp], shape: tuple[int, ...], step: float) -> xr.Dataset:
    """Return number and durations of the losses of contact at these records (time, wheelset, side).

    Successive records without force are one loss; each stands for the time to the next one.
    """
    count = np.zeros(shape, dtype=np.int64)
    longest, total = np.zeros(shape), np.zeros(shape)
    for wheel in np.ndindex(*shape):
        records = lost[(lost[:, 1:] == wheel).all(axis=1), 0]
        if len(records):
            runs = np.split(records, np.flatnonzero(np.diff(records) > 1) + 1)
            count[wheel] = len(runs)
            longest[wheel] = max(len(run) for run in runs) * step
            total[wheel] = len(records) * step
    return xr.Dataset(
        {
            "loss_of_contact_count": labelled(count, "1", "number of losses of contact"),
            "loss_of_contact_longest": labelled(longest, "s", "longest loss of contact"),
            "loss_of_contact_total": labelled(total, "s", "total duration of losses of contact"),
        }
    )
