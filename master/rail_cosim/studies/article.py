"""What the studies of the article's figures share: both settings, checks, data, plot.

The article is "Study on Steady-State Responses of High-Speed Vehicle Using Infinite Long Track
Model". Each figure is computed with the article's own settings (parameter set ``paper`` of the
track FMU: plain series of 200 rail modes and 24 slab modes) and with the converged defaults, the
contact vertical in both. The checks hold the numbers and statements of its text against ours.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.errors import RailCosimError
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.slave import Value
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.sweeps import SweepSpecification, execute_sweep
from rail_cosim.sweeps.specification import KEPT

SETTINGS = {"paper": "paper", "HD": "converged"}
"""Parameter set of the track, and what the study calls it."""

FORCE = "normal_force"
BOX = "axle_box_vertical_acceleration"
BOX_PEAK = f"{BOX}_peak"
STIFFNESS, DAMPING = "track.fastener.vertical_stiffness", "track.fastener.vertical_damping"
BAY = "track.fastener.spacing"
GRAVITY = 9.81

_RUN: dict[str, Any] = {"macro_step": 1e-4, "distance": 120.0, "until_steady": 1e-3}
_QUICK: dict[str, Any] = {"macro_step": 2e-4, "distance": 60.0, "until_steady": 5e-3}
_QUICK_STEP = ("track.integration.maximum_step", 2e-4)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Check:
    """A statement of the article, and what we find.

    Attributes
    ----------
    name
        What it is about, with unit.
    stated
        What the article says, or what it is derived from.
    found
        Our value by setting.
    low, high
        Where it passes, both included.
    digits
        Of the printed value.
    """

    name: str
    stated: str
    found: Mapping[str, float]
    low: float = -math.inf
    high: float = math.inf
    digits: int = 1

    def passed(self, setting: str) -> bool:
        """Whether our value is within the limits."""
        return self.low <= self.found[setting] <= self.high


@dataclasses.dataclass(frozen=True, kw_only=True)
class ArticleStudy:
    """A figure or table of the article.

    Attributes
    ----------
    name, title
        Of the study; the name is also that of its files.
    grid
        Axes, without the setting.
    settings, run
        Fixed parameters and options of the runs.
    keep, history
        What is kept of each run; histories are of all records.
    checks
        Makes the checks from the data.
    draw
        Draws the data to a file.
    """

    name: str
    title: str
    grid: Mapping[str, Sequence[Value]]
    checks: Callable[[xr.Dataset], list[Check]]
    draw: Callable[[xr.Dataset, Path], None]
    settings: Mapping[str, Value] = dataclasses.field(default_factory=dict)
    run: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    keep: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=lambda: dict(KEPT))
    history: Sequence[str] = ()


def carry_out(study: ArticleStudy, options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Run a study with both settings; write data and plot; return the checks.

    Raises
    ------
    RailCosimError
        If a point cannot be run, or files cannot be written.
    """
    check_netcdf(_files(study, options)[0])
    dataset = compute(study, options, reporter)
    return write_up(study, options, dataset, study.checks(dataset), study.draw)


def write_up(
    study: ArticleStudy,
    options: StudyOptions,
    dataset: xr.Dataset,
    checks: Sequence[Check],
    draw: Callable[[xr.Dataset, Path], None],
) -> StudyResult:
    """Write data and plot; return the checks."""
    data, picture = _files(study, options)
    dataset.attrs |= attributes(study, options, checks)
    write_netcdf(dataset, data)
    draw(dataset, picture)
    return StudyResult(
        table=table(study, checks), conclusion=conclude(checks, dataset), files=[data, picture]
    )


def _files(study: ArticleStudy, options: StudyOptions) -> tuple[Path, Path]:
    return options.out / f"{study.name}.nc", options.out / f"{study.name}.png"


def compute(study: ArticleStudy, options: StudyOptions, reporter: Reporter) -> xr.Dataset:
    """Run the points of a study with both settings.

    Raises
    ------
    RailCosimError
        If a point cannot be run.
    """
    dataset = execute_sweep(
        _specification(study, options),
        scheduler=None,
        workers=None,
        out=None,
        store=options.out / "points",
        reporter=reporter,
    )
    _refuse_failures(dataset)
    return dataset.rename(line="setting").assign_coords(setting=list(SETTINGS.values()))


def attributes(
    study: ArticleStudy, options: StudyOptions, checks: Sequence[Check]
) -> dict[str, str]:
    """Return what the data say of the study itself."""
    return {
        "study": study.name,
        "title": study.title,
        "command": options.command,
        "checks": json.dumps([_record(check) for check in checks]),
    }


def _specification(study: ArticleStudy, options: StudyOptions) -> SweepSpecification:
    settings, run = specification_settings(options, study.settings)
    return SweepSpecification(
        grid={"line": list(SETTINGS), **study.grid},
        settings=settings,
        run={**run, **study.run},
        keep=study.keep,
        history=study.history,
    )


