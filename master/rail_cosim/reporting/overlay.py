"""Sections with charts in which several runs lie over each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rail_cosim.errors import RailCosimError
from rail_cosim.postprocessing import amplitude_spectrum
from rail_cosim.presentation import COLOURS, channels, label, shown_unit, title
from rail_cosim.reporting.charts import Chart, chart, line
from rail_cosim.reporting.motion import BOX, DISTANCE, FORCES, track_shifting_force
from rail_cosim.reporting.sections import Figure, Section, need
from rail_cosim.summary import Summary
from rail_cosim.window import distances

_CAR = ("car_body_floor_vertical_acceleration", "car_body_vertical_acceleration")
_HISTORIES = (
    FORCES,
    (BOX,),
    ("guiding_force",),
    ("rail_vertical_displacement",),
    ("bogie_vertical_acceleration",),
    ("bogie_lateral_acceleration",),
    _CAR,
    ("car_body_floor_lateral_acceleration", "car_body_lateral_acceleration"),
)
_SPECTRA = (FORCES, (BOX,), _CAR)
_HIGHEST = 500.0  # Hz, shown at first


def histories(runs: Mapping[str, xr.Dataset]) -> Section:
    """Return the section of histories, the same channel of all runs over each other."""
    section = Section(
        title="Histories",
        intro="Versus the distance travelled by the leading wheelset. The menu chooses the "
        "channel; the first one shown has the largest magnitude. Drag to zoom, double-click to go "
        "back; click a name to show or hide it.",
    )
    for names in _HISTORIES:
        section.add(lambda n=names: _history(section, runs, lambda run: need(run, *n)))
    section.add(lambda: _history(section, runs, track_shifting_force))
    return section


def _history(
    section: Section,
    runs: Mapping[str, xr.Dataset],
    variable: Callable[[xr.Dataset], xr.DataArray],
) -> Figure:
    arrays = _there(section, runs, variable)
    lines = {name: (distances(runs[name]), array) for name, array in arrays.items()}
    first = next(iter(arrays.values()))
    drawn = _overlaid(runs, lines, shown_unit(first)[1], x=DISTANCE, y=label(first))
    words = title(first)
    return Figure(title=words[0].upper() + words[1:], chart=drawn)


def spectra(runs: Mapping[str, xr.Dataset], summaries: Mapping[str, Summary]) -> Section:
    """Return the section of spectra."""
    windows = "; ".join(f"{name}: {one.window.text}" for name, one in summaries.items())
    section = Section(title="Spectra", intro=f"Of each run's evaluation window. {windows}.")
    for names in _SPECTRA:
        section.add(lambda n=names: _spectrum(section, runs, summaries, n))
    return section


def _spectrum(
    section: Section,
    runs: Mapping[str, xr.Dataset],
    summaries: Mapping[str, Summary],
    names: Sequence[str],
) -> Figure:
    arrays = _there(section, runs, lambda run: need(run, *names))
    lines: dict[str, tuple[np.ndarray, xr.DataArray]] = {}
    for name, array in arrays.items():
        found = amplitude_spectrum(array.isel(time=summaries[name].window.rows))
        found = found.isel(frequency=slice(2, None))  # without the leakage of the mean
        lines[name] = found["frequency"].to_numpy(), found.rename(frequency="time")
    first = next(iter(arrays.values()))
    unit, factor = shown_unit(first)
    drawn = _overlaid(runs, lines, factor, x="frequency (Hz)", y=f"amplitude ({unit})")
    drawn["layout"]["xaxis"]["range"] = [0.0, _HIGHEST]
    return Figure(title=f"Spectrum: {title(first)}", chart=drawn)


def _there(
    section: Section,
    runs: Mapping[str, xr.Dataset],
    variable: Callable[[xr.Dataset], xr.DataArray],
) -> dict[str, xr.DataArray]:
    """Return the variable of the runs that have it; note those that do not.

    Raises
    ------
    RailCosimError
        If none has it.
    """
    found: dict[str, xr.DataArray] = {}
    errors: dict[str, RailCosimError] = {}
    for name, run in runs.items():
        try:
            found[name] = variable(run)
        except RailCosimError as error:
            errors[name] = error
    if not found:
        raise next(iter(errors.values()))
    section.missing += [f"{name}: {error}" for name, error in errors.items()]
    return found


def _overlaid(
    runs: Mapping[str, xr.Dataset],
    lines: Mapping[str, tuple[np.ndarray, xr.DataArray]],
    factor: float,
    *,
    x: str,
    y: str,
) -> Chart:
    """Draw the same channel of all runs over each other, with a menu of the channels."""
    colours = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(runs)}
    traces: list[Chart] = []
    owners: list[str] = []
    peaks: dict[str, float] = {}
    for name, (over, array) in lines.items():
        for one in channels(array):
            values = one.values.to_numpy() * factor
            traces.append(line(over, values, name, colour=colours[name]))
            owners.append(one.name)
            peak = float(np.nanmax(np.abs(values), initial=0.0))
            peaks[one.name] = max(peaks.get(one.name, 0.0), peak)
    # The first of those that are alike but for round-off, as left and right wheels are.
    largest = max(peaks.values())
    shown = next(channel for channel, peak in peaks.items() if peak >= largest * (1.0 - 1e-9))
    for trace, owner in zip(traces, owners, strict=True):
        trace["visible"] = owner == shown
    drawn = chart(traces, x=x, y=y, height=420)
    if len(peaks) > 1:
        drawn["layout"]["updatemenus"] = [_menu(list(peaks), owners, shown)]
    return drawn


def _menu(names: list[str], owners: list[str], shown: str) -> dict[str, Any]:
    buttons = [
        {
            "label": name,
            "method": "restyle",
            "args": [{"visible": [owner == name for owner in owners]}],
        }
        for name in names
    ]
    place = {"x": 1.0, "xanchor": "right", "y": 1.02, "yanchor": "bottom"}
    return {"buttons": buttons, "active": names.index(shown), "showactive": True, **place}
