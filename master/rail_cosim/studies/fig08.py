"""Fig. 8 of the article: accelerations from axle box to car body at 200 km/h."""

from __future__ import annotations

import xarray as xr

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article, passing
from rail_cosim.studies.article import BOX, STIFFNESS, Check
from rail_cosim.studies.base import StudyOptions, StudyResult

_SPEED = 200.0
_NAMES = {BOX: "axle box", passing.BOGIE: "bogie", passing.BODY: "car body"}


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: measured in the article, computed here with the pads of the winter."""
    study = article.ArticleStudy(
        name="fig08",
        title="Fig. 8: accelerations at 200 km/h, pads of 140 MN/m (measured in the article)",
        grid={"speed": [_SPEED]},
        settings={STIFFNESS: 140e6},
        keep={BOX: ("peak",)},
        history=passing.HISTORY,
        checks=checks,
        draw=passing.picture(_SPEED, _NAMES),
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    at = data.sel(speed=_SPEED)
    found = [
        passing.frequency_check(f"dominant frequency, {word}, Hz", at, name, _SPEED, 88.0)
        for name, word in _NAMES.items()
        if name != passing.BODY
    ]
    found.append(
        Check(
            name="car body: amplitude at sleeper passing, m/s2",
            stated="seen in the spectrum",
            found=article.both(lambda one: passing.at_sleepers(one, passing.BODY, _SPEED), at),
            low=1e-4,
            digits=5,
        )
    )
    found.append(
        Check(
            name="largest acceleration of the axle box, g",
            stated="about 4, measured (here: 3 to 5)",
            found=article.both(lambda one: float(article.largest(one)) / article.GRAVITY, at),
            low=3.0,
            high=5.0,
            digits=2,
        )
    )
    return found
