"""Fig. 13 of the article: wheel lift-off at the resonance, and the damping of the pads."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.runner import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import DAMPING, FORCE, STIFFNESS, Check
from rail_cosim.studies.article_plots import curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.sweeps import steps

_LOW, _NOMINAL, _RESONANCE = 10e3, 52e3, 180.0
_MAX, _MIN, _OFF = f"{FORCE}_max", f"{FORCE}_min", f"{FORCE}_lift_off_time"


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study."""
    study = article.ArticleStudy(
        name="fig13",
        title="Fig. 13: pads of 200 MN/m; extreme wheel forces and axle-box acceleration",
        grid={
            DAMPING: [_LOW, _NOMINAL] if options.quick else [_LOW, 30e3, _NOMINAL, 70e3, 90e3],
            "speed": steps("speed", 80.0, 400.0, 20.0 if options.quick else 5.0),
        },
        settings={STIFFNESS: 200e6},
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    force = article.largest(data, _MAX)
    time_off = article.largest(data, _OFF)
    step = float(data["speed"][1] - data["speed"][0])

    def at(values: xr.DataArray, damping: float):
        def value(one: xr.Dataset) -> float:
            there = {"setting": one["setting"], DAMPING: damping, "speed": _RESONANCE}
            return float(values.sel(there))

        return article.both(value, data)

    def peak_speed(one: xr.Dataset) -> float:
        return float(force.sel(setting=one["setting"]).sel({DAMPING: _LOW}).idxmax("speed"))

    lowered = article.both(
        lambda one: article.falls(article.largest(one).sel(speed=_RESONANCE).sortby(DAMPING)),
        data,
    )
    return [
        Check(
            name="largest force at 180 km/h, 10 kN.s/m, kN",
            stated="160 (here: 5 %)",
            found={s: v / 1e3 for s, v in at(force, _LOW).items()},
            low=152.0,
            high=168.0,
        ),
        Check(
            name="speed of the largest force, 10 kN.s/m, km/h",
            stated="180 (here: and the grid)",
            found=article.both(peak_speed, data),
            low=_RESONANCE - 0.5 * step,
            high=_RESONANCE + 0.5 * step,
            digits=0,
        ),
        Check(
            name="lift-off at 180 km/h, 10 kN.s/m, ms per slab",
            stated="yes",
            found={s: 1e3 * v for s, v in at(time_off, _LOW).items()},
            low=1e-3,
        ),
        Check(
            name="lift-off at 180 km/h, 52 kN.s/m, ms per slab",
            stated="none",
            found={s: 1e3 * v for s, v in at(time_off, _NOMINAL).items()},
            high=0.0,
        ),
        Check(
            name="damping lowers the acceleration at 180 km/h (1: yes)",
            stated="yes",
            found=lowered,
            low=1.0,
            digits=0,
        ),
    ]


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw extreme forces at the lowest damping, and accelerations at all."""

    def forces(axes: Axes, one: xr.Dataset) -> None:
        for damping, style in ((_LOW, "-"), (_NOMINAL, "--")):
            at = one.sel({DAMPING: damping})
            for values, colour, word in (
                (article.largest(at, _MAX), "#D55E00", "largest"),
                (at[_MIN].min(["wheelset", "side"]), "#0072B2", "smallest"),
            ):
                label = f"{word}, {damping / 1e3:g} kN·s/m"
                axes.plot(one["speed"], values / 1e3, style, color=colour, lw=1.2, label=label)
        axes.set_xlabel("speed (km/h)")
        axes.set_ylabel("wheel force (kN)")

    def accelerations(axes: Axes, one: xr.Dataset) -> None:
        curves(axes, article.largest(one), DAMPING, labels=lambda c: f"{c / 1e3:g} kN·s/m")
        axes.set_ylabel("largest axle-box acceleration (m/s²)")

    panels(data, [forces, accelerations], path, title=data.attrs["title"])
