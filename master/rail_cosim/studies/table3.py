"""Table 3 of the article: resonance speed and frequency over the sleeper bay."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import BAY, Check
from rail_cosim.studies.article_plots import curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.sweeps import steps

STATED = {
    0.55: (170, 85.9),
    0.575: (175, 84.5),
    0.6: (180, 83.3),
    0.625: (185, 82.2),
    0.65: (190, 81.2),
    0.675: (195, 80.2),
    0.7: (200, 79.4),
    0.725: (205, 78.5),
    0.75: (210, 77.8),
}
"""Table 3: resonance speed in km/h and frequency in Hz by bay in m."""

RIGID = {article.STIFFNESS: 200e6, article.DAMPING: 52e3}
"""Pads of Table 3 and of Figs. 13 to 15; the article names their stiffness at Fig. 13 only."""


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study; slabs of eight bays less the gap."""
    bays = list(STATED)[::4] if options.quick else list(STATED)
    study = article.ArticleStudy(
        name="table3",
        title="Table 3: speed of the largest axle-box acceleration, over the sleeper bay",
        grid={BAY: bays, "speed": steps("speed", 150.0, 230.0, 5.0)},
        settings=RIGID,
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return checks of speed and frequency for each bay, and of their tendencies."""
    speeds = article.resonance_speed(data)
    found: list[Check] = []
    for bay in data[BAY].to_numpy():
        speed, frequency = STATED[float(bay)]
        ours = article.both(
            lambda d, bay=bay: speeds.sel({"setting": d["setting"], BAY: bay}), data
        )
        found.append(
            Check(
                name=f"bay {bay:g} m: resonance speed, km/h",
                stated=f"{speed}",
                found=ours,
                low=speed,
                high=speed,
                digits=0,
            )
        )
        hertz = {setting: v / 3.6 / float(bay) for setting, v in ours.items()}
        found.append(
            Check(
                name=f"bay {bay:g} m: resonance frequency, Hz",
                stated=f"{frequency}",
                found=hertz,
                low=frequency - 0.1,
                high=frequency + 0.1,
            )
        )

    def frequencies(one: xr.Dataset) -> xr.DataArray:
        return article.resonance_speed(one) / one[BAY]

    found += [
        article.tendency(f"longer bay, {words}", rule, data)
        for words, rule in (
            ("higher resonance speed", lambda one: article.grows(article.resonance_speed(one))),
            ("lower resonance frequency", lambda one: article.falls(frequencies(one))),
        )
    ]
    return found


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw the accelerations over speed, the largest marked."""

    def panel(axes: Axes, one: xr.Dataset) -> None:
        values = article.largest(one)
        speeds = article.resonance_speed(one)
        curves(
            axes,
            values,
            BAY,
            labels=lambda bay: f"bay {bay:g} m",
            marks=lambda bay: float(speeds.sel({BAY: bay})),
        )
        axes.set_ylabel("largest axle-box acceleration (m/s²)")

    panels(data, [panel], path, title=data.attrs["title"], height=4.2)
