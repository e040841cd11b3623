"""Fig. 12 of the article: axle-box acceleration at 200 km/h with the pads of the winter."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.runner import Reporter
from rail_cosim.studies import article, passing
from rail_cosim.studies.article import BOX, STIFFNESS, Check
from rail_cosim.studies.article_plots import panels
from rail_cosim.studies.base import StudyOptions, StudyResult

_SPEED, _STATED = 200.0, 88.0
_NEAR = 1.0  # Hz; the article gives a whole number


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study."""
    study = article.ArticleStudy(
        name="fig12",
        title="Fig. 12: axle-box acceleration at 200 km/h, pads of 140 MN/m",
        grid={"speed": [_SPEED]},
        settings={STIFFNESS: 140e6},
        keep={BOX: ("peak",)},
        history=(BOX,),
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    at = data.sel(speed=_SPEED)
    return [
        Check(
            name="dominant frequency, Hz",
            stated="88",
            found=article.both(lambda one: passing.dominant(one, BOX, _SPEED), at),
            low=_STATED - _NEAR,
            high=_STATED + _NEAR,
        )
    ]


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw time history and spectrum."""
    at = data.sel(speed=_SPEED)
    names = {BOX: "axle box"}

    def time(axes: Axes, one: xr.Dataset) -> None:
        passing.draw_time(axes, one, _SPEED, names)

    def spectrum(axes: Axes, one: xr.Dataset) -> None:
        passing.draw_spectrum(axes, one, _SPEED, names)

    panels(at, [time, spectrum], path, title=data.attrs["title"])
