"""Fig. 15 of the article: sleeper bay, axle load and damping of the primary suspension."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import BAY, Check
from rail_cosim.studies.article_plots import Draw, curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.table3 import RIGID
from rail_cosim.sweeps import steps

LOAD, PRIMARY = "vehicle.car_body.mass", "vehicle.primary_suspension.vertical_damping"
_QUICK_SPEEDS = [80.0, 120.0, *steps("speed", 150.0, 220.0, 10.0), 260.0, 320.0, 400.0]
_REST = 2 * 2439.0 + 4 * 1881.0  # kg, bogies and wheelsets of Table 2


def _axes() -> dict[str, tuple[list[float], str]]:
    """Return values and words of the three axes; the article prints none of the values."""
    loads = [4e3 * load - _REST for load in (12.0, 14.0, 16.0)]
    return {
        BAY: ([0.55, 0.65, 0.75], "sleeper bay"),
        LOAD: (loads, "axle load"),
        PRIMARY: ([5e3, 10.5e3, 20e3], "primary damping"),
    }


def _label(axis: str, value: float) -> str:
    if axis == BAY:
        return f"bay {value:g} m"
    if axis == LOAD:
        return f"axle load {(value + _REST) / 4e3:g} t"
    return f"{value / 1e3:g} kN·s/m"


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: three sweeps from one reference; the pads are those of Table 3."""
    speeds = _QUICK_SPEEDS if options.quick else steps("speed", 80.0, 400.0, 5.0)
    studies = {
        axis: article.ArticleStudy(
            name="fig15",
            title="Fig. 15: influence of sleeper bay, axle load and primary damping",
            grid={axis: values, "speed": speeds},
            settings=RIGID,
            checks=lambda one: [],
            draw=lambda one, path: None,
        )
        for axis, (values, _) in _axes().items()
    }
    parts = {axis: article.compute(one, options, reporter) for axis, one in studies.items()}
    study = next(iter(studies.values()))
    return article.write_up(
        study, options, join(parts), checks(parts), lambda one, path: draw(parts, path, study.title)
    )


def join(parts: dict[str, xr.Dataset]) -> xr.Dataset:
    """Return the three sweeps in one Dataset; names begin with bay, load or damping."""
    joined = xr.Dataset()
    words = {BAY: "bay", LOAD: "load", PRIMARY: "damping"}
    for axis, part in parts.items():
        names = [n for n in part.data_vars if n not in ("error", "remarks")]
        joined = joined.merge(part[names].rename({n: f"{words[axis]}_{n}" for n in names}))
    return joined


def checks(parts: dict[str, xr.Dataset]) -> list[Check]:
    """Return what the text says of the figure."""
    bays, loads, dampings = parts[BAY], parts[LOAD], parts[PRIMARY]

    def peaks(one: xr.Dataset) -> xr.DataArray:
        return article.largest(one).max("speed")

    def rising_everywhere(one: xr.Dataset) -> float:
        curves_of = article.largest(one).transpose(LOAD, "speed").to_numpy()
        return float(np.all(np.diff(curves_of, axis=0) > 0.0))

    def same_speed(one: xr.Dataset) -> float:
        return float(np.ptp(article.resonance_speed(one).to_numpy()))

    rules = (
        ("longer bay, larger acceleration", lambda one: article.rises(peaks(one)), bays),
        ("larger axle load, larger acceleration at all speeds", rising_everywhere, loads),
        ("more damping, smaller peak", lambda one: article.falls(peaks(one)), dampings),
    )
    found = [article.tendency(name, rule, data) for name, rule, data in rules]
    found.append(
        Check(
            name="shift of the resonance speed with the axle load, km/h",
            stated="none",
            found=article.both(same_speed, loads),
            high=0.0,
            digits=0,
        )
    )
    return found


def draw(parts: dict[str, xr.Dataset], path: Path, title: str) -> None:
    """Draw a row of panels for each of the three."""

    def row(axis: str) -> Draw:
        def panel(axes: Axes, one: xr.Dataset) -> None:
            part = parts[axis].sel(setting=one["setting"])
            curves(axes, article.largest(part), axis, labels=lambda value: _label(axis, value))
            axes.set_ylabel("axle-box acceleration (m/s²)")

        return panel

    settings = parts[BAY][["steady"]]
    panels(settings, [row(axis) for axis in parts], path, title=title, height=2.9)
