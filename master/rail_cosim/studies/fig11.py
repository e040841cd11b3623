"""Fig. 11 of the article: axle-box acceleration over speed for pads of 40 to 140 MN/m."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import GRAVITY, STIFFNESS, Check, p2_frequency
from rail_cosim.studies.article_plots import curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.sweeps import steps

_BAY = 0.629


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study."""
    stiffnesses = [40e6, 100e6, 140e6] if options.quick else steps(STIFFNESS, 40e6, 140e6, 20e6)
    study = article.ArticleStudy(
        name="fig11",
        title="Fig. 11: largest axle-box acceleration; ticks at the resonance speeds of eq. (16)",
        grid={
            STIFFNESS: stiffnesses,
            "speed": steps("speed", 80.0, 400.0, 20.0 if options.quick else 5.0),
        },
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def resonance(stiffness: float) -> float:
    """Return the resonance speed of eq. (16) in km/h."""
    return 3.6 * p2_frequency(stiffness, _BAY) * _BAY


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    speeds = article.resonance_speed(data)
    highest = article.largest(data).max("speed")
    step = float(data["speed"][1] - data["speed"][0])
    found: list[Check] = []
    for stiffness, stated in ((40e6, 116.4), (140e6, 188.2)):
        found.append(
            Check(
                name=f"resonance speed at {stiffness / 1e6:g} MN/m, km/h",
                stated=f"{stated} by its formula, good agreement (here: 5 % and the grid)",
                found=article.both(lambda d, k=stiffness: _at(speeds, d, k), data),
                low=0.95 * stated - 0.5 * step,
                high=1.05 * stated + 0.5 * step,
                digits=0,
            )
        )
    found.append(
        Check(
            name="largest acceleration at 140 MN/m, g",
            stated="about 2 (here: 1.7 to 2.3)",
            found=article.both(lambda d: _at(highest, d, 140e6) / GRAVITY, data),
            low=1.7,
            high=2.3,
            digits=2,
        )
    )
    for name, values in (("resonance speed", speeds), ("largest acceleration", highest)):
        found.append(
            article.tendency(
                f"{name} grows with the stiffness",
                lambda d, v=values: article.rises(_of(v, d)),
                data,
            )
        )
    return found


def _of(values: xr.DataArray, data: xr.Dataset) -> xr.DataArray:
    return values.sel(setting=data["setting"])


def _at(values: xr.DataArray, data: xr.Dataset, stiffness: float) -> float:
    return float(_of(values, data).sel({STIFFNESS: stiffness}))


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw the accelerations over speed."""

    def panel(axes: Axes, one: xr.Dataset) -> None:
        curves(
            axes,
            article.largest(one),
            STIFFNESS,
            labels=lambda k: f"{k / 1e6:g} MN/m",
            marks=resonance,
        )
        axes.set_ylabel("largest axle-box acceleration (m/s²)")

    panels(data, [panel], path, title=data.attrs["title"], height=4.2)
