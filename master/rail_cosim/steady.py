"""Steady state, detected: successive slab lengths of a run are compared.

A vehicle on smooth track runs into a motion that repeats with the slab pitch. With ``x(t)`` a
wheel force or an axle-box acceleration and ``T`` the time of one pitch, the change over the last
pitch is

    change = rms(x(t) - x(t - T)) / rms(x(t) - mean of x),   t in the last T,

both root mean squares over all wheels. The run is steady when the larger change of the two
quantities has been within a tolerance for two pitches one after the other.

A discretisation repeats only where a pitch is a whole number of steps: else the places at which
the wheels are between two fasteners differ from slab to slab, and what is left of the step's
error with them (0.4 % of the fluctuation at 300 km/h and 0.1 ms, against 0.005 %). So the macro
step is shortened to the next whole part of ``T`` (:func:`fitted_step`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from rail_cosim.errors import ParameterError
from rail_cosim.recorder import Recorder
from rail_cosim.results import place
from rail_cosim.slave import Slave
from rail_cosim.system import SystemStructure
from rail_cosim.window import EvaluationWindow, distances, periods

Array = NDArray[np.float64]
OPTION = "--until-steady"
QUANTITIES = ("normal_force", "axle_box_vertical_acceleration")
SPACING, COUNT = "fastener.spacing", "fastener.count_per_slab"
_IN_A_ROW = 2
_FEWEST = 16  # records in a pitch


@dataclasses.dataclass(frozen=True, kw_only=True)
class SteadyReport:
    """How steady a run was at its end.

    Attributes
    ----------
    tolerance
        What was asked for.
    change
        Over the last pitch that was checked; infinite before the second pitch.
    steady
        Whether the run ended because it was steady.
    """

    tolerance: float
    change: float
    steady: bool


class SteadyState:
    """Stop rule of a run, asked once in a slab pitch.

    Parameters
    ----------
    system
        Initialised system with slaves ``track`` and ``vehicle``.
    recorder
        Where the run is recorded.
    tolerance
        Largest relative change from pitch to pitch.
    speed, step_size
        In m/s and s; a pitch must be a whole number of records (:func:`fitted_step`).

    Raises
    ------
    ParameterError
        If the track does not tell its slab pitch, or if there is nothing to compare.
    """

    def __init__(
        self,
        system: SystemStructure,
        recorder: Recorder,
        *,
        tolerance: float,
        speed: float,
        step_size: float,
    ) -> None:
        self._recorder, self._tolerance = recorder, tolerance
        pitch = slab_pitch(system["track"])
        self._every = recorder.every
        self._period = round(pitch / speed / (step_size * recorder.every))  # in records
        self._columns = _columns(system)
        if not self._columns:
            limit = f"the FMUs have none of the outputs {', '.join(QUANTITIES)}"
            raise ParameterError(OPTION, tolerance, limit, "leave this option out")
        self._pitches = 1
        self._passed = 0
        self._change = math.inf
        self._after_next()

    def _after_next(self) -> None:
        self._pitches += 1
        self.next_step = self._pitches * self._period * self._every

    @property
    def report(self) -> SteadyReport:
        """What was found so far."""
        steady = self._passed >= _IN_A_ROW
        return SteadyReport(tolerance=self._tolerance, change=self._change, steady=steady)

    def memory(self) -> dict[str, NDArray[np.float64]]:
        """Return what it remembers."""
        return {"found": np.array([self._pitches, self._passed, self._change])}

    def recall(self, memory: Mapping[str, NDArray[np.float64]]) -> None:
        """Take back what :meth:`memory` returned."""
        pitches, passed, change = memory["found"]
        self._pitches, self._passed, self._change = int(pitches) - 1, int(passed), float(change)
        self._after_next()

    def check(self) -> bool:
        """Compare the last two pitches; call it when step ``next_step`` is recorded."""
        changes = []
        for slave, columns in self._columns:
            values = self._recorder.latest(slave, columns, 2 * self._period)
            changes.append(relative_change(values))
        self._change = max(changes)
        self._passed = self._passed + 1 if self._change <= self._tolerance else 0
        self._after_next()
        return self._passed >= _IN_A_ROW


def fitted_step(pitch: float, speed: float, largest: float, every: int = 1) -> float:
    """Return the largest macro step (s) of which a pitch is a whole number of records.

    Parameters
    ----------
    pitch
        Slab pitch in m.
    speed
        In m/s.
    largest
        Largest macro step in s.
    every
        Each how manieth step is recorded.

    Raises
    ------
    ParameterError
        If a pitch would have too few records to tell anything.
    """
    period = pitch / speed
    records = math.ceil(period / (largest * every) * (1.0 - 1e-9))
    if records < _FEWEST:
        limit = f"a slab length of {pitch:g} m has only {records} records, needed are {_FEWEST}"
        raise ParameterError("--macro-step", largest, limit, "take less, or record more often")
    return period / (records * every)


def slab_pitch(track: Slave) -> float:
    """Return the length of a slab and its gap in m.

    Raises
    ------
    ParameterError
        If the track does not tell it.
    """
    if SPACING not in track.variables or COUNT not in track.variables:
        limit = f"the track FMU has no parameters {SPACING} and {COUNT}"
        remedy = "its slab pitch is not known; leave this option out and give a distance"
        raise ParameterError(OPTION, None, limit, remedy)
    values = track.get([SPACING, COUNT])
    return float(values[SPACING]) * float(values[COUNT])


def _columns(system: SystemStructure) -> list[tuple[str, list[int]]]:
    """Return for each quantity that there is the slave and the columns of its records."""
    found: list[tuple[str, list[int]]] = []
    for port in system.ports:
        names = port.outputs.names
        for quantity in QUANTITIES:
            columns = [i for i, name in enumerate(names) if place(name).variable == quantity]
            if columns:
                found.append((port.slave.name, columns))
    return found


def relative_change(values: NDArray[np.float64]) -> float:
    """Return the change of signals from one period to the next, relative to their fluctuation.

    Parameters
    ----------
    values
        Equidistant records of two whole periods, shape (2 n, signals).

    Returns
    -------
    float
        0 where nothing fluctuates; infinity where a value is not finite.
    """
    before, now = np.split(values, 2)
    size = float(np.sqrt(np.mean((now - now.mean(axis=0)) ** 2)))
    change = float(np.sqrt(np.mean((now - before) ** 2)))
    if not math.isfinite(change):
        return math.inf
    if change <= 1e-12 * float(np.abs(now).max()):
        return 0.0
    return change / size if size > 0.0 else math.inf


def slab_to_slab_change(run: xr.Dataset, window: EvaluationWindow) -> float:
    """Return the largest relative change from slab to slab over a window of a recorded run.

    The measure is that of :class:`SteadyState`, for each slab length in the window against the one
    before it. Where a slab length is no whole number of records, the earlier one is interpolated
    by cubic splines over the distance; that and the discretisation leave some 0.1 % on steady
    motion at 300 km/h and 0.1 ms.

    Returns
    -------
    float
        Relative to the fluctuation; NaN where it cannot be told: the slab length is not known,
        the run is shorter than two of them, or none of :data:`QUANTITIES` is recorded.
    """
    distance, pitch = distances(run), periods(run)[1]
    names = [name for name in QUANTITIES if name in run]
    changes: list[float] = []
    for number in range(window.periods if window.of == "slab" else 0):
        stop = window.stop - number * pitch
        # A record more at either end, for the spline and against rounding.
        first, last = np.searchsorted(distance, (stop - 2.0 * pitch, stop + 1e-9))
        rows = slice(max(0, int(first) - 1), int(last))
        way = distance[rows]
        now = way > stop - pitch * (1.0 - 1e-9)
        if not now.any() or way[now][0] - pitch < way[0] - 1e-6 or (np.diff(way) <= 0.0).any():
            continue
        for name in names:
            values = run[name].isel(time=rows).transpose("time", ...).to_numpy()
            changes.append(_change(way, values.reshape(len(way), -1), now, pitch))
    return max(changes, default=math.nan)


def _change(way: Array, values: Array, now: NDArray[np.bool_], pitch: float) -> float:
    """Return the relative change of signals (n, signals) at ``now`` from a pitch before."""
    values = values[:, ~np.isnan(values).all(axis=0)]  # without wheels that do not exist
    if not np.isfinite(values).all():
        return math.inf
    before = CubicSpline(way, values)(way[now] - pitch)
    return relative_change(np.concatenate([before, values[now]]))
