"""Fig. 10 of the article: shape of the coupled P2 mode, for two stiffnesses of the fasteners."""

from __future__ import annotations

import dataclasses

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.frequency_plots import plot_mode
from rail_cosim.studies.track_frequency import TrackTable, add_complex, compute

PAD = "track.fastener.vertical_stiffness"
CASES = (40e6, 140e6)
"""Nominal and winter stiffness of a fastener, N/m, unless one is set."""

_MN = 1e-6
_SHAPES = {
    "rail": (("rail_position",), "deflection of the rail"),
    "fastener": (("fastener_position",), "compression of the fasteners"),
    "seat": (("fastener_position",), "deflection of the slabs at the rail seats"),
    "slab": (("line", "slab", "slab_point"), "deflection of the slabs"),
}
_FIGURES = {
    "natural_frequency": ("Hz", "|s|/(2 pi)"),
    "damped_frequency": ("Hz", "Im s/(2 pi)"),
    "damping_ratio": ("1", "-Re s/|s|"),
    "formula_frequency": ("Hz", "P2 frequency by eq. (16) with the bay of the track"),
    "rail_under_wheel_amplitude": ("1", "rail under the wheel over wheelset"),
    "rail_under_wheel_phase": ("rad", "phase of the rail under the wheel"),
    "seat_amplitude": ("1", "largest deflection at a rail seat over wheelset"),
    "seat_amplitude_phase": ("rad", "phase of the slab there"),
    "pad_damping": ("N.s/m", "vertical damping of one fastener"),
    "spacing": ("m", "distance of the fasteners"),
}


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "fig10.nc", options.out / "fig10.png"
    check_netcdf(data)
    chosen = any(text.partition("=")[0].strip() == PAD for text in options.settings)
    added = [[]] if chosen else [[f"{PAD}={pad!r}"] for pad in CASES]
    tables = []
    for more in added:
        reporter.stage("computing the coupled mode")
        changed = dataclasses.replace(options, settings=[*options.settings, *more])
        tables.append(compute("mode", changed, wheelset=True))
    dataset = as_dataset(tables, options.command)
    write_netcdf(dataset, data)
    plot_mode(dataset, picture)
    parts = []
    for pad in dataset["pad_stiffness"].to_numpy():
        row = dataset.sel(pad_stiffness=pad)
        parts.append(
            f"{_MN * pad:g} MN/m: {float(row['natural_frequency']):.1f} Hz, wheelset and rail "
            f"{abs(np.degrees(float(row['rail_under_wheel_phase']))):.1f} degrees apart, slab at "
            f"{100 * float(row['seat_amplitude']):.1f} % of the wheelset's amplitude"
        )
    return StudyResult(table=as_table(dataset), conclusion="; ".join(parts), files=[data, picture])


def as_dataset(tables: list[TrackTable], command: str) -> xr.Dataset:
    """Return figures and shapes over the stiffness of the fasteners."""
    found = [_one(table) for table in tables]
    dataset = xr.concat(found, dim="pad_stiffness", combine_attrs="drop_conflicts")
    dataset["pad_stiffness"].attrs = {
        "units": "N/m",
        "long_name": "vertical stiffness of one fastener",
    }
    dataset.attrs |= {"study": "fig10", "command": command}
    return dataset


def _one(table: TrackTable) -> xr.Dataset:
    columns, about = table.columns, table.about
    plain = table._replace(about={})
    dataset = plain.described("fig10", "")
    for name, (unit, meaning) in _FIGURES.items():
        dataset[name] = ((), about[name], {"units": unit, "long_name": meaning})
    for name, (dims, meaning) in _SHAPES.items():
        add_complex(dataset, name, dims, columns[name], "1", f"{meaning} over wheelset's motion")
    along = {"units": "m", "long_name": "distance from the wheelset along the line"}
    dataset = dataset.assign_coords(
        rail_position=("rail_position", columns["rail_position"], along),
        fastener_position=("fastener_position", columns["fastener_position"], along),
        slab_position=(("slab", "slab_point"), columns["slab_position"], along),
        line=["rail", "edge"],
    )
    return dataset.expand_dims(pad_stiffness=[about["pad_stiffness"]]).assign_coords(
        slab_position=(("slab", "slab_point"), columns["slab_position"], along)
    )


def as_table(dataset: xr.Dataset) -> Table:
    """Return a column per stiffness."""
    title = "coupled P2 mode: wheelset on Hertz springs on rails, fasteners and slabs"
    table = Table(title=title, title_justify="left", title_style="")
    table.add_column("")
    for pad in dataset["pad_stiffness"].to_numpy():
        table.add_column(f"{_MN * pad:g} MN/m", justify="right", no_wrap=True)
    rows = (
        ("natural frequency, Hz", "natural_frequency", 1.0, ".2f"),
        ("damped frequency, Hz", "damped_frequency", 1.0, ".2f"),
        ("damping ratio", "damping_ratio", 1.0, ".4f"),
        ("formula (16), Hz", "formula_frequency", 1.0, ".2f"),
        ("rail under the wheel over wheelset", "rail_under_wheel_amplitude", 1.0, ".4f"),
        ("its phase, deg", "rail_under_wheel_phase", np.degrees(1.0), ".2f"),
        ("slab at the seats over wheelset", "seat_amplitude", 1.0, ".4f"),
        ("its phase, deg", "seat_amplitude_phase", np.degrees(1.0), ".2f"),
    )
    for head, name, factor, form in rows:
        values = dataset[name].to_numpy() * factor
        table.add_row(head, *(format(value, form) for value in values))
    return table
