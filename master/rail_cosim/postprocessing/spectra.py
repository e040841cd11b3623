r"""Spectra: power spectral density, amplitudes, third-octave levels, spectrogram.

Third octaves are those of IEC 61260-1 with base ten: :math:`G = 10^{3/10}`, mid-band frequencies
:math:`f_m = 1000\,G^{x/3}` Hz for whole x, edges :math:`f_m G^{\pm 1/6}`.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

import math

import numpy as np
import scipy  # its parts are imported when they are used
import xarray as xr

from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing.signals import (
    Array,
    sampling_rate,
    squared_unit,
    time_step,
    to_lines,
)
from rail_cosim.summary import spectrum

G = 10.0**0.3
"""Octave ratio of IEC 61260-1, base ten."""

NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
"""Nominal mid-band frequencies of a decade, Hz (IEC 61260-1, Annex E)."""

REFERENCES = {"m/s2": 1e-6, "m/s": 1e-9, "m": 1e-12, "N": 1e-6}
"""Reference values of levels by unit (ISO 1683)."""

_FREQUENCY = {"units": "Hz", "long_name": "frequency"}
_LINES_IN_BAND = 2.0


def power_spectral_density(array: xr.DataArray, *, resolution: float = 0.0) -> xr.DataArray:
    """Return the one-sided power spectral density (Welch, Hann window, half overlap, no mean).

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.
    resolution
        Distance of the lines in Hz; 0 takes the whole record as one segment.

    Returns
    -------
    xarray.DataArray
        Dimension ``frequency`` in place of ``time``; unit squared per Hz.

    Raises
    ------
    ParameterError
        If the record is too short for the resolution.
    """
    rate, count = sampling_rate(array), array.sizes["time"]
    segment = count if resolution == 0.0 else round(rate / resolution)
    if not 2 <= segment <= count:
        limit = f"must be at least {rate / count:g} Hz, one over the length of the record"
        raise ParameterError("resolution", resolution, limit)
    frequencies = np.fft.rfftfreq(segment, 1.0 / rate)

    def density(values: Array) -> Array:
        return scipy.signal.welch(values, fs=rate, window="hann", nperseg=segment, axis=0)[1]

    coordinate = xr.Variable("frequency", frequencies, _FREQUENCY)
    return to_lines(density, array, "frequency", coordinate, units=squared_unit(array, "Hz"))


def amplitude_spectrum(array: xr.DataArray) -> xr.DataArray:
    """Return amplitudes of a spectrum (Hann window, mean removed), in the signal's unit.

    The amplitude of a sine between two lines comes out up to 15 % low. For what repeats with
    fasteners and slabs :func:`rail_cosim.postprocessing.order_spectrum` is exact.

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.

    Returns
    -------
    xarray.DataArray
        Dimension ``frequency`` in place of ``time``.
    """
    time_step(array)
    time = array["time"].to_numpy()
    frequencies = np.fft.rfftfreq(len(time), (time[-1] - time[0]) / (len(time) - 1))
    coordinate = xr.Variable("frequency", frequencies, _FREQUENCY)
    return to_lines(lambda x: spectrum(time, x)[1], array, "frequency", coordinate)


def third_octave_bands(low: float, high: float) -> tuple[Array, Array, Array]:
    """Return lower edges, exact mid-band frequencies and upper edges in Hz, shape (bands,) each.

    All bands whose nominal mid-band frequency is from ``low`` to ``high`` (in Hz).

    Raises
    ------
    ParameterError
        If there is none.
    """
    if not 0.0 < low <= high:
        raise ParameterError("low", low, f"must be greater than 0 and at most high = {high:g} Hz")
    first, last = round(10.0 * math.log10(low)), round(10.0 * math.log10(high))
    middle = 10.0 ** (np.arange(first, last + 1) / 10.0)
    return middle * G ** (-1.0 / 6.0), middle, middle * G ** (1.0 / 6.0)


def nominal_frequencies(middle: Array) -> Array:
    """Return nominal frequencies (12.5, say) of exact ones ``middle``, both Hz, shape (bands,)."""
    number = np.rint(10.0 * np.log10(middle)).astype(int)
    return np.array(NOMINAL)[number % 10] * 10.0 ** (number // 10)


def third_octaves(array: xr.DataArray, *, low: float = 1.0, high: float = 1000.0) -> xr.DataArray:
    """Return the root mean square in third-octave bands.

    Ideal filters: the power spectral density of the whole record (Hann window) is integrated from
    edge to edge; a line belongs to two bands by the shares of its width. Bands that are narrower
    than two lines (short records), or that reach beyond half the sampling rate, are not a number.

    Parameters
    ----------
    array
        Dimensions ``time`` and any others.
    low, high
        Nominal mid-band frequencies of the first and the last band, Hz.

    Returns
    -------
    xarray.DataArray
        Dimension ``frequency`` (exact mid-band, Hz) in place of ``time``, with the coordinate
        ``nominal_frequency``; in the signal's unit.
    """
    density = power_spectral_density(array)
    frequencies = density["frequency"].to_numpy()
    line = float(frequencies[1])
    lower, middle, upper = third_octave_bands(low, high)
    # Power up to f: each line spreads evenly over its width.
    edges = np.append(frequencies - 0.5 * line, frequencies[-1] + 0.5 * line)
    usable = (upper - lower >= _LINES_IN_BAND * line) & (upper <= frequencies[-1])

    def powers(values: Array) -> Array:
        total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)]) * line
        flat = total.reshape(len(total), -1)
        sums = np.stack(
            [np.interp(upper, edges, c) - np.interp(lower, edges, c) for c in flat.T], axis=1
        )
        sums[~usable] = np.nan
        # Differences of sums are a little below 0 where there is nothing.
        return np.sqrt(np.maximum(sums, 0.0)).reshape(len(middle), *values.shape[1:])

    coordinate = xr.Variable("frequency", middle, {**_FREQUENCY, "long_name": "mid-band frequency"})
    found = to_lines(
        powers,
        density.rename(frequency="time"),
        "frequency",
        coordinate,
        units=str(array.attrs.get("units", "1")),
    )
    nominal = ("frequency", nominal_frequencies(middle), {"units": "Hz"})
    return found.assign_coords(nominal_frequency=nominal)


def levels(rms: xr.DataArray, *, reference: float | None = None) -> xr.DataArray:
    """Return levels 20 log10(rms/reference) in dB.

    Parameters
    ----------
    rms
        Root mean squares.
    reference
        In their unit; None takes that of ISO 1683: 1 um/s2, 1 nm/s, 1 pm, 1 uN.

    Raises
    ------
    ParameterError
        If no reference is known for the unit.
    """
    unit = str(rms.attrs.get("units", "1"))
    if reference is None and unit not in REFERENCES:
        raise ParameterError("reference", None, f"is not known for the unit {unit}", "give one")
    value = REFERENCES[unit] if reference is None else reference
    with np.errstate(divide="ignore"):
        found = rms.copy(data=20.0 * np.log10(rms.to_numpy() / value))
    return found.assign_attrs(units="dB", reference=f"{value:g} {unit}")


def spectrogram(
    array: xr.DataArray, *, segment: float = 0.1, overlap: float = 0.75
) -> xr.DataArray:
    """Return the power spectral density over time (short-time Fourier transform, Hann window).

    Parameters
    ----------
    array
        Dimension ``time`` and any others.
    segment
        Length of a segment in s; lines are 1/segment apart.
    overlap
        Share of a segment that the next one has too, 0 to less than 1.

    Returns
    -------
    xarray.DataArray
        Dimensions (frequency, time, ...): the middle of each segment; unit squared per Hz.

    Raises
    ------
    ParameterError
        If a segment is longer than the record.
    """
    rate = sampling_rate(array)
    length = round(segment * rate)
    if not 2 <= length <= array.sizes["time"]:
        limit = f"must be at most the record of {array.sizes['time'] / rate:g} s"
        raise ParameterError("segment", segment, limit)
    if not 0.0 <= overlap < 1.0:
        raise ParameterError("overlap", overlap, "must be at least 0 and less than 1")
    ordered = array.transpose("time", ...)
    frequencies, times, found = scipy.signal.spectrogram(
        ordered.to_numpy().astype(float),
        fs=rate,
        window="hann",
        nperseg=length,
        noverlap=min(round(overlap * length), length - 1),
        axis=0,
    )
    found = np.moveaxis(found, -1, 1)
    others = [d for d in ordered.dims if d != "time"]
    times = times + float(array["time"].to_numpy()[0])
    about = {"units": squared_unit(array, "Hz")}
    return xr.DataArray(
        found,
        dims=["frequency", "time", *others],
        coords={
            **{d: array[d] for d in others if d in array.coords},
            "frequency": ("frequency", frequencies, _FREQUENCY),
            "time": ("time", times, {"units": "s"}),
        },
        attrs={**array.attrs, **about},
        name=array.name,
    )
