"""Fig. 12 of the article: axle-box acceleration at 200 km/h with the pads of the winter."""

from __future__ import annotations

import xarray as xr

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article, passing
from rail_cosim.studies.article import BOX, STIFFNESS, Check
from rail_cosim.studies.base import StudyOptions, StudyResult

_SPEED = 200.0


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study."""
    study = article.ArticleStudy(
        name="fig12",
        title="Fig. 12: axle-box acceleration at 200 km/h, pads of 140 MN/m",
        grid={"speed": [_SPEED]},
        settings={STIFFNESS: 140e6},
        keep={BOX: ("peak",)},
        history=passing.HISTORY,
        checks=checks,
        draw=passing.picture(_SPEED, {BOX: "axle box"}),
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    at = data.sel(speed=_SPEED)
    return [passing.frequency_check("dominant frequency, Hz", at, BOX, _SPEED, 88.0)]
