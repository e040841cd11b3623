"""Table 1 of the article, measured: moving mass, moving irregularity, sliding window; and a ring.

The smooth HD line at 300 km/h with level contact, each model over the same way. What an endless
line is worth to a model, what it sees of fasteners and slabs, what it costs, and how far its
wheel forces are from the sliding window's.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.errors import RunError
from rail_cosim.fmu import FmuSlave
from rail_cosim.options import RunOptions
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.runner import execute, find_fmus, gather_parameters
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.slide import LEVEL
from rail_cosim.studies.table1_plot import plot_models
from rail_cosim.summary import amplitudes
from rail_cosim.window import distances, periods

_SPEED = 300.0
_SLABS, _MODES = 13, 256  # the article's window; modes with the default's shortest wave
_PITCH, _WHEELBASE = 5.032, 20.3  # m; HD line, article's vehicle
_REAR, _FRONT = 15.0, 15.0  # m; room behind and before a moving mass in its long window
_RANGE = (2 * _PITCH, 3 * _PITCH)
"""Ways (m) between which amplitudes are taken: the third slab, which all models reach."""
_FELT = 1e-3
"""An end of the window is felt where a force differs by this share of the static load."""

MODELS: Mapping[str, str] = {
    "moving_mass": "moving mass",
    "moving_mass_long": "moving mass, long window",
    "moving_irregularity": "moving irregularity",
    "sliding": "sliding window",
    "cyclic": "ring",
}
_HEADS = {
    "moving_mass": "moving\nmass",
    "moving_mass_long": "in long\nwindow",
    "moving_irregularity": "moving\nirreg.",
    "sliding": "sliding\nwindow",
    "cyclic": "\nring",
}
REFERENCE = "sliding"

ARTICLE: Mapping[str, Mapping[str, str]] = {
    "distance": {"moving_mass": "no", "moving_irregularity": "yes", "sliding": "yes"},
    "sleepers": {"moving_mass": "yes", "moving_irregularity": "no", "sliding": "yes"},
    "cost": {"moving_mass": "yes", "moving_irregularity": "yes", "sliding": "yes"},
}
"""Table 1: long-distance simulation, periodic impact by discrete supports, low cost."""

_SEEN, _UNSEEN, _LOW_COST = 0.99, 0.01, 1.5
"""Here: share of the sliding window's sleeper-passing amplitude that counts as seen, and as not
seen; CPU time over the sliding window's that counts as equally low."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Measured:
    """One model's run.

    Attributes
    ----------
    run
        Its records.
    ended
        Whether it ended before the whole way.
    cpu
        CPU seconds of the pair per slab length, one for each repetition.
    degrees
        Second-order degrees of freedom of the track: waves of both rails, vertical and of
        both branches, and slab modes.
    state_size
        Of the track's state in bytes.
    """

    run: xr.Dataset
    ended: bool
    cpu: list[float]
    degrees: int
    state_size: int


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "table1.nc", options.out / "table1.png"
    check_netcdf(data)
    distance, rounds = (30.0, 2) if options.quick else (100.0, 5)
    found: dict[str, Measured] = {}
    for repetition in range(rounds):  # by turns: what else the machine does hits all alike
        for model, words in MODELS.items():
            reporter.stage(f"{words}, {repetition + 1} of {rounds}")
            one = measure(model, distance, options, reporter)
            if model in found:
                one = dataclasses.replace(found[model], cpu=[*found[model].cpu, *one.cpu])
            found[model] = one
    dataset = as_dataset(found)
    dataset.attrs |= {"study": "table1", "command": options.command, "planned_way": distance}
    write_netcdf(dataset, data)
    plot_models(dataset, picture, MODELS)
    return StudyResult(table=as_table(dataset), conclusion=conclude(dataset), files=[data, picture])


def model_settings(model: str, distance: float) -> list[str]:
    """Return the settings of a model; a long window holds the whole way, in modes as fine."""
    method = "moving_mass" if model == "moving_mass_long" else model
    slabs = _SLABS
    if model == "moving_mass_long":
        room = distance + _WHEELBASE + _REAR + _PITCH + _FRONT
        slabs = max(_SLABS, math.ceil(room / _PITCH))
    return [
        f"track.window.method={method}",
        f"track.window.slab_count={slabs}",
        "track.window.vehicle_offset=0",
        f"track.rail.mode_count={round(_MODES * slabs / _SLABS)}",
    ]


