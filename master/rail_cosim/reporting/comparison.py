"""Sections that compare runs: settings and parameters that differ, statistics, charts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rail_cosim.presentation import channels
from rail_cosim.reporting import overlay
from rail_cosim.reporting.figures import ABOUT, RESIDUALS
from rail_cosim.reporting.sections import MissingError, Section, Table, number, text
from rail_cosim.summary import Summary, summarise
from rail_cosim.window import distances

_WORDS = {name: words for name, words, *_ in (*ABOUT, *RESIDUALS)}
_ALWAYS = ("source", "line", "speed_km_h", "algorithm", "macro_step")
_NOT_COMPARED = {
    *("changed_parameters", "command", "complete", "cpu_seconds", "date", "ended_by", "steps"),
    *("steps_planned", "title", "wall_clock_seconds"),
}
_PARAMETERS = ("track.", "vehicle.")
_ALIKE = 1e-9


class _Statistic(NamedTuple):
    """A row of the table of statistics: the largest of all wheels (of ``min``, the smallest)."""

    name: str
    words: str
    unit: str
    factor: float
    smallest: bool = False


_WHOLE = (
    _Statistic("wheel_force_max", "wheel force, max", "kN", 1e-3),
    _Statistic("wheel_force_min", "wheel force, min", "kN", 1e-3, smallest=True),
    _Statistic("axle_box_acceleration_peak", "peak axle-box acceleration", "m/s²", 1.0),
    _Statistic("loss_of_contact_count", "losses of contact of a wheel", "", 1.0),
    _Statistic("loss_of_contact_longest", "longest loss of contact", "ms", 1e3),
)
_WINDOW = (
    _Statistic("wheel_force_mean", "wheel force, mean", "kN", 1e-3),
    _Statistic("wheel_force_window_max", "wheel force, max", "kN", 1e-3),
    _Statistic("wheel_force_window_min", "wheel force, min", "kN", 1e-3, smallest=True),
    _Statistic("axle_box_acceleration_window_peak", "peak axle-box acceleration", "m/s²", 1.0),
    _Statistic(
        "wheel_force_fastener_passing_amplitude", "fastener-passing amplitude, force", "kN", 1e-3
    ),
    _Statistic("wheel_force_slab_passing_amplitude", "slab-passing amplitude, force", "kN", 1e-3),
    _Statistic(
        "axle_box_acceleration_fastener_passing_amplitude",
        "fastener-passing amplitude, acceleration",
        "m/s²",
        1.0,
    ),
    _Statistic(
        "axle_box_acceleration_slab_passing_amplitude",
        "slab-passing amplitude, acceleration",
        "m/s²",
        1.0,
    ),
)


def sections(runs: Mapping[str, xr.Dataset]) -> list[Section]:
    """Return the sections of a comparison.

    Parameters
    ----------
    runs
        Two runs or more by their labels; differences are those from the first one.
    """
    summaries = {name: summarise(run) for name, run in runs.items()}
    return [
        _settings(runs),
        _parameters(runs),
        _statistics(summaries),
        overlay.histories(runs),
        overlay.spectra(runs, summaries),
    ]


def _settings(runs: Mapping[str, xr.Dataset]) -> Section:
    """Return the section of the usual settings and residuals, and of others that differ."""
    section = Section(title="Simulation settings and coupling residuals")
    rows = [
        [name, str(run.attrs.get("command", "–")), f"{_length(run):.6g} m", str(run.sizes["time"])]
        for name, run in runs.items()
    ]
    heads = ["run", "command", "distance travelled", "records"]
    section.parts.append(Table(heads=heads, rows=rows, numeric=False))
    rows = _differing(runs, lambda name: not name.startswith(_PARAMETERS), always=_ALWAYS)
    section.parts.append(Table(heads=["", *runs], rows=rows, numeric=False))
    for name, run in runs.items():
        if not run.attrs.get("complete", 1):
            reason = run.attrs.get("ended_by") or "it ended early"
            section.remarks.append(f"{name} is an incomplete run: {reason}.")
    return section


def _length(run: xr.Dataset) -> float:
    distance = distances(run)
    return float(distance[-1] - distance[0])


def _parameters(runs: Mapping[str, xr.Dataset]) -> Section:
    section = Section(title="Parameters that differ")
    rows = _differing(runs, lambda name: name.startswith(_PARAMETERS))
    if rows:
        section.parts.append(Table(heads=["parameter", *runs], rows=rows, numeric=False))
    else:
        section.remarks.append("All parameters are the same.")
    return section


def _differing(
    runs: Mapping[str, xr.Dataset], wanted: Callable[[str], bool], always: Sequence[str] = ()
) -> list[list[str]]:
    """Return a row per attribute that is not the same in all runs, or always to be shown."""
    names = dict.fromkeys([*always, *(str(name) for run in runs.values() for name in run.attrs)])
    rows: list[list[str]] = []
    for name in names:
        if name in _NOT_COMPARED or not wanted(name):
            continue
        cells = [text(run.attrs.get(name)) for run in runs.values()]
        if len(set(cells)) > 1 or name in always:
            rows.append([_WORDS.get(name, name), *cells])
    return rows


def _statistics(summaries: Mapping[str, Summary]) -> Section:
    first = next(iter(summaries))
    section = Section(
        title="Statistics",
        intro="Of all wheels the largest value (the smallest of minima), with the wheel. In "
        f"parentheses: the difference from {first}.",
        remarks=[
            f"{name}: whole run {one.whole.text}; evaluation window {one.window.text}, {one.state}."
            for name, one in summaries.items()
        ],
    )
    if len({(one.window.periods, one.window.of) for one in summaries.values()}) > 1:
        section.remarks.append(
            "The evaluation windows are not of the same length: statistics of the window differ "
            "for this reason, too."
        )
    for caption, rows in (("Whole run", _WHOLE), ("Evaluation window", _WINDOW)):
        section.add(lambda c=caption, r=rows: _statistics_table(summaries, c, r))
    return section


def _statistics_table(
    summaries: Mapping[str, Summary], caption: str, statistics: Sequence[_Statistic]
) -> Table:
    rows: list[list[str]] = []
    for statistic in statistics:
        found = [_worst(one.data, statistic) for one in summaries.values()]
        if all(place == "" for _, place in found):
            continue
        reference = found[0][0]
        head = f"{statistic.words} ({statistic.unit})" if statistic.unit else statistic.words
        cells = [_cell(value, place) for value, place in found]
        cells[1:] = [
            cell + _difference(value, reference)
            for cell, (value, _) in zip(cells[1:], found[1:], strict=True)
        ]
        rows.append([head, *cells])
    if not rows:
        raise MissingError(f"{caption}: wheel forces and axle-box accelerations are not recorded")
    return Table(heads=["", *summaries], rows=rows, caption=caption)


def _worst(data: xr.Dataset, statistic: _Statistic) -> tuple[float, str]:
    """Return the value that counts and where it is; NaN and "" if there is none."""
    if statistic.name not in data:
        return math.nan, ""
    array = data[statistic.name]
    values = array.to_numpy().astype(float).ravel()
    if not np.isfinite(values).any():
        return math.nan, ""
    score = -values if statistic.smallest else values
    best = float(np.nanmax(score))
    # The first of those that are alike but for round-off, so that runs name the same wheel.
    index = int(np.argmax(score >= best - _ALIKE * abs(best)))
    place = channels(array)[index].name
    distance = f"{statistic.name}_distance"
    if distance in data:
        place += f", {float(data[distance].to_numpy().ravel()[index]):.2f} m"
    return float(values[index]) * statistic.factor, place


def _cell(value: float, place: str) -> str:
    return f"{number(value)}, {place}" if place else "–"


def _difference(value: float, reference: float) -> str:
    change = value - reference
    if math.isnan(change):
        return ""
    if change == 0.0:
        return " (no difference)"
    share = f", {100.0 * change / abs(reference):+.2g} %" if reference else ""
    return f" ({change:+.4g}{share})"
