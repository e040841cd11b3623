r"""Filters and percentiles with which EN 14363 evaluates forces and accelerations.

========================================  ===================================================
quantity                                  evaluation
========================================  ===================================================
lateral force Y, track shifting force,    low-pass 20 Hz, mean over 2 m (step 0.5 m at
Y/Q                                       most), percentiles 0.15 % and 99.85 %
wheel force Q                             low-pass 20 Hz, percentile 99.85 %
lateral acceleration in the car body,     low-pass 6 Hz
running safety
vertical acceleration in the car body,    band-pass 0.4 Hz to 4 Hz
running safety
ride characteristics                      band-pass 0.4 Hz to 10 Hz
========================================  ===================================================

A limit frequency is where the gain is -3 dB; the slope is at least 24 dB per octave
(EN 14363:2016, annex on measured quantities): Butterworth filters of fourth order.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

import numpy as np
import scipy  # its parts are imported when they are used
import xarray as xr

from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing.signals import Array, along_time, sampling_rate
from rail_cosim.window import distances

EN14363_LOW_PASS = 20.0
"""Limit frequency for forces, Hz."""

EN14363_WINDOW, EN14363_STEP = 2.0, 0.5
"""Length of the moving mean of lateral wheel forces and its largest step, m."""

EN14363_PERCENTILES = (0.15, 99.85)
"""Percentiles for running safety, %."""

_ORDER = 4


def low_pass(array: xr.DataArray, cutoff: float = EN14363_LOW_PASS) -> xr.DataArray:
    """Return the signal through a Butterworth low-pass of fourth order.

    Causal, as measuring equipment is; it starts as if the first value had always been there.

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.
    cutoff
        Frequency of -3 dB, Hz.

    Raises
    ------
    ParameterError
        If the cutoff is not between 0 and half the sampling rate.
    """
    return _butterworth(array, cutoff, "lowpass")


def band_pass(array: xr.DataArray, low: float, high: float) -> xr.DataArray:
    """Return the signal through a Butterworth high-pass and low-pass of fourth order each.

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.
    low, high
        Frequencies of -3 dB, Hz.

    Raises
    ------
    ParameterError
        If the limits are not in order, or beyond half the sampling rate.
    """
    if not low < high:
        raise ParameterError("low", low, f"must be less than high = {high:g} Hz")
    return _butterworth(_butterworth(array, low, "highpass"), high, "lowpass")


def _butterworth(array: xr.DataArray, cutoff: float, kind: str) -> xr.DataArray:
    rate = sampling_rate(array)
    if not 0.0 < cutoff < 0.5 * rate:
        limit = f"must be between 0 and half the sampling rate, {0.5 * rate:g} Hz"
        raise ParameterError("cutoff", cutoff, limit, "record more often or filter lower")
    sections = scipy.signal.butter(_ORDER, cutoff, kind, fs=rate, output="sos")

    def filtered(values: Array) -> Array:
        state = scipy.signal.sosfilt_zi(sections)
        state = state.reshape(*state.shape, *[1] * (values.ndim - 1)) * values[0]
        return scipy.signal.sosfilt(sections, values, axis=0, zi=state)[0]

    return along_time(filtered, array)


def moving_mean(
    dataset: xr.Dataset,
    array: xr.DataArray,
    *,
    window: float = EN14363_WINDOW,
    step: float = EN14363_STEP,
) -> xr.DataArray:
    """Return means over ``window`` metres of distance, every ``step`` metres.

    The signal is taken as linear in the distance between two records, and its integral is exact; so
    it holds at changing speed, too.

    Parameters
    ----------
    dataset
        The run: gives the distance travelled by the leading wheelset.
    array
        Dimensions ``time`` and any others.
    window, step
        In m.

    Returns
    -------
    xarray.DataArray
        Dimension ``distance`` (m, middle of each window) in place of ``time``.

    Raises
    ------
    ParameterError
        If the distance is shorter than the window.
    """
    way = np.asarray(distances(dataset), dtype=float)
    length = float(way[-1] - way[0])
    if not 0.0 < window <= length * (1.0 + 1e-9):
        remedy = "run a longer distance"
        raise ParameterError(
            "window", window, f"must be at most the distance travelled, {length:g} m", remedy
        )
    count = int((length - window) / step * (1.0 + 1e-12)) + 1
    starts = way[0] + step * np.arange(count)
    ordered = array.transpose("time", ...)
    values = ordered.to_numpy().astype(float)
    flat = values.reshape(len(way), -1)
    means = np.stack([_means(way, column, starts, window) for column in flat.T], axis=1)
    others = [d for d in ordered.dims if d != "time"]
    about = {"units": "m", "long_name": "distance travelled by the leading wheelset"}
    return xr.DataArray(
        means.reshape(count, *values.shape[1:]),
        dims=["distance", *others],
        coords={
            **{d: array[d] for d in others if d in array.coords},
            "distance": ("distance", starts + 0.5 * window, about),
        },
        attrs={**array.attrs, "cell_methods": f"distance: mean (interval: {window:g} m)"},
        name=array.name,
    )


def _means(way: Array, values: Array, starts: Array, window: float) -> Array:
    pieces = 0.5 * (values[1:] + values[:-1]) * np.diff(way)
    integral = np.concatenate([[0.0], np.cumsum(pieces)])

    def upto(x: Array) -> Array:
        """Integral up to x, a parabola between two records."""
        i = np.clip(np.searchsorted(way, x, side="right") - 1, 0, len(way) - 2)
        part = np.clip(x, way[0], way[-1]) - way[i]
        slope = (values[i + 1] - values[i]) / (way[i + 1] - way[i])
        return integral[i] + part * (values[i] + 0.5 * slope * part)

    return (upto(starts + window) - upto(starts)) / window


def percentiles(array: xr.DataArray, of: tuple[float, ...] = EN14363_PERCENTILES) -> xr.DataArray:
    """Return percentiles over the first dimension that runs along the line or in time.

    Parameters
    ----------
    array
        With a dimension ``time`` or ``distance``.
    of
        In %.

    Returns
    -------
    xarray.DataArray
        Dimension ``percentile`` (%) in place of ``time`` or ``distance``.

    Raises
    ------
    ParameterError
        For an array without these dimensions, and for a percentile not within 0 to 100.
    """
    along = next((d for d in ("time", "distance") if d in array.dims), None)
    if along is None:
        raise ParameterError("dimensions", str(array.dims), "must contain time or distance")
    if not all(0.0 <= one <= 100.0 for one in of):
        raise ParameterError("of", of, "must be within 0 to 100 %")
    found = np.percentile(array.to_numpy(), of, axis=array.get_axis_num(along))
    others = [d for d in array.dims if d != along]
    return xr.DataArray(
        found,
        dims=["percentile", *others],
        coords={
            **{d: array[d] for d in others if d in array.coords},
            "percentile": ("percentile", np.array(of, dtype=float), {"units": "%"}),
        },
        attrs=array.attrs,
        name=array.name,
    )
