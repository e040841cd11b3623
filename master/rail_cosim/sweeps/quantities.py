"""Scalars of a run: statistics of its variables over an evaluation window."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.postprocessing.filters import low_pass
from rail_cosim.postprocessing.statistics import half_range_below_limit
from rail_cosim.window import ATTRIBUTE, EvaluationWindow, WindowChoice, periods, time_between

Array = NDArray[np.float64]
_PERCENTILE = re.compile(r"p(?P<percent>\d+(?:\.\d+)?)(?P<filtered>_20_hz)?", re.ASCII)


def _dominant_frequency(values: Array, step: float) -> Array:
    """Frequency of the largest line; over one period of the motion its lines are exact."""
    lines = np.abs(np.fft.rfft(values - values.mean(axis=0), axis=0))
    found = np.fft.rfftfreq(len(values), step)[lines.argmax(axis=0)]
    return np.where(lines.max(axis=0) > 0.0, found, np.nan)


def _slab_peak(values: Array, bays: int) -> Array:
    """Largest magnitude of what is left without the mean and what repeats from bay to bay.

    Over ``bays`` bays the latter are the mean and the harmonics of the fastener passing: each
    ``bays``-th line.
    """
    lines = np.fft.rfft(values, axis=0)
    lines[::bays] = 0.0
    return np.abs(np.fft.irfft(lines, len(values), axis=0)).max(axis=0)


STATISTICS: Mapping[str, tuple[Callable[[Array, float], Array], str, str]] = {
    "max": (lambda x, dt: x.max(axis=0), "", "largest"),
    "min": (lambda x, dt: x.min(axis=0), "", "smallest"),
    "mean": (lambda x, dt: x.mean(axis=0), "", "mean"),
    "half_range": (lambda x, dt: 0.5 * np.ptp(x, axis=0), "", "amplitude (half peak-to-peak) of"),
    "half_range_500_hz": (
        half_range_below_limit,
        "",
        "amplitude (half peak-to-peak) below 500 Hz of",
    ),
    "rms": (lambda x, dt: x.std(axis=0), "", "root mean square, without the mean, of"),
    "peak": (lambda x, dt: np.abs(x).max(axis=0), "", "largest magnitude of"),
    "lift_off_time": (lambda x, dt: (x <= 0.0).sum(axis=0) * dt, "s", "time without"),
    "dominant_frequency": (_dominant_frequency, "Hz", "frequency of the largest component of"),
}
"""Function of records (first axis time) and time between them, unit ("" for the
variable's own) and words, by name."""

SLAB_PEAK = "slab_peak"
"""Statistic of its own: it needs to know how many bays a slab has."""

NAMES = (*STATISTICS, SLAB_PEAK)
"""All statistics but the percentiles."""

PERIODIC = ("half_range_500_hz", SLAB_PEAK)
"""Those that are taken from whole slab lengths: their Fourier terms must be periodic."""


def window_of(run: xr.Dataset, choice: WindowChoice | None) -> tuple[EvaluationWindow, str]:
    """Return the window over which a run of a sweep is evaluated, and what it is in words.

    Unless one is chosen it is the last slab length of a run that was to become steady, and the
    whole run of another one.

    Raises
    ------
    ParameterError
        If the run does not have the window that was chosen.
    """
    if choice is None:
        choice = WindowChoice(last_slabs=1) if "steady" in run.attrs else WindowChoice()
    return choice.on(run), choice.text


def evaluate(
    run: xr.Dataset, keep: Mapping[str, Sequence[str]], choice: WindowChoice | None = None
) -> xr.Dataset:
    """Return the statistics of a run over a window.

    Parameters
    ----------
    run
        Dataset of a run, with two records or more.
    keep
        Names of :data:`NAMES`, or percentiles (:func:`is_statistic`), by variable.
    choice
        The window; ``None``: see :func:`window_of`.

    Returns
    -------
    xarray.Dataset
        ``variable_statistic`` with the variable's dimensions but time; the attribute
        ``evaluation_window`` says over what.

    Raises
    ------
    UnknownNameError
        For a variable that the run does not have.
    ParameterError
        If the run does not have the window, or if a statistic needs another one.
    """
    window, text = window_of(run, choice)
    step = time_between(run)
    found = xr.Dataset()
    for name, statistics in keep.items():
        records = chosen(run, name, "keep")
        dimensions = [d for d in records.dims if d != "time"]
        for statistic in statistics:
            filtered, function, unit, words = _statistic(statistic, run, window)
            part = filtered(records).isel(time=window.rows).transpose("time", *dimensions)
            about = {
                "units": unit or records.attrs.get("units", "1"),
                "long_name": f"{words} {records.attrs.get('long_name', name)}",
                ATTRIBUTE: text,
            }
            values = function(part.to_numpy(), step)
            found[f"{name}_{statistic}"] = (dimensions, values, about)
    return found.assign_coords({d: run[d] for d in found.dims if d in run.coords})


def is_statistic(name: str) -> bool:
    """Say whether there is a statistic of this name.

    Beside :data:`NAMES` these are percentiles, ``p99.85``, and percentiles after the low-pass of
    EN 14363, ``p99.85_20_hz``.
    """
    match = _PERCENTILE.fullmatch(name)
    return name in NAMES or (match is not None and float(match["percent"]) <= 100.0)


def _statistic(
    name: str, run: xr.Dataset, window: EvaluationWindow
) -> tuple[Callable[[xr.DataArray], xr.DataArray], Callable[[Array, float], Array], str, str]:
    """Return what is done with all records, and what with those in the window; unit and words."""
    if match := _PERCENTILE.fullmatch(name):
        percent = float(match["percent"])
        words = f"{match['percent']} % percentile of"
        if match["filtered"]:
            words = f"{match['percent']} % percentile, after the low-pass 20 Hz, of"
        return (
            low_pass if match["filtered"] else lambda x: x,
            lambda x, dt: np.percentile(x, percent, axis=0),
            "",
            words,
        )
    if name in PERIODIC and window.periods == 0 and periods(run)[1] > 0.0:
        remedy = "choose last_slabs in [window], or leave this statistic out"
        raise ParameterError("keep", name, "is taken from whole slab lengths", remedy)
    if name != SLAB_PEAK:
        return lambda x: x, *STATISTICS[name]
    bay, slab = periods(run)
    if not bay > 0.0:
        remedy = "leave this statistic out"
        raise ParameterError("keep", name, "the track does not tell its fastener spacing", remedy)
    words = "largest magnitude, without what repeats from bay to bay, of"
    bays = round(slab / bay) * window.periods
    return lambda x: x, lambda x, dt: _slab_peak(x, bays), "", words


def histories(run: xr.Dataset, names: Sequence[str], every: int) -> xr.Dataset:
    """Return each ``every``-th record of some variables, by number, and their time.

    Not over time: the step is another at each speed (see :mod:`rail_cosim.steady`).

    Raises
    ------
    UnknownNameError
        For a variable that the run does not have.
    """
    if not names:
        return xr.Dataset()
    found = {f"{name}_history": chosen(run, name, "history") for name in names}
    found["time_history"] = run["time"].reset_coords(drop=True)
    records = xr.Dataset(found).isel(time=slice(None, None, every))
    return records.drop_vars("time").rename_dims(time="record")


def chosen(run: xr.Dataset, name: str, option: str) -> xr.DataArray:
    """Return a variable of a run that has the dimension time.

    Raises
    ------
    UnknownNameError
        If there is none of this name.
    """
    known = [str(known) for known, array in run.data_vars.items() if "time" in array.dims]
    if name not in known:
        raise UnknownNameError(option, name, known, "variable in a run", name)
    return run[name]
