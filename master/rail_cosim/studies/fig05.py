"""Fig. 5: the rail before and after a slide, by the triangular solve and by least squares.

The article finds that the triangular solve of eq. (10) diverges at the end of the window. That
depends on the sample points, which it does not name; here are three sets. Seen is the deflection at
the slide: at the middle of segments the rotation's square system is singular all the same.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.slide_plots import plot_fields
from rail_cosim.studies.track_frequency import TrackTable, compute

MODULE = "slab_track.slide_study"
SETTINGS = {
    "paper": ("paper", ()),
    "default": ("HD", ("track.window.slab_count=13", "track.window.vehicle_offset=0")),
}
"""Parameter set of the track and what is changed in it, so that both have the same window."""

LEAST_SQUARES = "least_squares"
WAYS = {
    LEAST_SQUARES: "least squares",
    "middle": "triangular, middle of equal segments",
    "hinges": "triangular, from hinge to hinge",
    "end_left_out": "triangular, end without samples",
}
"""Ways to solve eq. (10), as the track computes them."""

DIVERGED = 2.0
"""The field diverges if it becomes more than this times as large as it was."""


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "fig05.nc", options.out / "fig05.png"
    check_netcdf(data)
    found = {}
    for name, (line, window) in SETTINGS.items():
        reporter.stage(f"{name} settings")
        asked = dataclasses.replace(options, settings=(*window, *options.settings))
        found[name] = compute("slide", asked, module=MODULE, line=line)
    dataset = as_dataset(found, options)
    write_netcdf(dataset, data)
    plot_fields(dataset, picture, WAYS)
    table, conclusion = report(dataset)
    return StudyResult(table=table, conclusion=conclusion, files=[data, picture])


def as_dataset(found: dict[str, TrackTable], options: StudyOptions) -> xr.Dataset:
    """Return fields over the window and what jumps, by setting and way of solving."""
    columns = {name: one.columns for name, one in found.items()}
    dataset = xr.Dataset(attrs={"study": "fig05", "command": options.command})
    quantities = (("deflection", "m"), ("acceleration", "m/s2"))
    for index, (name, unit) in enumerate(quantities):
        target = np.array([one["target"][index] for one in columns.values()])
        after = np.array([one["after"][:, index] for one in columns.values()])
        about = {"units": unit, "long_name": f"{name} of the left rail"}
        dataset[f"target_{name}"] = (("setting", "place"), target, about)
        dataset[name] = (("setting", "way", "place"), after, about)
        jump = np.abs(after - target[:, None]).max(axis=-1)
        dataset[f"{name}_jump"] = (("setting", "way"), jump, about)
    single = (("wheel_force_jump", "N"), ("condition_number", "1"))
    for name, unit in (*single, ("rotation_condition_number", "1")):
        values = np.array([one[name] for one in columns.values()])
        dataset[name] = (("setting", "way"), values, {"units": unit})
    place = next(iter(columns.values()))["place"]
    dataset = dataset.assign_coords(
        setting=list(columns),
        way=list(WAYS),
        place=("place", place, {"units": "m", "long_name": "place in the new window"}),
    )
    dataset["diverges"] = diverges(dataset)
    return dataset


def diverges(dataset: xr.Dataset) -> xr.DataArray:
    """Return where deflection or acceleration became larger than it can be."""
    grown = xr.zeros_like(dataset["deflection_jump"], dtype=bool)
    for name in ("deflection", "acceleration"):
        before = abs(dataset[f"target_{name}"]).max("place")
        after = abs(dataset[name]).max("place", skipna=False)
        # Not a number, where there is no solution, is no bound kept either.
        grown = grown | ~(after <= DIVERGED * before)
    return grown


def report(dataset: xr.Dataset) -> tuple[Table, str]:
    """Return the table and the conclusion."""
    table = Table(title="Rail at a window shift", title_justify="left", title_style="")
    heads = ("solution of (10)", "condition:\ndeflection;\nrotation")
    jumps = ("z jumps,\nmm", "its acc.,\nm/s2", "force,\nN")
    for head in (*heads, *jumps, "diverges"):
        table.add_column(head, justify="left" if head == heads[0] else "right")
    for setting in dataset["setting"].to_numpy():
        for way, label in WAYS.items():
            one = dataset.sel(setting=setting, way=way)
            force = float(one["wheel_force_jump"])
            table.add_row(
                f"{setting}: {label}",
                "; ".join(
                    f"{float(one[name]):.2g}"
                    for name in ("condition_number", "rotation_condition_number")
                ),
                f"{1e3 * float(one['deflection_jump']):.2g}",
                f"{float(one['acceleration_jump']):.2g}",
                f"{force:.2g}",
                "yes" if bool(one["diverges"]) else "no",
            )
    return table, conclude(dataset)


def conclude(dataset: xr.Dataset) -> str:
    """Return the verdicts as a sentence."""
    plain = not dataset["diverges"].sel(way=LEAST_SQUARES).any()
    others = dataset["diverges"].sel(setting="paper").drop_sel(way=LEAST_SQUARES)
    bad = [WAYS[str(way)] for way in others["way"].to_numpy() if others.sel(way=way)]
    good = [WAYS[str(way)] for way in others["way"].to_numpy() if not others.sel(way=way)]
    return (
        f"least squares does not diverge: {'pass' if plain else 'FAIL'}; the triangular solve "
        f"diverges: {'pass' if bad else 'FAIL'}, with some sample points "
        f"(deflection diverges: {'; '.join(bad) or 'none'}. Does not: {'; '.join(good) or 'none'})"
    )
