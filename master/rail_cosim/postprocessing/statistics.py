r"""Figures that describe forces on the rails and motion of the car body.

Of a wheel, with Q its vertical force, Q0 the static one, Y its lateral force:

- dynamic factor: largest Q over Q0;
- wheel unloading: (Q0 - smallest Q) / Q0, 1 when the wheel lifts off (dQ/Q0 of EN 14363);
- Y/Q, Y positive towards the outside of the rail, where it makes the flange climb;
- track shifting force: the sum of Y of a wheelset (EN 14363, running safety; Prud'homme's limit is
  10 kN + 2 Q0/3).

Each is given for the signals as they are, and as EN 14363 evaluates them: low-pass 20 Hz, guiding
forces as means over 2 m, percentiles 0.15 % and 99.85 %.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing.filters import (
    EN14363_LOW_PASS,
    EN14363_WINDOW,
    low_pass,
    moving_mean,
    percentiles,
)
from rail_cosim.postprocessing.signals import Array, time_step
from rail_cosim.window import distances, evaluation_window, last_slabs

BAND_LIMIT = 500.0  # Hz
_LOADS = ("vehicle.static_wheel_load", "track.static_wheel_load")


def evaluated(dataset: xr.Dataset) -> slice:
    """Return the records of the evaluation window of a run.

    It is that of :func:`rail_cosim.window.evaluation_window`.

    Raises
    ------
    ParameterError
        If the run has too few records.
    """
    time_step(dataset)
    return evaluation_window(dataset).rows


def static_wheel_load(dataset: xr.Dataset) -> float:
    """Return the static load of a wheel in N: of the vehicle, else of the track; NaN if unknown."""
    for name in _LOADS:
        if name in dataset.attrs:
            return float(dataset.attrs[name])
    return math.nan


def vertical_force(dataset: xr.Dataset) -> xr.DataArray:
    """Return the vertical forces Q of the wheels on the rails, (time, wheelset, side), N.

    Of a track without this output the normal forces stand for them.

    Raises
    ------
    ParameterError
        If it has neither.
    """
    for name in ("vertical_wheel_force", "normal_force"):
        if name in dataset:
            return dataset[name].transpose("time", "wheelset", "side")
    raise ParameterError("vertical_wheel_force", None, "is not in the data set, nor normal_force")


def steady_state_amplitude(dataset: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    """Return half peak-to-peak of the Fourier terms up to 500 Hz over the last slab length.

    That is what instrumented wheelsets give; the run should be steady (``--until-steady``).

    Parameters
    ----------
    dataset
        The run.
    array
        Dimensions ``time`` and any others.
    """
    step = time_step(dataset)
    ordered = array.transpose("time", ...).isel(time=last_slabs(dataset).rows)
    found = half_range_below_limit(ordered.to_numpy().astype(float), step)
    others = ordered.isel(time=0, drop=True)
    about = {"long_name": f"half peak-to-peak below {BAND_LIMIT:g} Hz, last slab length"}
    return others.copy(data=found).assign_attrs({**array.attrs, **about})


def half_range_below_limit(values: Array, step: float) -> Array:
    """Return the amplitude (half peak-to-peak) of the Fourier terms up to 500 Hz.

    As instrumented wheelsets give it.

    Parameters
    ----------
    values
        Shape (n, ...), over whole periods of the motion.
    step
        Time between them in s.
    """
    lines = np.fft.rfft(values, axis=0)
    lines[np.fft.rfftfreq(len(values), step) > BAND_LIMIT] = 0.0
    return 0.5 * np.ptp(np.fft.irfft(lines, len(values), axis=0), axis=0)


def basic_statistics(array: xr.DataArray) -> xr.Dataset:
    """Return mean, rms (without the mean), smallest, largest, peak and percentiles.

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.

    Returns
    -------
    xarray.Dataset
        ``mean``, ``rms``, ``min``, ``max``, ``peak`` (largest magnitude), ``percentile_0_15``,
        ``percentile_99_85``; in the signal's unit, without ``time``.
    """
    low, high = percentiles(array).transpose("percentile", ...)
    found = xr.Dataset(
        {
            "mean": array.mean("time"),
            "rms": array.std("time"),
            "min": array.min("time"),
            "max": array.max("time"),
            "peak": abs(array).max("time"),
            "percentile_0_15": low.drop_vars("percentile"),
            "percentile_99_85": high.drop_vars("percentile"),
        }
    )
    for variable in found.values():
        variable.attrs["units"] = array.attrs.get("units", "1")
    return found


def wheel_statistics(dataset: xr.Dataset) -> xr.Dataset:
    """Return the figures of each wheel over :func:`evaluated`, from Q as it is and filtered.

    Parameters
    ----------
    dataset
        The run.

    Returns
    -------
    xarray.Dataset
        Dimensions (wheelset, side). Those of :func:`basic_statistics` of Q in N;
        ``dynamic_factor``, ``unloading``; with ``_20_hz`` after low-pass 20 Hz.

    Raises
    ------
    ParameterError
        If there are no wheel forces.
    """
    force, rows, load = vertical_force(dataset), evaluated(dataset), static_wheel_load(dataset)
    found = basic_statistics(force.isel(time=rows))
    found["dynamic_factor"] = _one(found["max"] / load)
    found["unloading"] = _one((load - found["min"]) / load)
    filtered = low_pass(force, EN14363_LOW_PASS).isel(time=rows)
    low, high = percentiles(filtered).transpose("percentile", ...)
    found["dynamic_factor_20_hz"] = _one(high.drop_vars("percentile") / load)
    found["unloading_20_hz"] = _one((load - low.drop_vars("percentile")) / load)
    return found.assign_attrs(static_wheel_load=load)


def flange_climbing(dataset: xr.Dataset) -> xr.DataArray:
    """Return Y/Q of each wheel over time, Y outwards, (time, wheelset, side).

    Not a number where Q is not greater than 0: a wheel in the air guides nothing.

    Raises
    ------
    ParameterError
        If the track has no output Y.
    """
    outward = _guiding(dataset) * xr.DataArray([-1.0, 1.0], dims="side")
    force = vertical_force(dataset)
    return _one(outward / force.where(force > 0.0)).rename("flange_climbing")


def sum_of_guiding_forces(dataset: xr.Dataset) -> xr.DataArray:
    """Return the track shifting forces (sum of Y), to the right, (time, wheelset), N.

    Raises
    ------
    ParameterError
        If the track has no such output.
    """
    return _guiding(dataset).sum("side").assign_attrs(units="N")


def guiding_statistics(dataset: xr.Dataset) -> xr.Dataset:
    """Return Y/Q of each wheel and track shifting forces as EN 14363 evaluates them.

    Low-pass 20 Hz, means over 2 m, percentiles; over the evaluation window. A
    window shorter than 2 m has values that are not a number.

    Parameters
    ----------
    dataset
        The run.

    Returns
    -------
    xarray.Dataset
        ``flange_climbing`` (wheelset, side): 99.85 % of Y/Q; ``sum_of_guiding_forces``
        (wheelset), N: the larger magnitude of 0.15 % and 99.85 %; ``prudhomme_limit``, N:
        10 kN + 2 Q0/3; the same with ``_peak``: largest of the unfiltered signals.

    Raises
    ------
    ParameterError
        If the track has no such outputs.
    """
    quotient, total = flange_climbing(dataset), sum_of_guiding_forces(dataset)
    rows = evaluated(dataset)
    part = dataset.isel(time=rows)
    # Where a wheel was in the air there is no quotient to filter.
    smooth = _smooth(dataset, part, quotient.fillna(0.0), rows)
    both = _smooth(dataset, part, total, rows)
    found = xr.Dataset(
        {
            "flange_climbing": smooth.isel(percentile=1, drop=True),
            "sum_of_guiding_forces": abs(both).max("percentile"),
            "flange_climbing_peak": quotient.isel(time=rows).max("time"),
            "sum_of_guiding_forces_peak": abs(total.isel(time=rows)).max("time"),
            "prudhomme_limit": 1.0e4 + 2.0 * static_wheel_load(dataset) / 3.0,
        }
    )
    for name, variable in found.items():
        variable.attrs["units"] = "1" if "climbing" in str(name) else "N"
    return found


def _smooth(
    dataset: xr.Dataset, part: xr.Dataset, array: xr.DataArray, rows: slice
) -> xr.DataArray:
    filtered = low_pass(array, EN14363_LOW_PASS).isel(time=rows)
    way = distances(part)
    if way[-1] - way[0] < EN14363_WINDOW:
        return percentiles(filtered) * math.nan
    return percentiles(moving_mean(part, filtered))


def _guiding(dataset: xr.Dataset) -> xr.DataArray:
    if "guiding_force" not in dataset:
        limit = "is not in the data set"
        raise ParameterError("guiding_force", None, limit, "run it again with this track FMU")
    return dataset["guiding_force"].transpose("time", "wheelset", "side")


def _one(array: xr.DataArray) -> xr.DataArray:
    return array.assign_attrs(units="1")
