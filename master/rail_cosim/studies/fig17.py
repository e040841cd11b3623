"""Fig. 17 of the article: wheel force and axle-box acceleration over slab joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from scipy.signal import find_peaks

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import BOX, FORCE, GRAVITY, Check
from rail_cosim.studies.article_plots import Draw, panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.zx_line import BASES, BASIS, BAY, CAM, PITCH, ZX, last_slabs

_SOFT, _HARD = 300e6, 3000e6
_COLOURS = {_SOFT: "#D55E00", _HARD: "#0072B2"}
_SPEED = 350.0


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study; the article does not print the speed: here that of Fig. 16."""
    study = article.ArticleStudy(
        name="fig17",
        title="Fig. 17: slab joints at 350 km/h, ZX line; CAM layer of 300 and 3000 MN/m",
        grid={BASIS: list(BASES), CAM: [_SOFT, _HARD], "speed": [_SPEED]},
        settings=ZX,
        run={} if options.quick else {"distance": 200.0},
        keep={FORCE: ("min", "half_range", "slab_peak"), BOX: ("peak", "slab_peak")},
        history=(FORCE, BOX, "distance"),
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def lowest_place(one: xr.Dataset) -> float:
    """Return how far the smallest force lies from the nearest slab joint, m."""
    way, force = last_slabs(one, FORCE, 2)
    place = float(way[int(np.argmin(force))]) % PITCH
    return min(place, PITCH - place)


def dip(one: xr.Dataset) -> float:
    """Return the depth of the force's dip at a joint, N; 0 if there is none.

    Of what does not repeat from bay to bay: the largest prominence of a minimum within a bay of
    the joint, that is how far it lies below the lower of the peaks beside it.
    """
    way, force = last_slabs(one, FORCE, 2)
    count = round((len(force) - 1) / 2)
    lines = np.fft.rfft(force[:count])
    lines[:: round(PITCH / BAY)] = 0.0
    half = count // 2
    part = np.roll(np.fft.irfft(lines, count), half)  # the joint in the middle
    place = np.roll(way[:count], half)
    place[:half] -= PITCH
    minima, about = find_peaks(-part, prominence=0.0)
    near = np.abs(place[minima]) <= BAY
    return float(about["prominences"][near].max(initial=0.0))


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure, for both readings of the stiffness."""
    at = data.sel(speed=_SPEED)
    found: list[Check] = []
    for basis, words in BASES.items():
        here = at.sel({BASIS: basis})

        def of(
            name: str, stiffness: float, unit: float, here: xr.Dataset = here
        ) -> dict[str, float]:
            return {
                s: v / unit
                for s, v in article.both(
                    lambda d: article.largest(d.sel({CAM: stiffness}), name), here
                ).items()
            }

        soft, hard = of(f"{FORCE}_slab_peak", _SOFT, 1e3), of(f"{FORCE}_slab_peak", _HARD, 1e3)
        box = {k: of(f"{BOX}_peak", k, GRAVITY) for k in (_SOFT, _HARD)}
        found += [
            Check(
                name=f"{words}: force that repeats with the slabs, soft over hard layer",
                stated="larger on the soft one",
                found={s: soft[s] / hard[s] for s in soft},
                low=1.0 + 1e-9,
                digits=2,
            ),
            Check(
                name=f"{words}: smallest force, soft less hard layer, kN",
                stated="lower on the soft one",
                found=article.both(_lower, here),
                high=-1e-9,
                digits=2,
            ),
            Check(
                name=f"{words}: smallest force on the soft layer, m from a joint",
                stated="at the joint (here: one bay)",
                found=article.both(lambda d: lowest_place(d.sel({CAM: _SOFT})), here),
                high=BAY,
                digits=2,
            ),
            Check(
                name=f"{words}: dip of that force at the joint, soft layer, kN",
                stated="a decrease, then a rapid increase",
                found=article.both(lambda d: dip(d.sel({CAM: _SOFT})) / 1e3, here),
                low=1e-3,
                digits=2,
            ),
            Check(
                name=f"{words}: dip at the joint, soft over hard layer",
                stated="larger on the soft one",
                found=article.both(_deeper, here),
                low=1.0 + 1e-9,
                digits=2,
            ),
            Check(
                name=f"{words}: largest axle-box acceleration, soft less hard layer, g",
                stated="higher on the soft one",
                found={s: box[_SOFT][s] - box[_HARD][s] for s in box[_SOFT]},
                low=1e-9,
                digits=2,
            ),
        ]
    return found


def _lower(data: xr.Dataset) -> float:
    lowest = data[f"{FORCE}_min"].min(["wheelset", "side"])
    return float(lowest.sel({CAM: _SOFT}) - lowest.sel({CAM: _HARD})) / 1e3


def _deeper(data: xr.Dataset) -> float:
    hard = dip(data.sel({CAM: _HARD}))
    return dip(data.sel({CAM: _SOFT})) / hard if hard > 0.0 else np.inf


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw acceleration and force over two slabs, for both readings."""

    def row(basis: str, name: str, unit: float, words: str) -> Draw:
        def panel(axes: Axes, one: xr.Dataset) -> None:
            for stiffness, colour in _COLOURS.items():
                part = one.sel({BASIS: basis, CAM: stiffness, "speed": _SPEED})
                way, values = last_slabs(part, name, 2)
                label = f"{stiffness / 1e6:g} MN/m {BASES[basis]}"
                axes.plot(way, values / unit, color=colour, lw=1.1, label=label)
            for joint in range(3):
                axes.axvline(joint * PITCH, color="0.6", ls=":", lw=0.8)
            axes.set_xlabel("distance travelled (m); dotted: slab joints")
            axes.set_ylabel(words)

        return panel

    rows = [
        row(basis, name, unit, words)
        for basis in BASES
        for name, unit, words in (
            (BOX, 1.0, "axle box (m/s²)"),
            (FORCE, 1e3, "wheel force (kN)"),
        )
    ]
    panels(data, rows, path, title=data.attrs["title"], height=2.6)
