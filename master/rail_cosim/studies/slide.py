"""Are slides felt? Two runs that slide at different places, for several ways of sliding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.errors import RunError, RunInterrupted
from rail_cosim.options import RunOptions
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.runner import execute
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.slide_plots import plot_slide

LEVEL = "track.contact.model=vertical"
_HARD = ("track.fastener.vertical_stiffness=200e6", "track.fastener.vertical_damping=10e3")
_HARD_SPEED = 180.0
BEHIND = -3.0  # m; default of window.vehicle_offset


class Variant(NamedTuple):
    """One way of sliding: parameters of the track, speed in km/h and place of the vehicle in m."""

    settings: tuple[str, ...] = ()
    speed: float = 300.0
    offset: float = BEHIND


def _with(*texts: str, offset: float = BEHIND) -> Variant:
    """Return a way with these parameters of the track, at 300 km/h."""
    return Variant(tuple(f"track.{text}" for text in texts), offset=offset)


def _hard(*texts: str) -> Variant:
    """Return a way with these parameters on hard, lightly damped pads, where wheels lift off."""
    return Variant((*_HARD, *(f"track.{text}" for text in texts)), _HARD_SPEED)


_ARTICLE = ("rail.mode_count=200", "window.slab_count=13", "window.end_damping=0")
_PLAIN = (*_ARTICLE, "rail.residual_compliance=false", "slab.residual_compliance=false")

VARIANTS: dict[str, Variant] = {
    "default": Variant(),
    "article: 200 plain modes, M = 250": _with(
        *_PLAIN, "slab.mode_count=24", "window.sample_count=250"
    ),
    "same, M = 1.05 N": _with(*_PLAIN, "window.sample_count=210"),
    "same, M = 4 N": _with(*_PLAIN, "window.sample_count=800"),
    "same, projection": _with(*_PLAIN, "window.slide_solver=projection"),
    "same, constrained": _with(*_PLAIN, "window.slide_solver=constrained"),
    "same, rear taper 10 m": _with(*_PLAIN, "window.rear_taper=10"),
    "same, triangular": _with(*_PLAIN, "window.slide_solver=triangular"),
    "400 plain modes": _with(*_PLAIN[1:], "rail.mode_count=400"),
    "600 plain modes": _with(*_PLAIN[1:], "rail.mode_count=600"),
    "200 modes, residual, sharp end": _with(*_ARTICLE, "rail.passage_width=0"),
    "200 modes, residual, passage 0.5": _with(*_ARTICLE, "rail.passage_width=0.5"),
    "sharp end": _with("rail.passage_width=0"),
    "passage 0.05": _with("rail.passage_width=0.05"),
    "passage 0.5": _with("rail.passage_width=0.5"),
    "M = 1.05 N": _with("window.sample_count=331"),
    "M = 4 N": _with("window.sample_count=1260"),
    "projection": _with("window.slide_solver=projection"),
    "constrained": _with("window.slide_solver=constrained"),
    "rear taper 5 m": _with("window.rear_taper=5"),
    "triangular": _with("window.slide_solver=triangular"),
    "two slabs at once": _with("window.slide_pitches=2"),
    "three slabs at once": _with("window.slide_pitches=3"),
    "9 slabs": _with("window.slab_count=9", offset=0.0),
    "11 slabs": _with("window.slab_count=11", offset=0.0),
    "13 slabs": _with("window.slab_count=13"),
    "20 slabs": _with("window.slab_count=20"),
    "vehicle in the middle": _with(offset=0.0),
    "vehicle 10 m behind the middle": _with(offset=-10.0),
    "vehicle 10 m before the middle": _with(offset=10.0),
    "no end damping": _with("window.end_damping=0"),
    "ring": _with("window.method=cyclic"),
    "hard pads, 180 km/h": _hard(),
    "hard pads, no end damping": _hard("window.end_damping=0"),
    "hard pads, 13 slabs": _hard("window.slab_count=13"),
    "hard pads, 20 slabs": _hard("window.slab_count=20"),
    "hard pads, constrained": _hard("window.slide_solver=constrained"),
    "hard pads, rear taper 5 m": _hard("window.rear_taper=5"),
    "hard pads, two slabs at once": _hard("window.slide_pitches=2"),
    "hard pads, ring": _hard("window.method=cyclic"),
}
"""All ways; the HD line but for what is said."""

LIMITS = {"default": 1e-4, "hard pads, 180 km/h": 1e-3}
"""What the largest difference may be, in static wheel loads."""

_OFFSET = 2.5  # m; half a slab pitch, so that the two runs slide at different places
_DISTANCE, _QUICK_DISTANCE = 40.0, 12.0  # m
_QUICK = ("default", "article: 200 plain modes, M = 250", "hard pads, 180 km/h")


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
    """Return the largest difference of any wheel's force over the way, N, and the static load.

    Infinite from where one of the two runs ends with an error on.
    """
    variant = VARIANTS[name]
    distance = _QUICK_DISTANCE if options.quick else _DISTANCE
    runs = []
    for offset in (0.0, _OFFSET):
        asked = RunOptions(
            speed=variant.speed,
            distance=distance,
            settings=[
                LEVEL,
                *variant.settings,
                *options.settings,
                f"track.window.vehicle_offset={variant.offset + offset}",
            ],
            command=options.command,
        )
        try:
            runs.append(execute(asked, reporter))
        except RunError as error:
            if error.dataset is None or isinstance(error, RunInterrupted):
                raise
            runs.append(error.dataset)
    force = [one["normal_force"].to_numpy() for one in runs]
    common = min(len(one) for one in force)
    difference = np.abs(force[0][:common] - force[1][:common]).max(axis=(1, 2))
    way = runs[0]["distance"].to_numpy()[:common]
    load = float(force[0][0].mean())
    if way[-1] < distance - _OFFSET:
        way, difference = np.append(way, distance), np.append(difference, np.inf)
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
            "distance": ("distance", way, {"units": "m", "long_name": "distance travelled"}),
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
    table = Table(title="Disturbance by the window shifts", title_justify="left", title_style="")
    for head in ("window shift", "largest, N", "% of load", "limit, %", ""):
        table.add_column(head, justify="left" if head == "window shift" else "right")
    for name, one in found.items():
        largest = float(one.max())
        limit = f"{100 * LIMITS[name]:g}" if name in LIMITS else ""
        table.add_row(
            name,
            f"{largest:.3g}" if largest < load else "diverges",
            f"{100 * largest / load:.2g}" if largest < load else "",
            limit,
            passes(name, largest, load),
        )
    return table


def conclude(found: dict[str, xr.DataArray], load: float) -> str:
    """Return the result as a sentence."""
    verdicts = [passes(name, float(one.max()), load) for name, one in found.items()]
    largest = float(found["default"].max())
    return (
        f"window shifts change a wheel force by up to {largest:.2g} N, "
        f"{100 * largest / load:.2g} % of the static load; "
        + ("a limit is passed: FAIL" if "FAIL" in verdicts else "all limits are kept: pass")
    )
