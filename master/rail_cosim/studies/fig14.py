"""Fig. 14 of the article: the unsprung mass."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import FORCE, Check
from rail_cosim.studies.article_plots import curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.table3 import RIGID
from rail_cosim.sweeps import steps

MASS, CAR_BODY = "vehicle.wheelset.mass", "vehicle.car_body.mass"
_CAR_BODY, _WHEELSET = 44039.0, 1881.0  # kg, Table 2


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study; the stiffness of the pads is not printed, here that of Fig. 13."""
    masses = [500.0, 1500.0, 2500.0] if options.quick else steps(MASS, 500.0, 2500.0, 500.0)
    study = article.ArticleStudy(
        name="fig14",
        title="Fig. 14: influence of the unsprung mass; pads of 200 MN/m, 69.2 kN on each wheel",
        grid={"speed": steps("speed", 80.0, 400.0, 40.0 if options.quick else 5.0)},
        settings=RIGID,
        checks=checks,
        draw=draw,
    )
    parts = [article.compute(_with_mass(study, float(mass)), options, reporter) for mass in masses]
    about = {"units": "kg", "long_name": "mass of a wheelset; the car body takes up the rest"}
    axis = xr.Variable(MASS, [float(mass) for mass in masses], about)
    data = xr.concat(parts, dim=axis)
    return article.write_up(study, options, data, checks(data), draw)


def _with_mass(study: article.ArticleStudy, mass: float) -> article.ArticleStudy:
    """Return the study with wheelsets of ``mass`` (kg) under an unchanged static wheel load."""
    settings = {**study.settings, MASS: mass, CAR_BODY: _CAR_BODY + 4.0 * (_WHEELSET - mass)}
    return dataclasses.replace(study, settings=settings)


def dynamic_factor(data: xr.Dataset) -> xr.DataArray:
    """Return the largest excess of the wheel force over its mean, as a share of it."""
    mean = data[f"{FORCE}_mean"]
    return ((data[f"{FORCE}_max"] - mean) / mean).max(["wheelset", "side"])


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""

    def factors(one: xr.Dataset) -> xr.DataArray:
        return dynamic_factor(one).max("speed")

    def speeds(one: xr.Dataset) -> xr.DataArray:
        return dynamic_factor(one).idxmax("speed")

    def peaks(one: xr.Dataset) -> xr.DataArray:
        return article.largest(one).max("speed")

    return [
        article.tendency(name, rule, data)
        for name, rule in (
            ("dynamic factor grows with the mass", lambda one: article.rises(factors(one))),
            ("resonance speed falls with the mass", lambda one: article.falls(speeds(one))),
            ("largest acceleration falls with the mass", lambda one: article.falls(peaks(one))),
        )
    ]


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw dynamic factor and acceleration over speed."""

    def words(mass: float) -> str:
        return f"{mass / 1e3:g} t"

    def factor(axes: Axes, one: xr.Dataset) -> None:
        curves(axes, dynamic_factor(one), MASS, labels=words)
        axes.set_ylabel("dynamic factor")

    def acceleration(axes: Axes, one: xr.Dataset) -> None:
        curves(axes, article.largest(one), MASS, labels=words)
        axes.set_ylabel("largest axle-box acceleration (m/s²)")

    panels(data, [factor, acceleration], path, title=data.attrs["title"])
