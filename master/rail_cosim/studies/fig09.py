"""Fig. 9 of the article: axle-box acceleration in winter (200 km/h) and summer (300 km/h)."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article, passing
from rail_cosim.studies.article import BOX, STIFFNESS, Check
from rail_cosim.studies.article_plots import panels
from rail_cosim.studies.base import StudyOptions, StudyResult

_SEASONS = {"winter": (200.0, 140e6, 88.0), "summer": (300.0, 40e6, 132.0)}


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: measured in the article, computed here with both seasons' pads."""
    study = article.ArticleStudy(
        name="fig09",
        title="Fig. 9: axle box at 200 km/h, 140 MN/m and at 300 km/h, 40 MN/m "
        "(measured in the article)",
        grid={STIFFNESS: [40e6, 140e6], "speed": [200.0, 300.0]},
        keep={BOX: ("peak",)},
        history=(BOX,),
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def _season(data: xr.Dataset, name: str) -> xr.Dataset:
    speed, stiffness, _ = _SEASONS[name]
    return data.sel({"speed": speed, STIFFNESS: stiffness})


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""
    found = [
        passing.frequency_check(
            f"dominant frequency, {name}, Hz", _season(data, name), BOX, speed, stated
        )
        for name, (speed, _, stated) in _SEASONS.items()
    ]

    def ratio(one: xr.Dataset) -> float:
        winter, summer = (
            passing.at_sleepers(_season(one, name), BOX, values[0])
            for name, values in _SEASONS.items()
        )
        return winter / summer

    found.append(
        Check(
            name="amplitude at sleeper passing, winter over summer",
            stated="much larger (here: 2)",
            found=article.both(ratio, data),
            low=2.0,
        )
    )
    return found


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw the spectra of both seasons."""

    def spectra(axes: Axes, one: xr.Dataset) -> None:
        for name, (speed, stiffness, _) in _SEASONS.items():
            label = {BOX: f"{name}: {speed:g} km/h, {stiffness / 1e6:g} MN/m"}
            passing.draw_spectrum(axes, _season(one, name), speed, label)

    panels(data, [spectra], path, title=data.attrs["title"], height=3.8)
