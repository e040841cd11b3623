"""Sections with forces and accelerations over the way."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rail_cosim.postprocessing import flange_climbing, sum_of_guiding_forces
from rail_cosim.reporting.charts import COLOURS, Chart, chart, line
from rail_cosim.reporting.sections import Figure, Section, need
from rail_cosim.results import SIDES
from rail_cosim.window import EvaluationWindow, distances

WAY = "way of the leading wheelset (m)"


def forces(run: xr.Dataset, chosen: EvaluationWindow) -> Section:
    """Return the section of wheel forces."""
    section = Section(
        title="Wheel forces",
        intro="Grey: the part that figures and spectra are taken from. Drag to zoom, double-click "
        "to go back; click a name to show or hide it.",
    )
    names = ("vertical_wheel_force", "normal_force")
    section.add(lambda: _whole(run, chosen, need(run, *names), "wheel force Q", "kN", 1e-3))
    section.add(lambda: _end(run, chosen, need(run, *names), "wheel force Q", "kN", 1e-3))
    section.add(
        lambda: _whole(run, chosen, need(run, "guiding_force"), "guiding force Y", "kN", 1e-3)
    )
    section.add(
        lambda: _whole(run, chosen, sum_of_guiding_forces(run), "sum of guiding forces", "kN", 1e-3)
    )
    section.add(lambda: _whole(run, chosen, flange_climbing(run), "Y/Q, Y outwards", "", 1.0))
    return section


def accelerations(run: xr.Dataset, chosen: EvaluationWindow) -> Section:
    """Return the section of accelerations."""
    section = Section(title="Accelerations")
    boxes = "axle_box_vertical_acceleration"
    section.add(lambda: _whole(run, chosen, need(run, boxes), "axle boxes, vertical", "m/s²", 1.0))
    section.add(lambda: _end(run, chosen, need(run, boxes), "axle boxes, vertical", "m/s²", 1.0))
    for title, name in (
        ("bogie frames, vertical", "bogie_vertical_acceleration"),
        ("bogie frames, lateral", "bogie_lateral_acceleration"),
    ):
        section.add(lambda t=title, n=name: _whole(run, chosen, need(run, n), t, "m/s²", 1.0))
    for direction in ("vertical", "lateral"):
        names = (
            f"car_body_floor_{direction}_acceleration",
            f"car_body_{direction}_acceleration",
        )
        title = f"car body, {direction}"
        section.add(lambda t=title, n=names: _whole(run, chosen, need(run, *n), t, "m/s²", 1.0))
    return section


def channels(array: xr.DataArray) -> list[tuple[str, xr.DataArray, str, str, bool]]:
    """Return the channels of a variable: name, values, colour, dash, whether shown at first.

    Of the wheels the left ones are shown at first: on straight track they are nearly alike.
    """
    array = array.transpose("time", ...) if "time" in array.dims else array
    others = [str(d) for d in array.dims if d in ("wheelset", "bogie", "floor_place")]
    sides = "side" in array.dims
    found = []
    for number in range(array.sizes[others[0]] if others else 1):
        one = array.isel({others[0]: number}) if others else array
        name = _name(others[0], number) if others else str(array.name or "")
        colour = COLOURS[number % len(COLOURS)]
        if not sides:
            found.append((name, one, colour, "solid", True))
            continue
        for side, word in enumerate(SIDES):
            dash = "solid" if side == 0 else "dot"
            found.append((f"{name} {word}", one.isel(side=side), colour, dash, side == 0))
    return found


def _name(dimension: str, number: int) -> str:
    if dimension == "floor_place":
        words = ("over leading bogie", "half way", "over trailing bogie")
        return words[number] if number < len(words) else f"place {number + 1}"
    return f"{dimension} {number + 1}"


def _lines(
    way: np.ndarray, array: xr.DataArray, factor: float, rows: slice = slice(None)
) -> list[Chart]:
    return [
        line(
            way[rows],
            values.to_numpy()[rows] * factor,
            name,
            colour=colour,
            dash=dash,
            shown=shown,
        )
        for name, values, colour, dash, shown in channels(array)
    ]


def _titled(title: str, unit: str) -> str:
    return f"{title} ({unit})" if unit else title


def _whole(
    run: xr.Dataset,
    chosen: EvaluationWindow,
    array: xr.DataArray,
    title: str,
    unit: str,
    factor: float,
) -> Figure:
    drawn = chart(
        _lines(distances(run), array, factor),
        x=WAY,
        y=_titled(title, unit),
        shaded=(chosen.start, chosen.stop),
    )
    return Figure(title=f"{title[0].upper()}{title[1:]} over the way", chart=drawn)


def _end(
    run: xr.Dataset,
    chosen: EvaluationWindow,
    array: xr.DataArray,
    title: str,
    unit: str,
    factor: float,
) -> Figure:
    """Draw the last whole length of the evaluated part, every record."""
    length = (chosen.stop - chosen.start) / max(1, chosen.periods or 10)
    way = distances(run)
    rows = slice(int(np.searchsorted(way, chosen.stop - length)), len(way))
    what = f"last {chosen.of} length" if chosen.periods else "the end"
    drawn = chart(_lines(way, array, factor, rows), x=WAY, y=_titled(title, unit), height=320)
    return Figure(title=f"{title[0].upper()}{title[1:]}, {what}", chart=drawn)
