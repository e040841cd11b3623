"""Are slides felt? Two runs that slide at different places, for several ways of sliding."""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.options import RunOptions
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.runner import Reporter, execute
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.slide_plots import plot_slide

LEVEL = "track.contact.model=vertical"
_HARD = ("track.fastener.vertical_stiffness=200e6", "track.fastener.vertical_damping=10e3")
_PLAIN = ("track.rail.residual_compliance=false",)
_SHARP = ("track.rail.passage_width=0",)

VARIANTS: dict[str, tuple[float, tuple[str, ...]]] = {
    "default": (300.0, ()),
    "200 plain modes (article)": (300.0, ("track.rail.mode_count=200", *_PLAIN)),
    "200 modes, sharp end": (300.0, ("track.rail.mode_count=200", *_SHARP)),
    "256 modes, sharp end": (300.0, ("track.rail.mode_count=256", *_SHARP)),
    "400 modes, passage 0.5": (
        300.0,
        ("track.rail.mode_count=400", "track.rail.passage_width=0.5"),
    ),
    "512 samples": (300.0, ("track.window.sample_count=512",)),
    "ring": (300.0, ("track.window.method=cyclic",)),
    "hard pads, 180 km/h": (180.0, _HARD),
    "hard pads, no end damping": (180.0, (*_HARD, "track.window.end_damping=0")),
    "hard pads, ring": (180.0, (*_HARD, "track.window.method=cyclic")),
}
"""Speed in km/h and settings of each way."""

LIMITS = {"default": 1e-4, "hard pads, 180 km/h": 1e-3}
"""What the largest difference may be, in static wheel loads."""

_OFFSET = 2.5  # m; half a slab pitch, so that the two runs slide at different places
_DISTANCE, _QUICK_DISTANCE = 40.0, 12.0  # m
_QUICK = ("default", "200 plain modes (article)", "hard pads, 180 km/h")


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "slide.nc", options.out / "slide.png"
    check_netcdf(data)
    names = _QUICK if options.quick else tuple(VARIANTS)
    found, load = {}, 0.0
    for name in names:
        reporter.stage(name)
        found[name], load = disturbance(name, options, reporter)
    dataset = as_dataset(found, load, options)
    write_netcdf(dataset, data)
    plot_slide(dataset, picture)
    return StudyResult(
        table=as_table(found, load), conclusion=conclude(found, load), files=[data, picture]
    )


def disturbance(name: str, options: StudyOptions, reporter: Reporter) -> tuple[xr.DataArray, float]:
    """Return the largest difference of any wheel's force over the way, N, and the static load."""
    speed, settings = VARIANTS[name]
    distance = _QUICK_DISTANCE if options.quick else _DISTANCE
    runs = [
        execute(
            RunOptions(
                speed=speed,
                distance=distance,
                settings=[
                    LEVEL,
                    *settings,
                    *options.settings,
                    f"track.window.vehicle_offset={offset}",
                ],
                command=options.command,
            ),
            reporter,
        )
        for offset in (0.0, _OFFSET)
    ]
    force = [one["normal_force"].to_numpy() for one in runs]
    difference = np.abs(force[0] - force[1]).max(axis=(1, 2))
    way = runs[0]["distance"].to_numpy()
    load = float(force[0][0].mean())
    return xr.DataArray(difference, dims="distance", coords={"distance": way}), load


def as_dataset(found: dict[str, xr.DataArray], load: float, options: StudyOptions) -> xr.Dataset:
    """Return the differences on a common grid of ways."""
    way = np.arange(0.0, min(float(one.distance[-1]) for one in found.values()), 0.01)
    rows = np.array([np.interp(way, one.distance, one) for one in found.values()])
    about = {"units": "N", "long_name": "largest difference of a wheel force"}
    largest = [float(one.max()) for one in found.values()]
    return xr.Dataset(
        {
            "difference": (("variant", "distance"), rows, about),
            "largest_difference": ("variant", largest, about),
        },
        coords={
            "variant": list(found),
            "distance": ("distance", way, {"units": "m", "long_name": "way"}),
        },
        attrs={"study": "slide", "static_wheel_load": load, "command": options.command},
    )


def passes(name: str, largest: float, load: float) -> str:
    """Return the verdict on one way, empty where none is asked for."""
    if name not in LIMITS:
        return ""
    return "pass" if largest < LIMITS[name] * load else "FAIL"


def as_table(found: dict[str, xr.DataArray], load: float) -> Table:
    """Return the largest differences as a table."""
    table = Table(title="Disturbance by the slides", title_justify="left", title_style="")
    for head in ("way of sliding", "largest, N", "% of load", "limit, %", ""):
        table.add_column(head, justify="left" if head == "way of sliding" else "right")
    for name, one in found.items():
        largest = float(one.max())
        limit = f"{100 * LIMITS[name]:g}" if name in LIMITS else ""
        table.add_row(
            name,
            f"{largest:.3g}",
            f"{100 * largest / load:.2g}",
            limit,
            passes(name, largest, load),
        )
    return table


def conclude(found: dict[str, xr.DataArray], load: float) -> str:
    """Return the result as a sentence."""
    verdicts = [passes(name, float(one.max()), load) for name, one in found.items()]
    largest = float(found["default"].max())
    return (
        f"slides change a wheel force by up to {largest:.2g} N, "
        f"{100 * largest / load:.2g} % of the static load; "
        + ("a limit is passed: FAIL" if "FAIL" in verdicts else "all limits are kept: pass")
    )
