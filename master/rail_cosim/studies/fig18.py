"""Fig. 18 of the article: slab passing over speed and stiffness of the CAM layer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import BOX, BOX_PEAK, FORCE, Check
from rail_cosim.studies.article_plots import Draw, begin_at, curves, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.zx_line import BASES, BASIS, CAM, ZX
from rail_cosim.sweeps import steps

_SLABS = f"{BOX}_slab_peak"
_ALL = [300e6, 600e6, 1000e6, 3000e6, 5000e6]


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study; the article prints neither speeds nor stiffnesses of its curves."""
    study = article.ArticleStudy(
        name="fig18",
        title="Fig. 18: axle-box acceleration on the ZX line over speed and CAM layer",
        grid={
            BASIS: list(BASES),
            CAM: [_ALL[0], _ALL[2], _ALL[3]] if options.quick else _ALL,
            "speed": steps("speed", 200.0, 400.0, 50.0 if options.quick else 20.0),
        },
        settings=ZX,
        keep={FORCE: ("min", "slab_peak"), BOX: ("peak", "slab_peak")},
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure, for both readings of the stiffness."""

    def softer_is_larger(one: xr.Dataset, name: str) -> float:
        values = article.largest(one, name).transpose(CAM, "speed").to_numpy()
        return float(np.all(np.diff(values, axis=0) < 0.0))

    def faster_is_larger(one: xr.Dataset, name: str) -> float:
        """Return 1 if the highest speed gives the largest value for every stiffness."""
        values = article.largest(one, name).transpose(CAM, "speed").to_numpy()
        return float(np.all(values.argmax(axis=1) == values.shape[1] - 1))

    found: list[Check] = []
    for basis, words in BASES.items():
        here = data.sel({BASIS: basis})
        for name, what in ((_SLABS, "slab part"), (BOX_PEAK, "whole")):
            for rule, text in (
                (softer_is_larger, "softer layer, larger acceleration at all speeds"),
                (faster_is_larger, "largest at the highest speed"),
            ):
                found.append(
                    Check(
                        name=f"{words}, {what}: {text} (1: yes)",
                        stated="yes",
                        found=article.both(lambda d, r=rule, n=name: r(d, n), here),
                        low=1.0,
                        digits=0,
                    )
                )
    return found


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw the slab part and the whole acceleration over speed, for both readings."""

    def row(basis: str, name: str, words: str) -> Draw:
        def panel(axes: Axes, one: xr.Dataset) -> None:
            values = article.largest(one.sel({BASIS: basis}), name)
            label = BASES[basis]
            curves(axes, values, CAM, labels=lambda k: f"{k / 1e6:g} MN/m {label}")
            begin_at(axes, 0.0)
            axes.set_ylabel(words)

        return panel

    rows = [
        row(basis, name, words)
        for basis in BASES
        for name, words in (
            (_SLABS, "slab part (m/s²)"),
            (BOX_PEAK, "largest acceleration (m/s²)"),
        )
    ]
    panels(data, rows, path, title=data.attrs["title"], height=2.6)
