"""Figures that describe a run: forces, accelerations, passing frequencies, speed of computing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]
SETTLED_SHARE = 0.5
LONGEST = 200_000
"""Records of a long run that are looked at."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Range:
    """The part of a run that is evaluated.

    Attributes
    ----------
    start, stop
        Distance of the leading wheelset in m.
    rows
        The records in it.
    periods, of
        It is ``periods`` whole lengths of ``of``: ``"slab"`` or ``"bay"``;
        0 and ``""`` if it is shorter than a bay or the bay is not known.
    """

    start: float
    stop: float
    rows: slice
    periods: int
    of: str

    @property
    def text(self) -> str:
        """The range in words."""
        plural = "s" if self.periods > 1 else ""
        whole = f", {self.periods} whole {self.of} length{plural}" if self.periods else ""
        return f"{self.start:.2f} to {self.stop:.2f} m{whole}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Summary:
    """Figures of one run. Arrays have shape (wheelset, side); absent quantities are NaN.

    Attributes
    ----------
    range
        What part of the run was evaluated.
    force_mean, force_min, force_max
        Wheel force in N.
    acceleration_max
        Largest magnitude of the axle-box acceleration in m/s2.
    sleeper_frequency, slab_frequency
        Passing frequencies in Hz.
    force_sleeper, force_slab, acceleration_sleeper, acceleration_slab
        Amplitudes (half of peak to peak) at these frequencies in N and m/s2;
        slab ones are NaN where the range is no whole number of slabs.
    dominant_frequency
        Where the spectrum of the axle-box accelerations is largest, in Hz.
    """

    range: Range
    force_mean: Array
    force_min: Array
    force_max: Array
    acceleration_max: Array
    sleeper_frequency: float
    slab_frequency: float
    force_sleeper: Array
    force_slab: Array
    acceleration_sleeper: Array
    acceleration_slab: Array
    dominant_frequency: float


def summarise(dataset: xr.Dataset) -> Summary:
    """Return the figures of a run, from its Dataset alone.

    The first half of the way is left to the initial transients; of the rest
    the last whole number of slab lengths is evaluated, or of bays where it is
    shorter than a slab. Of a long run only the last records count (:func:`last_records`).

    Raises
    ------
    ValueError
        If the Dataset has fewer than two records.
    """
    if dataset.sizes.get("time", 0) < 2:
        raise ValueError("the run has fewer than two records; there is nothing to summarise")
    dataset = last_records(dataset)
    time = dataset["time"].to_numpy()
    distance = distances(dataset)
    bay, slab = periods(dataset)
    chosen = choose_range(distance, bay, slab)
    rows = chosen.rows
    force = _wheels(dataset, "normal_force")[rows]
    acceleration = _wheels(dataset, "axle_box_vertical_acceleration")[rows]
    lengths = [bay] + ([slab] if chosen.of == "slab" else [])
    lengths = lengths if chosen.periods else []
    force_amplitudes = amplitudes(distance[rows], force, lengths)
    acceleration_amplitudes = amplitudes(distance[rows], acceleration, lengths)
    speed = float((distance[-1] - distance[0]) / (time[-1] - time[0]))
    return Summary(
        range=chosen,
        force_mean=force.mean(axis=0),
        force_min=force.min(axis=0),
        force_max=force.max(axis=0),
        acceleration_max=np.abs(acceleration).max(axis=0),
        sleeper_frequency=speed / bay,
        slab_frequency=speed / slab,
        force_sleeper=force_amplitudes[0],
        force_slab=force_amplitudes[1],
        acceleration_sleeper=acceleration_amplitudes[0],
        acceleration_slab=acceleration_amplitudes[1],
        dominant_frequency=dominant_frequency(time[rows], acceleration),
    )


def last_records(dataset: xr.Dataset) -> xr.Dataset:
    """Return the last :data:`LONGEST` records of a run, all of a shorter one."""
    if dataset.sizes.get("time", 0) <= LONGEST:
        return dataset
    return dataset.isel(time=slice(-LONGEST, None))


def distances(dataset: xr.Dataset) -> Array:
    """Return the way of the leading wheelset in m, shape (n,).

    For a vehicle without the output of its position it is speed times time.
    """
    if "distance" in dataset:
        return dataset["distance"].to_numpy()
    return dataset["time"].to_numpy() * float(dataset.attrs["speed_km_h"]) / 3.6


def _wheels(dataset: xr.Dataset, name: str) -> Array:
    if name not in dataset:
        return np.full((dataset.sizes["time"], 1, 1), np.nan)
    return dataset[name].transpose("time", "wheelset", "side").to_numpy()


