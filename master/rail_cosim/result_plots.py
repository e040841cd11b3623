"""Plots of a run with matplotlib: histories and spectra."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.postprocessing import amplitude_spectrum, static_wheel_load, sum_of_guiding_forces
from rail_cosim.presentation import (
    channels,
    label,
    shown_unit,
    title,
    without_round_off,
)
from rail_cosim.results import SIDES
from rail_cosim.window import WindowChoice, distances, evaluation_window, periods

_SIZE = (8.4, 4.2)
_HIGHEST = 500.0  # Hz, shown at first
_DASHES = {"solid": "-", "dot": ":"}
_VERSUS = {"distance": "distance travelled (m)", "time": "time (s)"}


def draw_history(
    run: xr.Dataset,
    variable: str,
    *,
    versus: str = "distance",
    wheelset: int | None = None,
    side: str = "left",
    ax: Axes | None = None,
) -> Axes:
    """Draw a variable versus distance or time (see :class:`rail_cosim.run_result.RunResult`)."""
    if versus not in _VERSUS:
        raise ParameterError("versus", versus, "must be distance or time")
    array = _chosen(run, variable, wheelset, side)
    x = distances(run) if versus == "distance" else run["time"].to_numpy()
    ax = _axes(ax)
    _lines(ax, array, x)
    ax.set_xlabel(_VERSUS[versus])
    ax.set_ylabel(label(array))
    ax.set_xlim(float(x[0]), float(x[-1]))
    # Above the axes: inside it would lie over a peak.
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}
    ax.legend(**place, ncols=4, fontsize="small", frameon=False)
    return ax


def draw_spectrum(
    run: xr.Dataset,
    variable: str,
    *,
    window: tuple[float, float] | None,
    wheelset: int | None,
    side: str,
    ax: Axes | None,
) -> Axes:
    """Draw an amplitude spectrum (see :class:`rail_cosim.run_result.RunResult`)."""
    chosen = evaluation_window(run)
    if window is not None:
        chosen = WindowChoice(start=float(window[0]), stop=float(window[1])).on(run)
    part = run.isel(time=chosen.rows)
    array = _chosen(part, variable, wheelset, side)
    found = amplitude_spectrum(array).rename(frequency="time")  # the channels' first dimension
    frequency = found["time"].to_numpy()
    ax = _axes(ax)
    _lines(ax, found, frequency)
    ax.set_xlabel("frequency (Hz)")
    ax.set_ylabel(f"amplitude ({shown_unit(array)[0]})")
    ax.set_title(f"{title(array)}, {chosen.text}", loc="left", fontsize="medium")
    ax.set_xlim(0.0, min(_HIGHEST, float(frequency[-1])))
    ax.set_ylim(bottom=0.0)
    ax.legend(loc="upper right", fontsize="small", frameon=False)
    _passing_frequencies(ax, part)
    return ax


def _passing_frequencies(ax: Axes, part: xr.Dataset) -> None:
    way, time = distances(part), part["time"].to_numpy()
    speed = float((way[-1] - way[0]) / (time[-1] - time[0]))
    for length, words in zip(periods(part), ("fastener passing", "slab passing"), strict=True):
        if math.isnan(length):
            continue
        ax.axvline(speed / length, color="0.5", lw=0.8, ls="--", zorder=0)
        ax.annotate(
            words,
            (speed / length, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -4),
            textcoords="offset points",
            rotation=90,
            va="top",
            fontsize="small",
            color="0.35",
        )


def _axes(ax: Axes | None) -> Axes:
    return ax if ax is not None else plt.subplots(figsize=_SIZE, layout="constrained")[1]


def _lines(ax: Axes, array: xr.DataArray, x: np.ndarray) -> None:
    factor = shown_unit(array)[1]
    for name, values, colour, dash, _ in channels(array):
        style = _DASHES[dash]
        ax.plot(x, values.to_numpy() * factor, color=colour, ls=style, lw=0.9, label=name)
    ax.grid(visible=True, lw=0.3, color="0.8")


def _chosen(run: xr.Dataset, variable: str, wheelset: int | None, side: str) -> xr.DataArray:
    """Return the records that were asked for, without round-off."""
    array = _variable(run, variable)
    if "side" in array.dims and side != "both":
        if side not in SIDES:
            raise ParameterError("side", side, "must be left, right or both")
        array = array.isel(side=[SIDES.index(side)])
    if wheelset is not None:
        count = array.sizes.get("wheelset", 0)
        if count == 0:
            raise ParameterError("wheelset", wheelset, f"{variable} is not of a wheelset")
        if not 1 <= wheelset <= count:
            raise ParameterError("wheelset", wheelset, f"must be from 1 to {count}")
        array = array.isel(wheelset=[wheelset - 1])
    return without_round_off(array, static_wheel_load(run))


def _variable(run: xr.Dataset, name: str) -> xr.DataArray:
    if name == "track_shifting_force":
        return sum_of_guiding_forces(run).rename(name)
    if name in run.data_vars and "time" in run[name].dims:
        return run[name]
    there = [str(one) for one, values in run.data_vars.items() if "time" in values.dims]
    raise UnknownNameError("variable", name, there, "variable over time in this run", name)
