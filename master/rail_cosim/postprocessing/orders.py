r"""Order analysis: what repeats with the fasteners and with the slabs.

Records are resampled at equal steps of distance, so that a line of the spectrum is a number of
periods per length and not per second: *order* 1 of the fastener spacing :math:`l_0` is one period
from fastener to fastener, at any speed and while it changes. Over a whole number of slab lengths
all orders of fasteners and slabs are lines of their own, without leakage and without a window.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing.signals import Array
from rail_cosim.window import distances, periods

_LEAST_PER_PERIOD = 16


def over_distance(
    dataset: xr.Dataset, array: xr.DataArray, *, step: float, start: float, stop: float
) -> xr.DataArray:
    """Return a signal at equal steps of distance, from ``start`` on and before ``stop``.

    Cubic splines through the records.

    Parameters
    ----------
    dataset
        The run: gives the distance travelled by the leading wheelset.
    array
        Dimensions ``time`` and any others.
    step, start, stop
        In m.

    Returns
    -------
    xarray.DataArray
        Dimension ``distance`` (m) in place of ``time``.

    Raises
    ------
    ParameterError
        If the distance does not grow from record to record, or does not reach from start to stop,
        or if a record is not a number.
    """
    way = np.asarray(distances(dataset), dtype=float)
    if not (np.diff(way) > 0.0).all():
        raise ParameterError("distance", float(np.diff(way).min()), "must grow at every record")
    slack = 1e-6 * (way[-1] - way[0]) + 1e-9
    if start < way[0] - slack or stop > way[-1] + slack or not stop > start:
        limit = f"must lie within the distance travelled, {way[0]:g} m to {way[-1]:g} m"
        raise ParameterError("start, stop", (start, stop), limit)
    count = max(1, math.ceil((stop - start) / step * (1.0 - 1e-9)))
    places = start + (stop - start) / count * np.arange(count)
    ordered = array.transpose("time", ...)
    records = ordered.to_numpy().astype(float)
    if not np.isfinite(records).all():
        limit = "there are records that are not a number"
        raise ParameterError(str(array.name or "signal"), None, limit, "take the part without")
    values = CubicSpline(way, records, axis=0)(np.clip(places, way[0], way[-1]))
    others = [d for d in ordered.dims if d != "time"]
    about = {"units": "m", "long_name": "distance travelled by the leading wheelset"}
    return xr.DataArray(
        values,
        dims=["distance", *others],
        coords={
            **{d: array[d] for d in others if d in array.coords},
            "distance": ("distance", places, about),
        },
        attrs=array.attrs,
        name=array.name,
    )


def order_spectrum(
    dataset: xr.Dataset,
    array: xr.DataArray,
    *,
    spacing: float | None = None,
    period: float | None = None,
) -> xr.DataArray:
    """Return amplitudes (half peak-to-peak) over orders of the fastener spacing.

    Evaluated are the last whole number of slab lengths within the second half of the distance,
    or one slab length where that is shorter.

    Parameters
    ----------
    dataset
        The run.
    array
        Dimensions ``time`` and any others.
    spacing
        Length of which there are orders, m; None: the track's fastener spacing.
    period
        Length that the window is a whole number of, m; None: the track's slab pitch.

    Returns
    -------
    xarray.DataArray
        Dimension ``order`` in place of ``time``; order 0 is the mean.

    Raises
    ------
    ParameterError
        If lengths are not known, the distance is shorter than the period, or records are fewer than
        2 per step of the highest order.
    """
    bay, slab = periods(dataset)
    spacing = _known("spacing", spacing, bay)
    period = _known("period", period, slab if slab > 0.0 else spacing)
    way = np.asarray(distances(dataset), dtype=float)
    length = float(way[-1] - way[0])
    count = int(0.5 * length / period * (1.0 + 1e-9)) or 1
    if count * period > length * (1.0 + 1e-9):
        limit = f"must be at most the distance travelled, {length:g} m"
        raise ParameterError("period", period, limit, "run a longer distance")
    stop = float(way[-1])
    largest = float(np.diff(way).max())
    if largest > period / _LEAST_PER_PERIOD:
        limit = f"records are {largest:g} m apart, too far for a period of {period:g} m"
        raise ParameterError("records", len(way), limit, "record more often")
    # No aliasing: as fine as the records are at their widest.
    resampled = over_distance(dataset, array, step=largest, start=stop - count * period, stop=stop)
    places = resampled.sizes["distance"]
    lines = np.fft.rfft(resampled.to_numpy(), axis=0) / places
    amplitudes = np.abs(lines)
    amplitudes[1 : (places + 1) // 2] *= 2.0
    amplitudes[0] = lines[0].real
    orders = np.arange(len(lines)) * spacing / (count * period)
    others = [d for d in resampled.dims if d != "distance"]
    about = {"units": "1", "long_name": f"order of {spacing:g} m"}
    return xr.DataArray(
        amplitudes,
        dims=["order", *others],
        coords={
            **{d: resampled[d] for d in others if d in resampled.coords},
            "order": ("order", orders, about),
        },
        attrs={**array.attrs, "evaluated_start": stop - count * period, "evaluated_stop": stop},
        name=array.name,
    )


def passing_amplitudes(
    dataset: xr.Dataset, array: xr.DataArray, *, harmonics: Sequence[int] = (1, 2, 3)
) -> xr.Dataset:
    """Return amplitudes at the harmonics of fastener passing and of slab passing.

    Parameters
    ----------
    dataset
        The run.
    array
        Dimensions ``time`` and any others.
    harmonics
        1 is the passing frequency itself.

    Returns
    -------
    xarray.Dataset
        ``sleeper`` and ``slab`` with the dimension ``harmonic`` in place of ``time``. A harmonic
        of the slab that is one of the fastener, too, is shared.

    Raises
    ------
    ParameterError
        As :func:`order_spectrum`.
    """
    bay, slab = periods(dataset)
    spectrum = order_spectrum(dataset, array)
    numbers = np.asarray(harmonics, dtype=int)
    coordinate = ("harmonic", numbers, {"units": "1"})
    found = {}
    for name, length in (("sleeper", bay), ("slab", slab)):
        chosen = spectrum.sel(order=numbers * bay / length, method="nearest", tolerance=1e-6)
        chosen = chosen.drop_vars("order").rename(order="harmonic")
        found[name] = chosen.assign_coords(harmonic=coordinate).rename(name)
    return xr.Dataset(found)


def passing_frequencies(dataset: xr.Dataset) -> tuple[Array, Array]:
    """Return fastener-passing and slab-passing frequency over time in Hz, shape (time,) each."""
    bay, slab = periods(dataset)
    speed = np.gradient(np.asarray(distances(dataset), float), dataset["time"].to_numpy())
    return speed / bay, speed / slab


def _known(name: str, given: float | None, own: float) -> float:
    value = own if given is None else given
    if not value > 0.0:
        limit = "must be greater than 0 m"
        if given is None:
            limit = "the track does not give its fastener spacing and slab pitch"
        raise ParameterError(name, given, limit, "give a length")
    return value
