"""Sections with forces and accelerations versus distance travelled."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rail_cosim.postprocessing import flange_climbing, static_wheel_load, sum_of_guiding_forces
from rail_cosim.presentation import (
    channels,
    label,
    shown_unit,
    title,
    without_round_off,
)
from rail_cosim.reporting.charts import Chart, chart, line
from rail_cosim.reporting.sections import Figure, Section, need
from rail_cosim.window import EvaluationWindow, distances

DISTANCE = "distance travelled (m)"
FORCES = ("vertical_wheel_force", "normal_force")
BOX = "axle_box_vertical_acceleration"
_ACCELERATIONS = (
    ("bogie_vertical_acceleration",),
    ("bogie_lateral_acceleration",),
    ("car_body_floor_vertical_acceleration", "car_body_vertical_acceleration"),
    ("car_body_floor_lateral_acceleration", "car_body_lateral_acceleration"),
)
_AROUND = (0.5, 1.5)  # m before and after the largest value


def forces(run: xr.Dataset, window: EvaluationWindow) -> Section:
    """Return the section of wheel forces."""
    section = Section(
        title="Wheel forces",
        intro="Grey: the evaluation window, of which statistics and spectra are made. Distances "
        "are those travelled by the leading wheelset. Y is positive to the right. Drag to zoom, "
        "double-click to go back; click a name to show or hide it.",
    )
    section.add(lambda: _whole(run, window, need(run, *FORCES)))
    section.add(lambda: _largest(run, need(run, *FORCES)))
    section.add(lambda: _end(run, window, need(run, *FORCES)))
    section.add(lambda: _whole(run, window, need(run, "guiding_force")))
    section.add(lambda: _whole(run, window, track_shifting_force(run)))
    section.add(lambda: _whole(run, window, flange_climbing(run)))
    return section


def accelerations(run: xr.Dataset, window: EvaluationWindow) -> Section:
    """Return the section of accelerations."""
    section = Section(title="Accelerations")
    section.add(lambda: _whole(run, window, need(run, BOX)))
    section.add(lambda: _largest(run, need(run, BOX)))
    section.add(lambda: _end(run, window, need(run, BOX)))
    for names in _ACCELERATIONS:
        section.add(lambda n=names: _whole(run, window, need(run, *n)))
    return section


def track_shifting_force(run: xr.Dataset) -> xr.DataArray:
    """Return the sum of Y of each wheelset, 0 where it is round-off of the two."""
    total = sum_of_guiding_forces(run).rename("track_shifting_force")
    return without_round_off(total, static_wheel_load(run))


def _lines(distance: np.ndarray, array: xr.DataArray, rows: slice = slice(None)) -> list[Chart]:
    factor = shown_unit(array)[1]
    return [
        line(
            distance[rows],
            one.values.to_numpy()[rows] * factor,
            one.name,
            colour=one.colour,
            dash=one.dash,
            shown=one.shown,
        )
        for one in channels(array)
    ]


def _words(array: xr.DataArray) -> str:
    words = title(array)
    return words[0].upper() + words[1:]


def _whole(run: xr.Dataset, window: EvaluationWindow, array: xr.DataArray) -> Figure:
    drawn = chart(
        _lines(distances(run), array),
        x=DISTANCE,
        y=label(array),
        shaded=(window.start, window.stop),
    )
    return Figure(title=_words(array), chart=drawn)


def _largest(run: xr.Dataset, array: xr.DataArray) -> Figure:
    """Draw what is around the largest magnitude of the run, every record."""
    sizes = np.abs(array.transpose("time", ...).to_numpy()).reshape(array.sizes["time"], -1)
    distance = distances(run)
    place = float(distance[np.unravel_index(np.nanargmax(sizes), sizes.shape)[0]])
    first, last = np.searchsorted(distance, (place - _AROUND[0], place + _AROUND[1]))
    drawn = chart(
        _lines(distance, array, slice(int(first), int(last))),
        x=DISTANCE,
        y=label(array),
        height=320,
    )
    return Figure(title=f"{_words(array)}, around the largest value, at {place:.2f} m", chart=drawn)


def _end(run: xr.Dataset, window: EvaluationWindow, array: xr.DataArray) -> Figure:
    """Draw the last whole length of the evaluation window, every record."""
    length = (window.stop - window.start) / max(1, window.periods or 10)
    distance = distances(run)
    rows = slice(int(np.searchsorted(distance, window.stop - length)), len(distance))
    what = f"last {window.of} length" if window.periods else "the end"
    drawn = chart(_lines(distance, array, rows), x=DISTANCE, y=label(array), height=320)
    return Figure(title=f"{_words(array)}, {what}", chart=drawn)
