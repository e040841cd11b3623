"""Receptance of the rail heads over frequency, half-way between and over fasteners."""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.frequency_plots import plot_receptance
from rail_cosim.studies.track_frequency import TrackTable, add_complex, compute

PLACES = ("mid_bay", "fastener")
_COLUMNS = {
    "same_rail": ("m/N", "vertical deflection per vertical force on the same rail"),
    "other_rail": ("m/N", "vertical deflection per vertical force on the other rail"),
    "next_wheel": ("m/N", "vertical deflection of the same rail one axle distance further"),
    "lateral": ("m/N", "lateral displacement of the head per lateral force at it"),
    "lateral_per_moment": ("1/N", "lateral displacement of the head per roll moment"),
    "roll": ("rad/(N.m)", "roll of the rail per roll moment"),
}
_SHOWN = (5.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 1500.0)  # Hz
_PER_NANO = 1e9


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "receptance.nc", options.out / "receptance.png"
    check_netcdf(data)
    reporter.stage("computing receptances")
    found = compute("receptance", options)
    dataset = as_dataset(found, options.command)
    write_netcdf(dataset, data)
    plot_receptance(dataset, picture)
    about = found.about
    conclusion = (
        f"pinned-pinned frequency: {about['pinned_pinned_frequency']:.1f} Hz in closed form; with "
        f"lightly damped fasteners ({about['pinned_pinned_damping']:g} N.s/m) the receptance has "
        f"its peak between them at {about['pinned_pinned_peak']:.1f} Hz and its dip over one at "
        f"{about['pinned_pinned_dip']:.1f} Hz"
    )
    return StudyResult(table=as_table(dataset), conclusion=conclusion, files=[data, picture])


def as_dataset(found: TrackTable, command: str) -> xr.Dataset:
    """Return magnitudes and phases over place and frequency."""
    dataset = found.described("receptance", command)
    for name, (unit, meaning) in _COLUMNS.items():
        add_complex(dataset, name, ("place", "frequency"), found.columns[name], unit, meaning)
    about = {"units": "Hz", "long_name": "frequency"}
    frequency = ("frequency", found.columns["frequency"], about)
    return dataset.assign_coords(frequency=frequency, place=list(PLACES))


def as_table(dataset: xr.Dataset) -> Table:
    """Return magnitudes and phases at round frequencies as a table for the terminal."""
    title = "receptance of the rail head, nm/N and degrees: mid-bay, and over a fastener"
    table = Table(title=title, title_justify="left", title_style="")
    heads = ["\nHz", "mid-bay\nvert.", "\ndeg", "fastener\nvert.", "\ndeg"]
    heads += ["other\nrail", "next\nwheel", "mid-bay\nlat.", "fastener\nlat."]
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    lateral = bool((dataset["lateral_magnitude"] > 0.0).all())
    for f in _SHOWN:
        cells = [f"{f:g}"]
        for place in PLACES:
            cells.append(f"{_magnitude(dataset, 'same_rail', place, f):.3f}")
            cells.append(f"{_phase(dataset, place, f):.0f}")
        cells.append(f"{_magnitude(dataset, 'other_rail', 'mid_bay', f):.3f}")
        cells.append(f"{_magnitude(dataset, 'next_wheel', 'mid_bay', f):.3f}")
        sideways = [_magnitude(dataset, "lateral", place, f) if lateral else 0 for place in PLACES]
        cells += [f"{value:.2f}" for value in sideways]
        table.add_row(*cells)
    return table


def _magnitude(dataset: xr.Dataset, name: str, place: str, f: float) -> float:
    """Interpolate on logarithmic axes, in nm/N."""
    values = dataset[f"{name}_magnitude"].sel(place=place).to_numpy()
    x = np.log(dataset["frequency"].to_numpy())
    return _PER_NANO * float(np.exp(np.interp(np.log(f), x, np.log(values))))


def _phase(dataset: xr.Dataset, place: str, f: float) -> float:
    values = np.unwrap(dataset["same_rail_phase"].sel(place=place).to_numpy())
    x = np.log(dataset["frequency"].to_numpy())
    return float(np.degrees(np.interp(np.log(f), x, values)))
