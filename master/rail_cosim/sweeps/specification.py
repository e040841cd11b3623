"""What a sweep is asked for: axes, fixed settings, what to keep; from TOML or from Python."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.options import RunOptions
from rail_cosim.slave import Value
from rail_cosim.sweeps.quantities import NAMES, PERIODIC, is_statistic
from rail_cosim.toml_files import assignments, flat, located, located_settings, read_toml
from rail_cosim.window import WindowChoice

RUN_OPTIONS = (
    "line",
    "vehicle",
    "track",
    "vehicle_map",
    "track_map",
    "speed",
    "distance",
    "until_steady",
    "final_speed",
    "irregularity",
    "macro_step",
    "algorithm",
    "record_every",
)
"""Options of a run that may be fixed or be an axis."""

KEPT: Mapping[str, Sequence[str]] = {
    "normal_force": ("max", "min", "mean", "half_range", "lift_off_time"),
    "axle_box_vertical_acceleration": ("max", "min", "half_range", "peak", "dominant_frequency"),
}
"""What is kept of each point unless said otherwise: statistics by variable of a run."""

DISTANCE, UNTIL_STEADY = 500.0, 1e-3
_OWNERS = ("track.", "vehicle.")
_SECTIONS = ("run", "set", "grid", "points", "keep", "window", "history")
_PERCENTILES = ("p99.85", "p99.85_20_hz")  # examples of the general names


@dataclasses.dataclass(frozen=True, kw_only=True)
class SweepSpecification:
    """Points and what is common to them.

    Attributes
    ----------
    grid
        Values by axis: all combinations are run.
    points
        Or single points, each with a value for the same axes.
    run
        Options of a run (:data:`RUN_OPTIONS`) common to all points.
    settings
        Parameter values by full name, common to all points.
    keep
        Statistics (:func:`rail_cosim.sweeps.quantities.is_statistic`) by variable of a run's
        Dataset.
    window
        Evaluation window of the statistics: ``from`` and ``to`` (distance travelled in m, one or
        both) or ``last_slabs``; empty: the last slab length of a run that ends when it is steady,
        the whole run where ``until_steady`` is false.
    history
        Variables of which the records themselves are kept, each ``history_every``-th.
    folder
        From where relative paths are seen; ``None`` for the working directory.

    An axis is an option of a run, or a parameter by its full name. Unless ``run`` says otherwise
    a run ends when it is steady (:data:`UNTIL_STEADY`), but not one with an ``irregularity``; and
    after :data:`DISTANCE` m.

    Raises
    ------
    ParameterError
        For anything that makes no sense.
    """

    grid: Mapping[str, Sequence[Value]] = dataclasses.field(
        default_factory=dict[str, Sequence[Value]]
    )
    points: Sequence[Mapping[str, Value]] = ()
    run: Mapping[str, Any] = dataclasses.field(default_factory=dict[str, Any])
    settings: Mapping[str, Value] = dataclasses.field(default_factory=dict[str, Value])
    keep: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=lambda: dict(KEPT))
    window: Mapping[str, Any] = dataclasses.field(default_factory=dict[str, Any])
    history: Sequence[str] = ()
    history_every: int = 1
    folder: Path | None = None

    def __post_init__(self) -> None:
        if bool(self.grid) == bool(self.points):
            limit = "a sweep needs axes or single points, and not both"
            raise ParameterError("grid", dict(self.grid), limit, "give [grid] or [[points]]")
        for name in (*self.axes, *self.settings):
            _check_axis(name)
        for name in self.run:
            if name not in RUN_OPTIONS:
                raise UnknownNameError(f"run.{name}", self.run[name], RUN_OPTIONS, "option", name)
        for name in self.axes:
            if name in self.settings or name in self.run:
                limit = "it is an axis and fixed at once"
                raise ParameterError(name, {**self.run, **self.settings}[name], limit)
        for axis, values in self.grid.items():
            if len(values) == 0 or len(set(values)) < len(values):
                raise ParameterError(axis, list(values), "must be different values, at least one")
        for point in self.points:
            if set(point) != set(self.axes):
                limit = "every point must give the same axes: " + ", ".join(self.axes)
                raise ParameterError("points", dict(point), limit)
        self._check_kept()

    def _check_kept(self) -> None:
        choice = self.window_choice
        for variable, statistics in self.keep.items():
            for name in statistics:
                if not is_statistic(name):
                    known = (*NAMES, *_PERCENTILES)
                    raise UnknownNameError(
                        f"keep.{variable}", name, known, "statistic", name, listed=True
                    )
                if name in PERIODIC and self._whole_run(choice):
                    limit = "is taken from whole slab lengths, not from the whole run"
                    remedy = "choose last_slabs = 1 below [window]"
                    raise ParameterError(f"keep.{variable}", name, limit, remedy)
        if self.history_every < 1:
            raise ParameterError("history.every", self.history_every, "must be at least 1")

    def _whole_run(self, choice: WindowChoice | None) -> bool:
        """Whether no point is evaluated over slab lengths."""
        if choice is None:
            return "until_steady" in self.run and not self.run["until_steady"]
        return choice.last_slabs is None

    @property
    def window_choice(self) -> WindowChoice | None:
        """The evaluation window; ``None`` where it follows what the run is.

        Raises
        ------
        ParameterError
            If it makes no sense.
        """
        return WindowChoice.of(self.window) if self.window else None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, in order."""
        return tuple(self.grid) if self.grid else tuple(self.points[0])

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis of a grid; of single points their number."""
        if self.grid:
            return tuple(len(values) for values in self.grid.values())
        return (len(self.points),)

    def all_points(self) -> list[dict[str, Value]]:
        """Return the values of the axes at all points, the last axis running fastest."""
        if self.points:
            return [dict(point) for point in self.points]
        combinations = itertools.product(*self.grid.values())
        return [dict(zip(self.grid, values, strict=True)) for values in combinations]

    def options(self, point: Mapping[str, Value]) -> RunOptions:
        """Return the options of the run at one point."""
        given: dict[str, Any] = {"distance": DISTANCE, **self.run}
        settings = dict(self.settings)
        for name, value in point.items():
            (settings if name.startswith(_OWNERS) else given)[name] = value
        for name in ("vehicle", "irregularity"):
            value = given.get(name)
            given[name] = None if value is None else located(str(value), self.folder)
        for name in ("track", "vehicle_map", "track_map"):
            if given.get(name) is not None:
                given[name] = (self.folder or Path()) / Path(given[name]).expanduser()
        usual = UNTIL_STEADY if given.get("irregularity") is None else None
        # false or 0: the whole distance
        given["until_steady"] = given.get("until_steady", usual) or None
        options = RunOptions(**given, settings=assignments(located_settings(settings, self.folder)))
        if self.window_choice is not None:
            self.window_choice.check(options.distance)
        return options


def _check_axis(name: str) -> None:
    if not name.startswith(_OWNERS) and name not in RUN_OPTIONS:
        what = "axis (write track.NAME, vehicle.NAME or an option of a run)"
        raise UnknownNameError(name, None, RUN_OPTIONS, what, listed=True)


def read_specification(path: Path) -> SweepSpecification:
    """Return the specification in a TOML file.

    ``[run]`` has options of a run, ``[set]`` fixed parameters, ``[grid]`` axes (a list, or
    ``{start = 80, stop = 400, step = 5}`` with both ends), ``[[points]]`` single points
    instead, ``[keep]`` statistics by variable, ``[window]`` ``from``, ``to`` or ``last_slabs``,
    ``[history]`` ``variables`` and ``every``.
    Relative paths are relative to the file.

    Raises
    ------
    ParameterError
        If it cannot be read or makes no sense.
    """
    content = read_toml(path, "SPEC", _SECTIONS)
    given: dict[str, Any] = {
        "grid": {name: _axis(name, value) for name, value in flat(content.get("grid", {}))},
        "points": [dict(flat(point)) for point in content.get("points", [])],
        "run": content.get("run", {}),
        "settings": dict(flat(content.get("set", {}))),
        "window": content.get("window", {}),
        "folder": path.absolute().parent,
    }
    if "keep" in content:
        given["keep"] = content["keep"]
    history = dict(content.get("history", {}))
    given["history"] = history.pop("variables", ())
    given["history_every"] = history.pop("every", 1)
    if history:
        name, value = next(iter(history.items()))
        raise UnknownNameError(f"history.{name}", value, ("variables", "every"), "entry", name)
    return SweepSpecification(**given)


def _axis(name: str, value: Any) -> list[Value]:
    if isinstance(value, list):
        return cast("list[Value]", value)
    if not isinstance(value, Mapping):
        limit = "must be a list or {start = ..., stop = ..., step = ...}"
        raise ParameterError(f"grid.{name}", value, limit)
    ends = cast("Mapping[str, float]", value)
    return steps(name, ends["start"], ends["stop"], ends["step"])


def steps(name: str, start: float, stop: float, step: float) -> list[Value]:
    """Return the values from ``start`` to ``stop``, both included, at distances ``step``."""
    count = (stop - start) / step if step else math.nan
    if not (math.isfinite(count) and count > -1e-9 and abs(count - round(count)) < 1e-6):
        shown = {"start": start, "stop": stop, "step": step}
        limit = "stop must be a whole number of steps after start"
        raise ParameterError(f"grid.{name}", shown, limit)
    return [start + i * step for i in range(round(count) + 1)]
