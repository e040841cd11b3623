"""Critical speed of the pair: the vehicle starts off the middle of a smooth track.

Runs at rising speeds until one does not come back to the middle, then halves the interval.
With a start of some millimetres this is the non-linear critical speed of that amplitude:
flange contact and the dampers' blow-off included.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.errors import ParameterError, RailCosimError, RunError, RunInterrupted
from rail_cosim.options import KM_H, RunOptions
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.runner import execute
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.decay import LateralMotion, analyse
from rail_cosim.studies.plots import plot_critical_speed

SPEEDS = (200.0, 300.0, 400.0, 500.0, 600.0)
"""Speeds tried one after the other, km/h; the last is the limit of the search."""

_DURATION, _QUICK_DURATION = 4.0, 2.5  # s
_RESOLUTION, _QUICK_RESOLUTION = 5.0, 25.0  # km/h
_MACRO_STEP = 5e-4  # s; lateral motions are below 20 Hz
_OFF = 12e-3  # m; a wheel that far off when a run breaks off has left its rail
_LATERAL = "wheelset_lateral_displacement"
# Few modes and long internal steps: hunting is slow against what these leave out. The rails
# must keep their lateral motion: on rigid ones the critical speed comes out too high.
COARSE = (
    "vehicle.initial_lateral_displacement=0.010",  # the flanges touch: limit cycles are found
    "track.contact.model=profiles",
    "track.rail.mode_count=100",
    "track.slab.mode_count=12",
    "track.integration.maximum_step=5e-4",
)
"""The study's own settings; ``--set`` wins over them."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Attempt:
    """One run: speed in km/h, its motion (``None`` if the vehicle derailed), its record."""

    speed: float
    motion: LateralMotion | None
    time: np.ndarray
    lateral: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether the start died out."""
        return self.motion is not None and self.motion.stable

    @property
    def verdict(self) -> str:
        """What happened, in a word or two."""
        return "derails" if self.motion is None else self.motion.verdict


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    _refuse_speed(options)
    data, picture = options.out / "critical_speed.nc", options.out / "critical_speed.png"
    check_netcdf(data)
    resolution = _QUICK_RESOLUTION if options.quick else _RESOLUTION
    attempts = search(lambda speed: attempt(speed, options, reporter), resolution=resolution)
    conclusion = conclude(attempts)
    write_netcdf(as_dataset(attempts, options, conclusion), data)
    plot_critical_speed(attempts, bracket(attempts), picture)
    return StudyResult(table=as_table(attempts), conclusion=conclusion, files=[data, picture])


def _refuse_speed(options: StudyOptions) -> None:
    for text in options.settings:
        name, _, value = text.partition("=")
        if name.strip() in ("vehicle.speed", "vehicle.speed_setpoint"):
            limit = "the study sets the speed itself"
            raise ParameterError(name.strip(), value, limit, "leave it out")


def search(try_speed: Callable[[float], Attempt], *, resolution: float) -> list[Attempt]:
    """Return the attempts of the search, by speed.

    Parameters
    ----------
    try_speed
        Makes an attempt at a speed in km/h.
    resolution
        Width of the interval at which to stop, km/h.
    """
    attempts: list[Attempt] = []
    for speed in SPEEDS:
        attempts.append(try_speed(speed))
        if not attempts[-1].stable:
            break
    low, high = bracket(attempts)
    while low is not None and high is not None and high - low > resolution:
        attempts.append(try_speed(0.5 * (low + high)))
        attempts.sort(key=lambda one: one.speed)
        low, high = bracket(attempts)
    return attempts


def bracket(attempts: list[Attempt]) -> tuple[float | None, float | None]:
    """Return the highest stable speed below the lowest unstable one, and that, km/h.

    ``None`` for either that there is not.
    """
    high = min((one.speed for one in attempts if not one.stable), default=None)
    stable = (one.speed for one in attempts if one.stable and (high is None or one.speed < high))
    return max(stable, default=None), high


def attempt(speed: float, options: StudyOptions, reporter: Reporter) -> Attempt:
    """Run at a speed (km/h) and say what the wheelsets do.

    Raises
    ------
    RailCosimError
        If the run cannot be done; a derailment is no error here.
    """
    reporter.stage(f"{speed:g} km/h")
    duration = _QUICK_DURATION if options.quick else _DURATION
    wanted = RunOptions(
        speed=speed,
        distance=speed * KM_H * duration,
        settings=[*COARSE, *options.settings],
        macro_step=_MACRO_STEP,
        command=options.command,
    )
    try:
        dataset = execute(wanted, reporter)
    except RunInterrupted:
        raise
    except RunError as error:
        if error.dataset is None or not _has_derailed(error.dataset):
            raise
        time, lateral = _record(error.dataset)
        return Attempt(speed=speed, motion=None, time=time, lateral=lateral)
    time, lateral = _record(dataset)
    return Attempt(speed=speed, motion=analyse(time, lateral), time=time, lateral=lateral)


def _record(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    if _LATERAL not in dataset:
        raise RailCosimError("the vehicle FMU gives no lateral displacement of its wheelsets")
    return dataset["time"].to_numpy(), dataset[_LATERAL].to_numpy()


def _has_derailed(dataset: xr.Dataset) -> bool:
    return dataset.sizes["time"] > 1 and float(np.abs(_record(dataset)[1]).max()) > _OFF


def conclude(attempts: list[Attempt]) -> str:
    """Return the result as a sentence."""
    low, high = bracket(attempts)
    if high is None:
        return f"no critical speed up to {low:g} km/h: the start dies out at every speed tried"
    if low is None:
        return f"the critical speed is below {high:g} km/h, the lowest speed tried"
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return (
        f"critical speed {middle:.4g} km/h (+- {half:.2g}): the start dies out at {low:g} km/h, "
        f"at {high:g} km/h it does not"
    )


def as_table(attempts: list[Attempt]) -> Table:
    """Return the attempts as a table."""
    table = Table(title="Lateral motion after the start", title_justify="left", title_style="")
    heads = (
        "speed\nkm/h",
        "growth\nrate 1/s",
        "log.\ndecrement",
        "frequency\nHz",
        "at the end\nmm",
    )
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for one in attempts:
        cells = ["-"] * 4
        if one.motion is not None:
            motion = one.motion
            died = math.isnan(motion.growth_rate)  # before the evaluated half
            cells = [
                "-" if died else f"{motion.growth_rate:.3f}",
                "-" if died else f"{motion.decrement:.3f}",
                f"{motion.frequency:.2f}",
                f"{1e3 * motion.final_amplitude:.3f}",
            ]
        table.add_row(f"{one.speed:.5g}", *cells, one.verdict)
    return table


def as_dataset(attempts: list[Attempt], options: StudyOptions, conclusion: str) -> xr.Dataset:
    """Return the attempts as a Dataset: figures by speed, and the records themselves."""
    longest = max(attempts, key=lambda one: len(one.time))
    shape = (len(attempts), len(longest.time), longest.lateral.shape[1])
    lateral = np.full(shape, np.nan)
    for row, one in zip(lateral, attempts, strict=True):
        row[: len(one.time)] = one.lateral

    def figure(name: str) -> list[float]:
        return [np.nan if one.motion is None else getattr(one.motion, name) for one in attempts]

    def described(dims: str | tuple[str, ...], values, unit: str, meaning: str):
        return (dims, values, {"units": unit, "long_name": meaning})

    low, high = bracket(attempts)
    rate = described("speed", figure("growth_rate"), "1/s", "growth rate of the lateral motion")
    decrement = described("speed", figure("decrement"), "1", "logarithmic decrement")
    frequency = described("speed", figure("frequency"), "Hz", "dominant frequency")
    final = described("speed", figure("final_amplitude"), "m", "amplitude at the end")
    stable = described("speed", [int(one.stable) for one in attempts], "1", "1: it dies out")
    speeds = described("speed", [one.speed for one in attempts], "km/h", "running speed")
    return xr.Dataset(
        {
            "growth_rate": rate,
            "logarithmic_decrement": decrement,
            "frequency": frequency,
            "final_amplitude": final,
            "stable": stable,
            _LATERAL: described(
                ("speed", "time", "wheelset"), lateral, "m", "lateral displacement"
            ),
        },
        coords={"speed": speeds, "time": described("time", longest.time, "s", "time")},
        attrs={
            "study": "critical-speed",
            "conclusion": conclusion,
            "highest_stable_speed_km_h": np.nan if low is None else low,
            "lowest_unstable_speed_km_h": np.nan if high is None else high,
            "settings": "; ".join([*COARSE, *options.settings]),
            "macro_step": _MACRO_STEP,
            "command": options.command,
        },
    )