def specification_settings(
    options: StudyOptions, own: Mapping[str, Value]
) -> tuple[dict[str, Value], dict[str, Any]]:
    """Return parameters and options of a study's runs; what the user gives wins."""
    settings: dict[str, Value] = {"track.contact.model": "vertical", **own}
    if options.quick:
        settings.setdefault(*_QUICK_STEP)
    for text in options.settings:
        name, _, value = text.partition("=")
        settings[name.strip()] = value.strip()
    return settings, dict(_QUICK if options.quick else _RUN)


def _refuse_failures(dataset: xr.Dataset) -> None:
    texts = [str(text) for text in dataset["error"].to_numpy().ravel() if text]
    if texts:
        raise RailCosimError(f"{len(texts)} points of the study failed, the first: {texts[0]}")


def _record(check: Check) -> dict[str, Any]:
    passed = {setting: check.passed(setting) for setting in check.found}
    found = dict(check.found)
    return {"name": check.name, "stated": check.stated, "found": found, "passed": passed}


def table(study: ArticleStudy, checks: Sequence[Check]) -> Table:
    """Return the checks as a table for the terminal."""
    rows = Table(title=study.title, title_justify="left", title_style="")
    rows.add_column("")
    rows.add_column("article")
    for setting in SETTINGS.values():
        rows.add_column(setting, justify="right")
        rows.add_column("")
    for check in checks:
        cells: list[str] = []
        for setting in SETTINGS.values():
            word = "pass" if check.passed(setting) else "fail"
            colour = "green" if word == "pass" else "red"
            cells += [f"{check.found[setting]:.{check.digits}f}", f"[{colour}]{word}[/]"]
        rows.add_row(check.name, check.stated, *cells)
    return rows


def conclude(checks: Sequence[Check], dataset: xr.Dataset) -> str:
    """Return how many statements hold, and how many runs were not steady."""
    words = [
        f"{sum(check.passed(s) for check in checks)} of {len(checks)} statements hold with the "
        f"{s} settings"
        for s in SETTINGS.values()
    ]
    text = "; ".join(words)
    flags = [array for name, array in dataset.data_vars.items() if str(name).endswith("steady")]
    unsteady = sum(int((array == 0).sum()) for array in flags)
    if unsteady:
        runs = sum(array.size for array in flags)
        text += f"; {unsteady} of {runs} runs had not become steady"
    return text


# What several studies look at


def tendency(
    name: str, rule: Callable[[xr.Dataset], float], data: xr.Dataset, stated: str = "yes"
) -> Check:
    """Return the check of a statement that holds (1) or does not (0) with either setting."""
    found = both(rule, data)
    return Check(name=f"{name} (1: yes)", stated=stated, found=found, low=1.0, digits=0)


def both(
    function: Callable[[xr.Dataset], float | xr.DataArray], data: xr.Dataset
) -> dict[str, float]:
    """Return a number for each setting."""
    return {s: float(function(data.sel(setting=s))) for s in SETTINGS.values()}


def largest(data: xr.Dataset, name: str = BOX_PEAK) -> xr.DataArray:
    """Return the largest value of all wheels."""
    return data[name].max(["wheelset", "side"])


def resonance_speed(data: xr.Dataset) -> xr.DataArray:
    """Return the speed (km/h) at which the axle-box acceleration is largest."""
    return largest(data).idxmax("speed")


def rises(values: Sequence[float] | np.ndarray | xr.DataArray) -> float:
    """Return 1 if each value is above the one before, else 0."""
    return float(np.all(np.diff(np.asarray(values)) > 0.0))


def grows(values: Sequence[float] | np.ndarray | xr.DataArray) -> float:
    """Return 1 if no value is below the one before and the last above the first, else 0.

    What :func:`rises` asks for is too much of speeds on a grid.
    """
    numbers = np.asarray(values)
    return float(np.all(np.diff(numbers) >= 0.0) and numbers[-1] > numbers[0])


def falls(values: Sequence[float] | np.ndarray | xr.DataArray) -> float:
    """Return 1 if no value is above the one before and the last below the first, else 0."""
    numbers = np.asarray(values)
    return float(np.all(np.diff(numbers) <= 0.0) and numbers[-1] < numbers[0])


def p2_frequency(
    stiffness: float, bay: float = 0.629, mass: float = 1881.0, bending: float = 2.059e11 * 3.217e-5
) -> float:
    """Return the P2 frequency of eq. (16) in Hz.

    Parameters
    ----------
    stiffness, bay
        Of a fastener in N/m, and their distance in m.
    mass
        Of a wheelset in kg.
    bending
        E I of the rail in N.m2, Table 2.
    """
    per_metre = stiffness / bay  # Eq. (14)
    track = 2.0 * (4.0 * bending * per_metre**3) ** 0.25  # Eq. (13)
    moving = 3.0 * 7860.0 * 7.745e-3 * (bending / track) ** (1.0 / 3.0)  # Eq. (15)
    return math.sqrt(track / (moving + 0.5 * mass)) / (2.0 * math.pi)  # Eq. (12)
