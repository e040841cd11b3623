"""Fig. 7 of the article: random irregularity, sliding window and moving irregularity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.studies import article
from rail_cosim.studies.article import FORCE, Check
from rail_cosim.studies.article_plots import panels, spectrum_line
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.summary import spectrum

METHOD = "track.window.method"
_NAMES = {"sliding": "sliding window", "moving_irregularity": "moving irregularity"}
_STYLES = {"sliding": ("-", "#0072B2"), "moving_irregularity": ("--", "#D55E00")}
_SPEED, _BAY = 300.0, 0.629
_LEAD = 30.0  # m; the irregularity grows from nothing over the first 20
_SHOWN = 20.0  # m


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study; the article does not name its spectrum: here German low disturbance."""
    study = article.ArticleStudy(
        name="fig07",
        title="Fig. 7: wheel force on random irregularity (German low disturbance) at 300 km/h",
        grid={METHOD: list(_NAMES), "speed": [_SPEED]},
        run={
            "irregularity": "german_low",
            "until_steady": False,
            "distance": 150.0 if options.quick else 500.0,
            "record_every": 2 if options.quick else 5,
        },
        keep={FORCE: ("rms", "max")},
        history=(FORCE, "distance"),
        checks=checks,
        draw=draw,
    )
    return article.carry_out(study, options, reporter)


def signal(data: xr.Dataset, method: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), way (m) and force (N) of the leading left wheel after the lead-in."""
    one = data.sel({METHOD: method, "speed": _SPEED})
    way = one["distance_history"].to_numpy()
    force = one[f"{FORCE}_history"].isel(wheelset=0, side=0).to_numpy()
    time = one["time_history"].to_numpy()
    there = np.isfinite(force) & (way >= _LEAD)
    return time[there], way[there], force[there]


def at_sleepers(data: xr.Dataset, method: str) -> float:
    """Return the amplitude (N) within 1.5 Hz of the sleeper-passing frequency."""
    time, _, force = signal(data, method)
    frequencies, found = spectrum(time, force)
    return float(found[np.abs(frequencies - _SPEED / 3.6 / _BAY) < 1.5].max())


def difference(data: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and force of the sliding window less that of the moving irregularity."""
    time, _, sliding = signal(data, "sliding")
    return time, sliding - signal(data, "moving_irregularity")[2]


def checks(data: xr.Dataset) -> list[Check]:
    """Return what the text says of the figure."""

    def share(one: xr.Dataset) -> float:
        force = signal(one, "sliding")[2]
        return float(100.0 * difference(one)[1].std() / force.std())

    def dominant(one: xr.Dataset) -> float:
        frequencies, found = spectrum(*difference(one))
        return float(frequencies[int(np.argmax(found))])

    def ratio(one: xr.Dataset) -> float:
        return at_sleepers(one, "sliding") / at_sleepers(one, "moving_irregularity")

    passing = _SPEED / 3.6 / _BAY
    return [
        Check(
            name="rms of the difference, % of the rms of the force",
            stated="some small differences (here: 2 to 30)",
            found=article.both(share, data),
            low=2.0,
            high=30.0,
        ),
        Check(
            name="dominant frequency of the difference, Hz",
            stated=f"sleeper passing, {passing:.1f}",
            found=article.both(dominant, data),
            low=passing - 1.5,
            high=passing + 1.5,
        ),
        Check(
            name="amplitude at sleeper passing, sliding over moving irregularity",
            stated="larger",
            found=article.both(ratio, data),
            low=1.0 + 1e-9,
        ),
    ]


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw the end of the time history, the spectra, and the spectrum of the difference."""

    def time(axes: Axes, one: xr.Dataset) -> None:
        for method, label in _NAMES.items():
            style, colour = _STYLES[method]
            _, way, force = signal(one, method)
            last = way >= way[-1] - _SHOWN
            axes.plot(way[last], force[last] / 1e3, style, color=colour, lw=1.0, label=label)
        axes.set_xlabel("distance travelled (m)")
        axes.set_ylabel("wheel force (kN)")

    def frequency(axes: Axes, one: xr.Dataset) -> None:
        for method, label in _NAMES.items():
            style, colour = _STYLES[method]
            moment, _, force = signal(one, method)
            about = {"ls": style, "color": colour, "label": label}
            spectrum_line(axes, *spectrum(moment, force), lowest=1.0, **about)
        axes.set_ylabel("amplitude (N)")

    def apart(axes: Axes, one: xr.Dataset) -> None:
        spectrum_line(axes, *spectrum(*difference(one)), lowest=1.0, color="0.2")
        axes.axvline(_SPEED / 3.6 / _BAY, ymax=0.06, color="#D55E00", lw=2.0)
        axes.set_ylabel("amplitude of the difference (N)")

    panels(data, [time, frequency, apart], path, title=data.attrs["title"])