def measure(model: str, distance: float, options: StudyOptions, reporter: Reporter) -> Measured:
    """Run one model."""
    asked = RunOptions(
        speed=_SPEED,
        distance=distance,
        settings=[LEVEL, *model_settings(model, distance), *options.settings],
        command=options.command,
    )
    ended = False
    try:
        found = execute(asked, reporter)
    except RunError as error:
        if model != "moving_mass" or error.dataset is None:  # all others have no end
            raise
        found, ended = error.dataset, True
    about = found.attrs
    per_slab = _PITCH / (_SPEED / 3.6) / float(about["macro_step"])
    cpu = float(about["cpu_seconds"]) / int(about["steps"]) * per_slab
    return Measured(
        run=found,
        ended=ended,
        cpu=[cpu],
        degrees=degrees_of_freedom(about),
        state_size=_state_size(asked),
    )


def degrees_of_freedom(about: Mapping[str, Any]) -> int:
    """Return the track's vertical degrees of freedom from the attributes of a run."""
    waves = int(about["track.rail.mode_count"])
    if about["track.window.method"] == "cyclic":
        waves = 2 * (waves // 2) + 1  # the constant, and pairs of cosine and sine
    slabs = int(about["track.window.slab_count"]) * int(about["track.slab.mode_count"])
    return 2 * 2 * waves + slabs


def _state_size(options: RunOptions) -> int:
    descriptions, presets = find_fmus(options)
    values = gather_parameters(options, descriptions, presets)["track"]
    description = descriptions["track"]
    with FmuSlave(description.path, "track", description=description) as track:
        track.set(values)
        track.setup(0.0, 1.0)
        track.enter_initialization()
        track.exit_initialization()
        return len(track.state_bytes())


def as_dataset(found: Mapping[str, Measured]) -> xr.Dataset:
    """Return what was measured, over the models; forces of the leading left wheel over the way."""
    reference = found[REFERENCE]
    way = distances(reference.run)
    load = float(reference.run["normal_force"][0].mean())
    rows = []
    for one in found.values():
        force = one.run["normal_force"].transpose("time", "wheelset", "side").to_numpy()
        count = min(len(force), len(way))
        off = np.abs(force[:count] - reference.run["normal_force"].to_numpy()[:count])
        rows.append(_figures(one, reference, off.max(axis=(1, 2)), load))
    names = rows[0].keys()
    dataset = xr.Dataset({n: xr.concat([r[n] for r in rows], dim="model") for n in names})
    return dataset.assign_coords(model=list(found)).assign_attrs(static_wheel_load=load)


def _figures(
    one: Measured, reference: Measured, off: np.ndarray, load: float
) -> dict[str, xr.DataArray]:
    way = distances(one.run)
    there = (way > _RANGE[0]) & (way <= _RANGE[1])
    force = one.run["normal_force"].transpose("time", "wheelset", "side").to_numpy()
    sleepers, slabs = amplitudes(way[there], force[there], list(periods(one.run)))
    cpu, least = min(one.cpu), min(reference.cpu)  # the least disturbed repetitions
    ways = distances(reference.run)

    def padded(values: np.ndarray) -> xr.DataArray:
        whole = np.full(len(ways), np.nan)
        whole[: len(values)] = values[: len(ways)]
        about = {"units": "N"}
        return xr.DataArray(whole, dims="distance", coords={"distance": ways}, attrs=about)

    def number(value: float, unit: str, words: str) -> xr.DataArray:
        return xr.DataArray(value, attrs={"units": unit, "long_name": words})

    settled = off[ways[: len(off)] > _RANGE[0]]
    clean = off[(ways > _RANGE[0])[: len(off)] & (ways <= _RANGE[1])[: len(off)]]
    return {
        "way": number(float(way[-1]), "m", "distance travelled"),
        "ended": number(int(one.ended), "1", "1: the run ended before the whole distance"),
        "sleeper_amplitude": number(float(sleepers.mean()), "N", "at sleeper passing"),
        "slab_amplitude": number(float(slabs.mean()), "N", "at slab passing"),
        "difference": number(float(clean.max()), "N", "largest, third slab, from sliding"),
        "whole_difference": number(float(settled.max()), "N", "largest, from the third slab on"),
        "felt_at": number(_felt_at(one, ways, off, load), "m", "the end is felt from"),
        "cpu": number(cpu, "s", "CPU time of the pair per slab length"),
        "cpu_ratio": number(cpu / least, "1", "CPU time over the sliding window's"),
        "degrees_of_freedom": number(one.degrees, "1", "of the track, vertical"),
        "state_size": number(one.state_size, "B", "state of the track"),
        "leading_force": padded(force[:, 0, 0]),
        "force_difference": padded(off),
    }


def _felt_at(one: Measured, ways: np.ndarray, off: np.ndarray, load: float) -> float:
    """Return the first way (m) at which an end of the window is felt, NaN if there is none."""
    felt = np.flatnonzero(off > _FELT * load)
    has_end = one.run.attrs["track.window.method"] == "moving_mass"
    return float(ways[felt[0]]) if has_end and len(felt) else math.nan


def ratings(dataset: xr.Dataset) -> dict[str, dict[str, str]]:
    """Return our ratings by property and model, in the article's words."""
    seen = dataset["sleeper_amplitude"] / dataset["sleeper_amplitude"].sel(model=REFERENCE)
    found: dict[str, dict[str, str]] = {name: {} for name in ARTICLE}
    for model in dataset["model"].to_numpy():
        at = {"model": model}
        share = float(seen.sel(at))
        found["distance"][model] = "no" if int(dataset["ended"].sel(at)) else "yes"
        found["sleepers"][model] = "yes" if share > _SEEN else "no" if share < _UNSEEN else "partly"
        found["cost"][model] = "yes" if float(dataset["cpu_ratio"].sel(at)) <= _LOW_COST else "no"
    return found


def as_table(dataset: xr.Dataset) -> Table:
    """Return a column for each model, the article's rating in parentheses beside ours."""
    table = Table(title="Table 1, measured at 300 km/h", title_justify="left", title_style="")
    table.add_column("")
    models = [str(model) for model in dataset["model"].to_numpy()]
    for model in models:
        table.add_column(_HEADS[model], justify="right")
    ours = ratings(dataset)

    def row(words: str, name: str, form: str, factor: float = 1.0) -> None:
        values = [factor * float(dataset[name].sel(model=model)) for model in models]
        table.add_row(words, *("-" if math.isnan(v) else format(v, form) for v in values))

    def rated(words: str, name: str) -> None:
        cells = (f"{ours[name][model]} ({ARTICLE[name].get(model, '-')})" for model in models)
        table.add_row(f"{words} (article)", *cells)
        table.add_section()

    row(f"way of {float(dataset.attrs['planned_way']):g} m, m", "way", ".1f")
    row("end felt from, m", "felt_at", ".1f")
    rated("long distance", "distance")
    row("at sleeper passing, N", "sleeper_amplitude", ".1f")
    row("at slab passing, N", "slab_amplitude", ".2f")
    row("off sliding, slab 3, N", "difference", ".3g")
    row("off sliding, later, N", "whole_difference", ".3g")
    rated("sees sleepers", "sleepers")
    row("CPU time over sliding", "cpu_ratio", ".2f")
    row("CPU per slab length, s", "cpu", ".3f")
    row("degrees of freedom", "degrees_of_freedom", ".0f")
    row("state of track, kB", "state_size", ".0f", 1e-3)
    rated("low cost", "cost")
    return table


def conclude(dataset: xr.Dataset) -> str:
    """Return how many of the article's ratings are found, and which are not."""
    ours = ratings(dataset)
    total, other = 0, []
    for rated, by_model in ARTICLE.items():
        for model, stated in by_model.items():
            total += 1
            if ours[rated][model] != stated:
                other.append(f"{MODELS[model]}, {rated}: {ours[rated][model]}, not {stated}")
    text = f"{total - len(other)} of {total} ratings of the article are found"
    return text + (f"; {'; '.join(other)}" if other else "")
