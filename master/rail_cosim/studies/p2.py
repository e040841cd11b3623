"""P2 resonance over the stiffness of the fasteners: formula and coupled eigenfrequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.frequency_plots import plot_p2
from rail_cosim.studies.track_frequency import TrackTable, compute

PLACES = ("mid_bay", "fastener")
_FORMULAS = {
    "formula": "P2 frequency by eq. (16) with the bay of the track",
    "formula_article": "P2 frequency by eq. (16) with the bay of the article's text, 0.60 m",
}
_MODES = {
    "rigid_contact": "half a wheelset rigidly on the track",
    "hertz": "wheelset on Hertz springs on the track",
    "primary": "wheelset on Hertz springs, under its primary suspension",
    "roll": "roll of the wheelset on Hertz springs, under its primary suspension",
}
_MN, _KMH = 1e-6, 3.6
_ARTICLE = {40e6: (51.4, 116.4), 140e6: (83.1, 188.2)}
"""Frequencies (Hz) and speeds (km/h) in the article's section 3.1.2, by pad stiffness."""


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "p2.nc", options.out / "p2.png"
    check_netcdf(data)
    reporter.stage("computing eigenfrequencies")
    found = compute("p2", options, wheelset=True)
    dataset = as_dataset(found, options.command)
    write_netcdf(dataset, data)
    plot_p2(dataset, _ARTICLE, picture)
    return StudyResult(table=as_table(dataset), conclusion=conclude(dataset), files=[data, picture])


def as_dataset(found: TrackTable, command: str) -> xr.Dataset:
    """Return frequencies, damping ratios and resonance speeds over place and pad stiffness."""
    dataset, columns = found.described("p2", command), found.columns
    for name, meaning in _FORMULAS.items():
        about = {"units": "Hz", "long_name": meaning}
        dataset[f"{name}_frequency"] = ("pad_stiffness", columns[f"{name}_frequency"], about)
    over = ("place", "pad_stiffness")
    for name, meaning in _MODES.items():
        about = {"units": "Hz", "long_name": f"natural frequency |s|/(2 pi): {meaning}"}
        dataset[f"{name}_frequency"] = (over, columns[f"{name}_frequency"], about)
        about = {"units": "1", "long_name": f"damping ratio: {meaning}"}
        dataset[f"{name}_damping_ratio"] = (over, columns[f"{name}_damping_ratio"], about)
    about = {
        "units": "m/s",
        "long_name": "speed at which fasteners are passed at primary_frequency",
    }
    dataset["resonance_speed"] = (over, columns["resonance_speed"], about)
    about = {"units": "N/m", "long_name": "vertical stiffness of one fastener"}
    pads = ("pad_stiffness", columns["pad_stiffness"], about)
    return dataset.assign_coords(pad_stiffness=pads, place=list(PLACES))


def as_table(dataset: xr.Dataset) -> Table:
    """Return a row per stiffness: formula, modes and speeds, mean of both places or both."""
    title = "P2 resonance, Hz: eq. (16); coupled modes, mean of mid-bay and over a fastener"
    table = Table(title=title, title_justify="left", title_style="")
    bay = dataset.attrs["spacing"]
    heads = ["pad\nMN/m", "(16)\n0.60 m", f"(16)\n{bay:g} m", "rigid\ncontact", "Hertz\nspring"]
    heads += ["with primary\n(both places)", "damping\nratio", "speed\nkm/h"]
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    mean = dataset.mean("place")
    for pad in dataset["pad_stiffness"].to_numpy():
        row = mean.sel(pad_stiffness=pad)
        names = ("formula_article", "formula", "rigid_contact", "hertz")
        cells = [f"{_MN * pad:g}", *(f"{float(row[f'{name}_frequency']):.1f}" for name in names)]
        both = dataset["primary_frequency"].sel(pad_stiffness=pad)
        cells.append(" to ".join(f"{float(both.sel(place=place)):.1f}" for place in PLACES))
        cells.append(f"{float(row['primary_damping_ratio']):.3f}")
        cells.append(f"{_KMH * float(row['resonance_speed']):.1f}")
        table.add_row(*cells)
    return table


def conclude(dataset: xr.Dataset) -> str:
    """Compare with the article's two figures."""
    parts = []
    for pad, (frequency, speed) in _ARTICLE.items():
        row = dataset.sel(pad_stiffness=pad, method="nearest")
        if not np.isclose(float(row["pad_stiffness"]), pad):
            continue
        coupled = row["primary_frequency"].mean("place")
        own = _KMH * float(row["resonance_speed"].mean("place"))
        parts.append(
            f"{_MN * pad:g} MN/m: article {frequency:g} Hz and {speed:g} km/h, (16) "
            f"{float(row['formula_frequency']):.1f} Hz, coupled mode {float(coupled):.1f} Hz and "
            f"{own:.0f} km/h"
        )
    return "; ".join(parts)
