"""Sections with spectra, third octaves, orders and the spectrogram."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rail_cosim.postprocessing import (
    amplitude_spectrum,
    evaluated,
    levels,
    order_spectrum,
    spectrogram,
    third_octaves,
)
from rail_cosim.presentation import channels, shown_unit, title
from rail_cosim.reporting.charts import chart, heat_map, line
from rail_cosim.reporting.motion import BOX, FORCES
from rail_cosim.reporting.sections import Figure, MissingError, Section, need
from rail_cosim.summary import Summary
from rail_cosim.window import periods

_HIGHEST, _HIGHEST_ORDER = 2000.0, 10.0
_CAR = ("car_body_floor_vertical_acceleration", "car_body_vertical_acceleration")
_BOGIE = ("bogie_vertical_acceleration",)
_COLUMNS, _LINES = 400, 250
_FEWEST = 8  # lines
_LEAST = 1e-12


def spectra(run: xr.Dataset, summary: Summary) -> Section:
    """Return the section of spectra."""
    section = Section(
        title="Spectra",
        intro=f"Of the evaluation window, {summary.window.text}. "
        "Amplitudes are those of the spectral lines.",
    )
    for names in ((BOX,), FORCES, _CAR):
        section.add(lambda n=names: _spectrum(run, summary, need(run, *n)))
    for names in (FORCES, (BOX,)):
        section.add(lambda n=names: _orders(run, need(run, *n)))
    return section


def bands(run: xr.Dataset, summary: Summary) -> Section:
    """Return the section of third-octave levels."""
    section = Section(
        title="Third-octave levels",
        intro="Bands of IEC 61260-1, base ten; root mean square over the evaluation window, "
        f"{summary.window.text}. Bands that are narrower than two spectral lines of this window "
        "are left out.",
    )
    for names in ((BOX,), FORCES, _BOGIE, _CAR):
        section.add(lambda n=names: _bands(run, need(run, *n)))
    return section


def over_time(run: xr.Dataset) -> Section:
    """Return the section of the spectrogram."""
    section = Section(title="Spectrogram")
    section.add(lambda: _spectrogram(run, need(run, BOX)))
    return section


def _part(run: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    return _finite(array.isel(time=evaluated(run)))


def _finite(array: xr.DataArray) -> xr.DataArray:
    if not bool(np.isfinite(array).all()):
        raise MissingError(f"{array.name}: there are records that are not a number")
    return array


def _spectrum(run: xr.Dataset, summary: Summary, array: xr.DataArray) -> Figure:
    unit, factor = shown_unit(array)
    found = amplitude_spectrum(_part(run, array))
    found = found.isel(frequency=slice(2, None)).sel(frequency=slice(None, _HIGHEST))
    frequency = found["frequency"].to_numpy()
    largest = float(found.max()) * factor
    marks = {
        "fastener passing": summary.fastener_passing_frequency,
        "slab passing": summary.slab_passing_frequency,
    }
    drawn = chart(
        _lines(found, frequency, factor),
        x="frequency (Hz)",
        y=f"amplitude ({unit})",
        x_axis={"range": [0, min(500.0, float(frequency[-1]))]},
        y_axis=_decades(largest, 5),
        marks={word: f for word, f in marks.items() if not math.isnan(f)},
    )
    return Figure(title=f"Spectrum: {title(array)}", chart=drawn)


def _lines(found: xr.DataArray, over: np.ndarray, factor: float) -> list[dict[str, object]]:
    """Return a line for each channel, kept above 0 for a logarithmic axis."""
    return [
        line(
            over,
            np.maximum(values.to_numpy() * factor, _LEAST),
            name,
            colour=colour,
            dash=dash,
            shown=shown,
        )
        for name, values, colour, dash, shown in channels(found)
    ]


def _decades(largest: float, count: int) -> dict[str, object]:
    """Return a logarithmic axis of so many decades below the largest value."""
    top = math.log10(max(largest, _LEAST)) + 0.2
    return {"type": "log", "range": [top - count, top], "dtick": 1, "exponentformat": "power"}


def _orders(run: xr.Dataset, array: xr.DataArray) -> Figure:
    unit, factor = shown_unit(array)
    found = order_spectrum(run, array).isel(order=slice(1, None))
    found = found.sel(order=slice(None, _HIGHEST_ORDER))
    order = found["order"].to_numpy()
    bay, slab = periods(run)
    drawn = chart(
        _lines(found, order, factor),
        x="order: periods per fastener spacing",
        y=f"amplitude ({unit})",
        y_axis=_decades(float(found.max()) * factor, 5),
        marks={"fastener passing": 1.0} | ({"slab passing": bay / slab} if slab > 0.0 else {}),
    )
    window = f"{found.attrs['evaluated_start']:.2f} to {found.attrs['evaluated_stop']:.2f} m"
    words = f"Orders of {bay:g} m: {title(array)}, {window}"
    return Figure(title=words, chart=drawn)


def _bands(run: xr.Dataset, array: xr.DataArray) -> Figure:
    rms = third_octaves(_part(run, array), low=1.0, high=2000.0)
    known = np.isfinite(rms.to_numpy()).reshape(rms.sizes["frequency"], -1).all(axis=1)
    if not known.any():
        raise MissingError(f"{array.name}: the run is too short for third octaves")
    found = levels(rms.isel(frequency=known))
    frequency = found["nominal_frequency"].to_numpy()
    lines = [
        line(frequency, values.to_numpy(), name, colour=colour, dash=dash, shown=shown, step=True)
        for name, values, colour, dash, shown in channels(found)
    ]
    words = [f"{f:g}" for f in frequency]
    ticks = {"type": "log", "tickvals": frequency[::3].tolist(), "ticktext": words[::3]}
    drawn = chart(
        lines,
        x="mid-band frequency (Hz)",
        y=f"level (dB re 1 µ{str(rms.attrs['units']).replace('2', '²')})",
        x_axis=ticks,
    )
    return Figure(title=f"Third octaves: {title(array)}", chart=drawn)


def _spectrogram(run: xr.Dataset, array: xr.DataArray) -> Figure:
    wheel = _finite(array.isel({d: 0 for d in array.dims if d != "time"}))
    time = run["time"].to_numpy()
    duration = float(time[-1] - time[0])
    segment = min(0.2, duration / 4.0)
    found = spectrogram(wheel, segment=segment, overlap=0.75).sel(frequency=slice(1.0, 1000.0))
    if found.sizes["frequency"] < _FEWEST:
        raise MissingError(f"a run of {duration:.3g} s is too short for a spectrogram")
    # No more columns and lines than can be seen: the mean power of neighbours.
    step = {
        "time": max(1, found.sizes["time"] // _COLUMNS),
        "frequency": max(1, found.sizes["frequency"] // _LINES),
    }
    power = found.coarsen(step, boundary="trim").mean()  # type: ignore[attr-defined]
    level = 10.0 * np.log10(np.maximum(power.to_numpy(), _LEAST))
    top = float(level.max())
    heat = heat_map(
        power["time"].to_numpy(),
        power["frequency"].to_numpy(),
        level,
        unit="dB re 1 (m/s²)²/Hz",
    ) | {"zmin": top - 60.0, "zmax": top}
    drawn = chart([heat], x="time (s)", y="frequency (Hz)", height=420)
    word = "left, " if "side" in array.dims else ""
    words = f"Axle-box acceleration of the leading wheelset, {word}segments of {segment:.2g} s"
    return Figure(title=words, chart=drawn)
