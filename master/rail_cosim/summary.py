"""Figures that describe a run: extremes of all of it, statistics of its evaluation window."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.events import events_outside
from rail_cosim.extremes import BOX, FORCE, extremes, labelled, wheels
from rail_cosim.steady import slab_to_slab_change
from rail_cosim.window import EvaluationWindow, distances, evaluation_window, periods

Array = NDArray[np.float64]
STEADY_CHANGE = 0.01
"""Change from slab to slab up to which a run that was not asked to become steady is called so."""


@dataclasses.dataclass(frozen=True, kw_only=True, repr=False)
class Summary:
    """Figures of one run; printed, it is the tables of ``rail-cosim run``.

    Attributes
    ----------
    data
        All figures with ``units``, ``long_name`` and ``evaluated_over`` (whole run or evaluation
        window), by ``wheelset`` and ``side``; what is not recorded is not there. Of the whole run:
        ``wheel_force_max``, ``wheel_force_min``, ``axle_box_acceleration_peak``, each with
        ``_distance``; ``loss_of_contact_count``, ``_longest``, ``_total``. Of the window:
        ``wheel_force_mean``, ``wheel_force_window_min``, ``wheel_force_window_max``,
        ``axle_box_acceleration_window_peak``, and of both quantities the
        ``_fastener_passing_amplitude`` and ``_slab_passing_amplitude``; these are amplitudes of
        the first harmonic, NaN where the window is no whole number of these lengths.
    window
        The evaluation window.
    whole
        The whole run.
    change
        Largest relative change from slab to slab over the window
        (:func:`rail_cosim.steady.slab_to_slab_change`); NaN if it cannot be told.
    steady
        Whether the motion is steady over the window: the change is at most what the run was
        asked for (``until_steady``), else :data:`STEADY_CHANGE`.
    state
        The same in words.
    events
        Extremes clearly outside what the window has seen, and losses of contact outside it, in
        words.
    fastener_passing_frequency, slab_passing_frequency
        Mean speed over these lengths in Hz; NaN if not known.
    dominant_frequency
        Where the spectrum of the axle-box accelerations in the window is largest, in Hz.
    """

    data: xr.Dataset
    window: EvaluationWindow
    whole: EvaluationWindow
    change: float
    steady: bool
    state: str
    events: Sequence[str]
    fastener_passing_frequency: float
    slab_passing_frequency: float
    dominant_frequency: float

    def __getitem__(self, name: str) -> xr.DataArray:
        return self.data[name]

    def to_dataset(self) -> xr.Dataset:
        """Return :attr:`data` with all else as attributes, as NetCDF can hold it."""
        return self.data.assign_attrs(
            whole_run=self.whole.text,
            evaluation_window=self.window.text,
            slab_to_slab_change=self.change,
            steady=int(self.steady),
            state=self.state,
            events="; ".join(self.events),
            fastener_passing_frequency=self.fastener_passing_frequency,
            slab_passing_frequency=self.slab_passing_frequency,
            dominant_frequency=self.dominant_frequency,
        )

    def __str__(self) -> str:
        from rail_cosim.tables import as_text, figures

        return as_text(figures(self))

    __repr__ = __str__


def summarise(dataset: xr.Dataset) -> Summary:
    """Return the figures of a run, from its Dataset alone.

    Extremes and losses of contact are those of all records. Statistics are those of
    :func:`rail_cosim.window.evaluation_window`.

    Parameters
    ----------
    dataset
        The run, as :func:`rail_cosim.run` returns it.

    Raises
    ------
    ValueError
        If the Dataset has fewer than two records.
    """
    if dataset.sizes.get("time", 0) < 2:
        raise ValueError("the run has fewer than two records; there is nothing to summarise")
    window = evaluation_window(dataset)
    ends = dataset.isel(time=[0, -1])
    start, stop = distances(ends)
    speed = float(stop - start) / float(ends["time"][1] - ends["time"][0])
    whole = EvaluationWindow(
        start=float(start), stop=float(stop), rows=slice(0, dataset.sizes["time"])
    )
    bay, slab = periods(dataset)
    part = dataset.isel(time=window.rows)
    of_run, of_window = extremes(dataset), _window_figures(part, window, bay, slab)
    for found, text in (
        (of_run, f"whole run, {whole.text}"),
        (of_window, f"evaluation window, {window.text}"),
    ):
        for array in found.data_vars.values():
            array.attrs["evaluated_over"] = text
    change = slab_to_slab_change(dataset, window)
    steady, state = _state(dataset, change)
    return Summary(
        data=of_run.assign(of_window),
        window=window,
        whole=whole,
        change=change,
        steady=steady,
        state=state,
        events=events_outside(dataset, of_run, window),
        fastener_passing_frequency=speed / bay,
        slab_passing_frequency=speed / slab,
        dominant_frequency=dominant_frequency(part["time"].to_numpy(), wheels(part, BOX)),
    )


def _window_figures(
    part: xr.Dataset, window: EvaluationWindow, bay: float, slab: float
) -> xr.Dataset:
    found = xr.Dataset()
    if FORCE in part:
        force = wheels(part, FORCE)
        for name, function, word in (
            ("mean", np.mean, "mean"),
            ("window_min", np.min, "smallest"),
            ("window_max", np.max, "largest"),
        ):
            found[f"wheel_force_{name}"] = labelled(
                function(force, axis=0), "N", f"{word} wheel force"
            )
    if BOX in part:
        peak = np.abs(wheels(part, BOX)).max(axis=0)
        name = "axle_box_acceleration_window_peak"
        found[name] = labelled(peak, "m/s2", "peak axle-box acceleration")
    lengths = {"slab": [bay, slab], "bay": [bay]}.get(window.of, [])
    for name, variable, unit in (
        ("wheel_force", FORCE, "N"),
        ("axle_box_acceleration", BOX, "m/s2"),
    ):
        if variable in part:
            both = amplitudes(distances(part), wheels(part, variable), lengths)
            for what, values in zip(("fastener", "slab"), both, strict=True):
                words = f"{what}-passing amplitude (first harmonic) of the {name.replace('_', ' ')}"
                found[f"{name}_{what}_passing_amplitude"] = labelled(values, unit, words)
    return found


def _state(dataset: xr.Dataset, change: float) -> tuple[bool, str]:
    """Return whether a run is steady over its window, and this in words."""
    about = dataset.attrs
    if "final_speed_km_h" in about:
        return False, "not steady (the speed changes)"
    if math.isnan(change):
        slab = periods(dataset)[1]
        why = "the run is shorter than two slab lengths"
        if not slab > 0.0:
            why = "the slab length is not known"
        elif FORCE not in dataset and BOX not in dataset:
            why = "wheel forces and axle-box accelerations are not recorded"
        return False, f"not tested for a steady state ({why})"
    steady = change <= float(about.get("steady_tolerance", STEADY_CHANGE))
    percent = 100.0 * change
    text = f"change {percent:.{2 if percent < 100.0 else 4}g} % from slab to slab"
    return steady, f"{'steady' if steady else 'not steady'} ({text})"


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
