"""Scalars of a run: statistics of its variables over the last slab length."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.summary import SETTLED_SHARE, distances, periods

Array = NDArray[np.float64]
BAND_LIMIT = 500.0  # Hz


def _dominant_frequency(values: Array, step: float) -> Array:
    """Frequency of the largest line; over one period of the motion its lines are exact."""
    lines = np.abs(np.fft.rfft(values - values.mean(axis=0), axis=0))
    found = np.fft.rfftfreq(len(values), step)[lines.argmax(axis=0)]
    return np.where(lines.max(axis=0) > 0.0, found, np.nan)


def half_range_below_limit(values: Array, step: float) -> Array:
    """Half the peak to peak of the Fourier terms up to 500 Hz, as instrumented wheelsets give it.

    ``values`` (time, ...) over one period of the motion, ``step`` s apart.
    """
    lines = np.fft.rfft(values, axis=0)
    lines[np.fft.rfftfreq(len(values), step) > BAND_LIMIT] = 0.0
    return 0.5 * np.ptp(np.fft.irfft(lines, len(values), axis=0), axis=0)


def _slab_peak(values: Array, bays: int) -> Array:
    """Largest magnitude of what is left without the mean and what repeats from bay to bay.

    Over one slab length the latter are the mean and the harmonics of the sleeper passing: each
    ``bays``-th line.
    """
    lines = np.fft.rfft(values, axis=0)
    lines[::bays] = 0.0
    return np.abs(np.fft.irfft(lines, len(values), axis=0)).max(axis=0)


STATISTICS: Mapping[str, tuple[Callable[[Array, float], Array], str, str]] = {
    "max": (lambda x, dt: x.max(axis=0), "", "largest"),
    "min": (lambda x, dt: x.min(axis=0), "", "smallest"),
    "mean": (lambda x, dt: x.mean(axis=0), "", "mean"),
    "half_range": (lambda x, dt: 0.5 * np.ptp(x, axis=0), "", "half the peak to peak of"),
    "half_range_500_hz": (half_range_below_limit, "", "half the peak to peak below 500 Hz of"),
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
"""All statistics."""


def last_slab(run: xr.Dataset) -> slice:
    """Return the records of the last slab length; of the last half of a run too short for it."""
    time = run["time"].to_numpy()
    step = (time[-1] - time[0]) / (len(time) - 1)
    way = distances(run)
    speed = (way[-1] - way[0]) / (time[-1] - time[0])
    pitch = periods(run)[1]
    count = len(time)
    if pitch > 0.0 and round(pitch / speed / step) < count:
        return slice(count - round(pitch / speed / step), count)
    return slice(int((1.0 - SETTLED_SHARE) * count), count)


def evaluate(run: xr.Dataset, keep: Mapping[str, Sequence[str]]) -> xr.Dataset:
    """Return the statistics of a run over its last slab length.

    Parameters
    ----------
    run
        Dataset of a run, with two records or more.
    keep
        Names of :data:`NAMES` by variable.

    Returns
    -------
    xarray.Dataset
        ``variable_statistic`` with the variable's dimensions but time.

    Raises
    ------
    UnknownNameError
        For a variable that the run does not have.
    """
    rows = last_slab(run)
    time = run["time"].to_numpy()
    step = float((time[-1] - time[0]) / (len(time) - 1))
    found = xr.Dataset()
    for name, statistics in keep.items():
        records = chosen(run, name, "keep").isel(time=rows)
        dimensions = [d for d in records.dims if d != "time"]
        values = records.transpose("time", *dimensions).to_numpy()
        for statistic in statistics:
            function, unit, words = _statistic(statistic, run)
            about = {
                "units": unit or records.attrs.get("units", "1"),
                "long_name": f"{words} {records.attrs.get('long_name', name)}, last slab length",
            }
            found[f"{name}_{statistic}"] = (dimensions, function(values, step), about)
    return found.assign_coords({d: run[d] for d in found.dims if d in run.coords})


def _statistic(name: str, run: xr.Dataset) -> tuple[Callable[[Array, float], Array], str, str]:
    if name != SLAB_PEAK:
        return STATISTICS[name]
    bay, slab = periods(run)
    if not bay > 0.0:
        remedy = "leave this statistic out"
        raise ParameterError("keep", name, "the track does not tell its sleeper bay", remedy)
    words = "largest magnitude, without what repeats from bay to bay, of"
    return lambda x, dt: _slab_peak(x, round(slab / bay)), "", words


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
