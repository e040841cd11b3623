"""Fig. 13 of the article: wheel lift-off at the resonance, and the damping of the pads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import DAMPING, FORCE, STIFFNESS, Check
from rail_cosim.studies.article_plots import curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.sweeps import steps

_LOW, _NOMINAL, _RESONANCE = 10e3, 52e3, 180.0
_AWAY = 300.0  # km/h
_BAY, _PITCH = 0.629, 8 * 0.629
_SHOWN = 2.6  # m
PADS = "pad_damping"
_MAX, _MIN, _OFF = f"{FORCE}_max", f"{FORCE}_min", f"{FORCE}_lift_off_time"


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: a sweep over damping and speed, and records of two runs at the resonance."""
    title = "Fig. 13: pads of 200 MN/m; wheel forces and axle-box acceleration"
    common: dict[str, Any] = {"checks": checks, "draw": draw, "settings": {STIFFNESS: 200e6}}
    sweep = article.ArticleStudy(
        name="fig13",
        title=title,
        grid={
            DAMPING: [_LOW, _NOMINAL] if options.quick else [_LOW, 30e3, _NOMINAL, 70e3, 90e3],
            "speed": steps("speed", 80.0, 400.0, 20.0 if options.quick else 5.0),
        },
        **common,
    )
    records = article.ArticleStudy(
        name="fig13",
        title=title,
        grid={DAMPING: [_LOW, _NOMINAL], "speed": [_RESONANCE]},
        history=(FORCE, "distance"),
        **common,
    )
    data = article.compute(sweep, options, reporter)
    data = join(data, article.compute(records, options, reporter))
    return article.write_up(sweep, options, data, checks(data), draw)


def join(data: xr.Dataset, records: xr.Dataset) -> xr.Dataset:
    """Return the sweep with the records of the runs at the resonance, over ``pad_damping``."""
    histories = [name for name in records if str(name).endswith("_history")]
    at = records[histories].sel(speed=_RESONANCE, drop=True)
    return data.merge(at.rename({DAMPING: PADS}))


def last_slab(data: xr.Dataset, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Return way (m, from 0) and force (N) of the leading left wheel over the last slab length."""
    one = data.sel({PADS: damping})
    way = one["distance_history"].to_numpy()
    force = one[f"{FORCE}_history"].isel(wheelset=0, side=0).to_numpy()
    there = np.isfinite(force) & (way > np.nanmax(way) - _PITCH * (1.0 - 1e-9))
    return way[there] - way[there][0], force[there]


def separations(data: xr.Dataset) -> float:
    """Return how often the leading left wheel lifts off in a bay, with the lowest damping."""
    _, force = last_slab(data, _LOW)
    off = force <= 0.0
    begins = off & ~np.roll(off, 1)  # the motion repeats: the last record is before the first
    return float(begins.sum()) * _BAY / _PITCH


def sine_share(data: xr.Dataset) -> float:
    """Return how much of the force's variance, at 52 kN.s/m, is at the sleeper passing, in %."""
    _, force = last_slab(data, _NOMINAL)
    power = np.abs(np.fft.rfft(force - force.mean())) ** 2
    return float(100.0 * power[round(_PITCH / _BAY)] / power.sum())


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

    def lowered(one: xr.Dataset) -> float:
        return article.falls(article.largest(one).sel(speed=_RESONANCE).sortby(DAMPING))

    def elsewhere(one: xr.Dataset) -> float:
        box = article.largest(one).sel({DAMPING: [_LOW, _NOMINAL]})
        low, nominal = box.sel(speed=_AWAY).to_numpy()
        return 100.0 * float(low - nominal) / float(box.sel({DAMPING: _LOW}).max())

    return [
        Check(
            name="largest force at 180 km/h, 10 kN.s/m, kN",
            stated="160 (here: 10 %)",
            found={s: v / 1e3 for s, v in at(force, _LOW).items()},
            low=144.0,
            high=176.0,
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
            name="lift-offs in a bay at 180 km/h, 10 kN.s/m",
            stated="1",
            found=article.both(separations, data),
            low=1.0 - 1e-9,
            high=1.0 + 1e-9,
        ),
        Check(
            name="sinusoidal force at 180 km/h, 52 kN.s/m: share of sleeper passing, %",
            stated="sinusoidal (here: 95)",
            found=article.both(sine_share, data),
            low=95.0,
        ),
        article.tendency("damping lowers the acceleration at 180 km/h", lowered, data),
        Check(
            name="acceleration away from it, 300 km/h: 10 less 52 kN.s/m, share of the peak, %",
            stated="negligible (here: 10)",
            found=article.both(elsewhere, data),
            low=-10.0,
            high=10.0,
        ),
    ]


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw extreme forces and histories at two dampings, and accelerations at all."""

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

    def histories(axes: Axes, one: xr.Dataset) -> None:
        for damping, colour in ((_LOW, "#D55E00"), (_NOMINAL, "#0072B2")):
            way, force = last_slab(one, damping)
            shown = way <= _SHOWN
            label = f"{damping / 1e3:g} kN·s/m at 180 km/h"
            axes.plot(way[shown], force[shown] / 1e3, color=colour, lw=1.2, label=label)
        axes.set_xlabel("distance travelled (m)")
        axes.set_ylabel("wheel force (kN)")

    def accelerations(axes: Axes, one: xr.Dataset) -> None:
        curves(axes, article.largest(one), DAMPING, labels=lambda c: f"{c / 1e3:g} kN·s/m")
        axes.set_ylabel("largest axle-box acceleration (m/s²)")

    panels(data, [forces, histories, accelerations], path, title=data.attrs["title"])