def periods(dataset: xr.Dataset) -> tuple[float, float]:
    """Return bay length and slab pitch in m from the track's parameters; NaN if not known."""
    about = dataset.attrs
    bay = float(about.get("track.fastener.spacing", math.nan))
    return bay, bay * float(about.get("track.fastener.count_per_slab", math.nan))


def choose_range(distance: Array, bay: float, slab: float) -> Range:
    """Return the evaluated part of a run over these distances (m, shape (n,))."""
    end = float(distance[-1])
    settled = (1.0 - SETTLED_SHARE) * (end - float(distance[0]))
    for of, length in (("slab", slab), ("bay", bay)):
        # Comparisons with NaN are false: lengths that are not known are passed over.
        if length > 0.0 and settled >= length:
            count = int(settled / length * (1.0 + 1e-9))
            start = end - count * length
            # Half-open, so that the end points of a period are not counted twice.
            first = int(np.searchsorted(distance, start + 1e-9 * length, side="right"))
            return Range(
                start=start, stop=end, rows=slice(first, len(distance)), periods=count, of=of
            )
    first = min(int(np.searchsorted(distance, end - settled)), len(distance) - 2)
    return Range(
        start=float(distance[first]), stop=end, rows=slice(first, len(distance)), periods=0, of=""
    )


def amplitudes(distance: Array, values: Array, lengths: list[float]) -> tuple[Array, Array]:
    """Return the amplitudes of ``values`` at two wavelengths.

    Least squares of a mean and of cosine and sine for each wavelength, over
    whole periods.

    Parameters
    ----------
    distance
        Shape (n,), in m.
    values
        Shape (n, wheelset, side).
    lengths
        Up to two wavelengths in m.

    Returns
    -------
    tuple of ndarray
        For each of two wavelengths shape (wheelset, side); NaN where the wavelength or the
        signal is not given.
    """
    nothing = np.full(values.shape[1:], np.nan)
    if not lengths or len(distance) < 2 * len(lengths) + 1:
        return nothing, nothing
    columns = [np.ones_like(distance)]
    for length in lengths:
        angle = 2.0 * np.pi * distance / length
        columns += [np.cos(angle), np.sin(angle)]
    flat = values.reshape(len(values), -1)
    there = np.isfinite(flat).all(axis=0)
    solution = np.full((len(columns), flat.shape[1]), np.nan)
    basis = np.stack(columns, axis=1)
    solution[:, there] = np.linalg.lstsq(basis, flat[:, there], rcond=None)[0]
    found = [
        np.hypot(solution[1 + 2 * i], solution[2 + 2 * i]).reshape(values.shape[1:])
        for i in range(len(lengths))
    ]
    return found[0], found[1] if len(found) > 1 else nothing


def spectrum(time: Array, values: Array) -> tuple[Array, Array]:
    """Return frequencies (Hz) and amplitudes of a signal, Hann window, mean removed.

    Parameters
    ----------
    time
        Equidistant, shape (n,), in s.
    values
        Shape (n,) or (n, ...).

    Returns
    -------
    tuple of ndarray
        Shapes (m,) and (m, ...); the amplitude of a sine between two lines
        comes out up to 15 % low.
    """
    count = len(time)
    window = np.hanning(count + 1)[:-1]
    centred = values - values.mean(axis=0)
    shaped = window.reshape(-1, *([1] * (values.ndim - 1)))
    lines = np.abs(np.fft.rfft(centred * shaped, axis=0)) * 2.0 / window.sum()
    step = (time[-1] - time[0]) / (count - 1)
    return np.arange(count // 2 + 1) / (count * step), lines


def dominant_frequency(time: Array, values: Array) -> float:
    """Return the frequency (Hz) of the largest line of the mean power over all wheels.

    The peak is refined by a parabola through the logarithms of its three
    lines. NaN if there are too few values or no signal.
    """
    flat = values.reshape(len(values), -1)
    there = np.isfinite(flat).all(axis=0)
    if len(time) < 8 or not there.any():
        return math.nan
    frequencies, lines = spectrum(time, flat[:, there])
    power = (lines**2).mean(axis=1)
    power[:2] = 0.0  # the window's leakage of the mean
    peak = int(np.argmax(power))
    if power[peak] <= 0.0 or peak in (2, len(power) - 1):
        return float(frequencies[peak]) if power[peak] > 0.0 else math.nan
    low, top, high = np.log(power[peak - 1 : peak + 2] + 1e-300)
    shift = 0.5 * (low - high) / (low - 2.0 * top + high)
    return float(frequencies[peak] + shift * (frequencies[1] - frequencies[0]))
