"""Contact geometry of a wheelset, from the track package in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.builder import child_environment
from rail_cosim.errors import ParameterError, RailCosimError, UnknownNameError
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.plots import plot_contact_geometry

MODULE = "slab_track.contact"
SETTINGS = {
    "track.contact.wheel_profile": "--wheel",
    "track.contact.rail_profile": "--rail",
    "track.rail.gauge": "--gauge",
    "track.rail.gauge_measurement_depth": "--depth",
    "track.rail.cant": "--cant",
    "track.contact.rolling_circle_distance": "--rolling-circle-distance",
    "track.contact.wheel_radius": "--radius",
    "track.contact.reference_penetration": "--penetration",
}
"""Parameters that matter here, and the options that they are."""

_POINTS, _QUICK_POINTS = 161, 33  # from -8 to 8 mm: each 0.1 or 0.5 mm
_SHOWN = 1e-3  # m between the rows of the printed table
_SIDES = ("left", "right")
_MM = 1e3
_COLUMNS = {
    "roll_angle": ("rad", "roll angle of the wheelset"),
    "vertical_displacement": ("m", "height of the wheelset, downwards from the middle"),
    "rolling_radius_difference": ("m", "rolling radius of the right wheel less the left"),
    "contact_angle": ("rad", "inclination of the contact plane"),
    "wheel_position": ("m", "contact point on the wheel, outwards from the rolling circle"),
    "rail_position": ("m", "contact point on the rail, outwards from the top of the head"),
}


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    arguments = as_arguments(options)
    data, picture = options.out / "contact_geometry.nc", options.out / "contact_geometry.png"
    check_netcdf(data)
    reporter.stage("computing the contact")
    about, columns = compute(arguments)
    dataset = as_dataset(about, columns)
    dataset.attrs["command"] = options.command
    write_netcdf(dataset, data)
    title = describe(about)
    plot_contact_geometry(dataset, title, picture)
    table = as_table(dataset, title)
    return StudyResult(table=table, conclusion=conclude(about), files=[data, picture])


def conclude(about: dict[str, Any]) -> str:
    """Return the equivalent conicity in a sentence, or why it is not defined."""
    undefined = about.get("equivalent_conicity_not_defined")
    value = f"not defined: {undefined}" if undefined else f"{about['equivalent_conicity']:.4f}"
    return f"equivalent conicity at {_MM * about['conicity_amplitude']:g} mm: {value}"


def as_arguments(options: StudyOptions) -> list[str]:
    """Return the command's arguments.

    Raises
    ------
    ParameterError
        For a setting that is none of :data:`SETTINGS`.
    """
    arguments = ["--points", str(_QUICK_POINTS if options.quick else _POINTS)]
    for text in options.settings:
        name, equals, value = text.partition("=")
        name = name.strip()
        if name not in SETTINGS:
            what = "parameter for this study"
            raise UnknownNameError(name, value.strip(), SETTINGS, what, listed=True)
        if not equals:
            raise ParameterError("--set", text, "there is no value", f"write {name}=VALUE")
        arguments.append(f"{SETTINGS[name]}={value.strip()}")
    return arguments


def compute(arguments: list[str]) -> tuple[dict[str, Any], dict[str, list[float]]]:
    """Return settings and columns, computed by ``python -m slab_track.contact``.

    Raises
    ------
    RailCosimError
        With what it says, if it fails.
    """
    with tempfile.TemporaryDirectory(prefix="rail-cosim-") as folder:
        out = Path(folder, "contact.json")
        command = [sys.executable, "-m", MODULE, *arguments, "--out", str(out)]
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env=child_environment()
        )
        if done.returncode != 0:
            said = done.stderr.strip().splitlines()
            reason = said[-1] if said else f"exit status {done.returncode}"
            raise RailCosimError(reason.removeprefix(f"{MODULE}: error: "))
        content = json.loads(out.read_text(encoding="utf-8"))
    return content["about"], content["columns"]


def describe(about: dict[str, Any]) -> str:
    """Return what stands on what, in a line."""
    return (
        f"{Path(about['wheel']).name} on {Path(about['rail']).name}, gauge "
        f"{_MM * about['gauge']:g} mm at {_MM * about['depth']:g} mm, cant {about['cant']:g}, "
        f"rolling circles {_MM * about['rolling_circle_distance']:g} mm apart"
    )


def as_dataset(about: dict[str, Any], columns: dict[str, list[float]]) -> xr.Dataset:
    """Return the table as a Dataset over lateral displacement and side."""
    dataset = xr.Dataset(attrs={"study": "contact-geometry", **about})
    for name, (unit, meaning) in _COLUMNS.items():
        described = {"units": unit, "long_name": meaning}
        if name in columns:
            dataset[name] = ("lateral_displacement", columns[name], described)
        else:
            values = np.column_stack([columns[f"{side}_{name}"] for side in _SIDES])
            dataset[name] = (("lateral_displacement", "side"), values, described)
    about_y = {"units": "m", "long_name": "lateral displacement of the wheelset, to the right"}
    y = ("lateral_displacement", columns["lateral_displacement"], about_y)
    return dataset.assign_coords(lateral_displacement=y, side=list(_SIDES))


def as_table(dataset: xr.Dataset, title: str) -> Table:
    """Return the rows at whole millimetres as a table for the terminal."""
    table = Table(title=title, title_justify="left", title_style="")
    heads = ["y\nmm", "radius diff.\nmm"]
    for side in _SIDES:
        heads += [f"{side}\nangle, deg", "wheel\nmm", "rail\nmm"]
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    for y in dataset["lateral_displacement"].to_numpy():
        if abs(y / _SHOWN - round(y / _SHOWN)) > 1e-6:
            continue
        row = dataset.sel(lateral_displacement=y)
        cells = [f"{_MM * y:.0f}", f"{_MM * float(row['rolling_radius_difference']):.3f}"]
        for side in _SIDES:
            wheel = row.sel(side=side)
            cells.append(f"{np.degrees(float(wheel['contact_angle'])):.2f}")
            cells += [
                f"{_MM * float(wheel[name]):.2f}" for name in ("wheel_position", "rail_position")
            ]
        table.add_row(*cells)
    return table
