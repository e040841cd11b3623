"""Fig. 6: the vehicle passes a rail joint at the instant of a slide.

Sliding window and ring against a moving mass in a window three times as long, whose ends are
not felt in this time.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.options import RunOptions
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.runner import execute
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.slide import LEVEL
from rail_cosim.studies.slide_plots import plot_joint

_PITCH, _WHEELBASE = 5.032, 20.3  # m; HD line, article's vehicle
_SLABS, _OFFSET = 16, -3.0  # window.slab_count and window.vehicle_offset by default
MODELS = {
    "moving_mass": ("moving_mass", 51),
    "sliding": ("sliding", _SLABS),
    "sliding_13_slabs": ("sliding", 13),
    "sliding_20_slabs": ("sliding", 20),
    "ring": ("cyclic", _SLABS),
}
"""Method and slabs of each model, all with the same shortest wave; the first is the reference."""

SHORTER = "sliding_13_slabs"
"""The article's window: shown for comparison, and not judged."""

PEAK_LIMIT, HISTORY_LIMIT = 1e-4, 5e-4
"""Relative difference of the peaks; largest difference at any time, in static loads."""


def joint_position(nearest: float) -> float:
    """Return where the leading wheelset is when the default window slides, m."""
    first = _WHEELBASE + 0.5 * ((_SLABS - 1) * _PITCH - _WHEELBASE) + _OFFSET
    return first + float(np.ceil((nearest - first) / _PITCH)) * _PITCH


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "fig06.nc", options.out / "fig06.png"
    check_netcdf(data)
    place, distance = joint_position(12.0), 20.0 if options.quick else 35.0
    forces, way = {}, np.zeros(0)
    for name, (method, slabs) in MODELS.items():
        reporter.stage(name.replace("_", " "))
        settings = [
            LEVEL,
            "track.irregularity.rail_joint.side=both",
            f"track.irregularity.rail_joint.position={place}",
            f"track.window.slab_count={slabs}",
            f"track.window.method={method}",
            *options.settings,
        ]
        found = execute(
            RunOptions(speed=300.0, distance=distance, settings=settings, command=options.command),
            reporter,
        )
        forces[name], way = found["normal_force"].to_numpy(), found["distance"].to_numpy()
    dataset = as_dataset(forces, way, place, options)
    write_netcdf(dataset, data)
    plot_joint(dataset, picture)
    table, conclusion = report(dataset)
    return StudyResult(table=table, conclusion=conclusion, files=[data, picture])


def as_dataset(
    forces: dict[str, np.ndarray], way: np.ndarray, place: float, options: StudyOptions
) -> xr.Dataset:
    """Return forces and differences over the way, by model."""
    reference = forces["moving_mass"]
    about = {"units": "N", "long_name": "normal force of the leading left wheel"}
    apart = {"units": "N", "long_name": "largest difference of any wheel from the moving mass"}
    peak = {"units": "N", "long_name": "largest normal force of any wheel"}
    values = list(forces.values())
    return xr.Dataset(
        {
            "leading_force": (("model", "distance"), [f[:, 0, 0] for f in values], about),
            "difference": (
                ("model", "distance"),
                [np.abs(f - reference).max(axis=(1, 2)) for f in values],
                apart,
            ),
            "peak": ("model", [f.max() for f in values], peak),
        },
        coords={
            "model": list(forces),
            "distance": ("distance", way, {"units": "m", "long_name": "distance travelled"}),
        },
        attrs={
            "study": "fig06",
            "joint_position": place,
            "static_wheel_load": float(reference[0].mean()),
            "command": options.command,
        },
    )


def report(dataset: xr.Dataset) -> tuple[Table, str]:
    """Return the table and the conclusion."""
    table = Table(title="Rail joint at a window shift", title_justify="left", title_style="")
    for head in ("model", "peak, kN", "peak, % off", "history, % of load", ""):
        table.add_column(head, justify="left" if head == "model" else "right")
    load = dataset.attrs["static_wheel_load"]
    peaks, first = dataset["peak"], float(dataset["peak"][0])
    failed = []
    for name in dataset["model"].to_numpy():
        off = float(peaks.sel(model=name)) / first - 1.0
        history = float(dataset["difference"].sel(model=name).max()) / load
        good = abs(off) < PEAK_LIMIT and history < HISTORY_LIMIT
        judged = name not in (dataset["model"][0], SHORTER)
        failed += [str(name)] if judged and not good else []
        table.add_row(
            str(name).replace("_", " "),
            f"{float(peaks.sel(model=name)) / 1e3:.2f}",
            f"{100 * off:.4f}",
            f"{100 * history:.3f}",
            ("pass" if good else "FAIL") if judged else "",
        )
    limits = f"{100 * PEAK_LIMIT:g} % of the peak and {100 * HISTORY_LIMIT:g} % of the load"
    verdict = f"beyond it: {', '.join(failed)}" if failed else "all models"
    return table, f"limits {limits}: {verdict}"
