"""What to run: the options of one co-simulation."""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rail_cosim.algorithms import GaussSeidel
from rail_cosim.errors import ParameterError

KM_H = 1.0 / 3.6
MACRO_STEP = 1e-4


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What to run; the fields are the options of ``rail-cosim run``.

    Attributes
    ----------
    system
        An SSP package with a vehicle and a track, instead of ``line``, ``vehicle`` and ``track``.
    line
        Parameter set of the track FMU (``HD``, ``ZX``); ``None`` for its defaults.
    vehicle
        Parameter set of the vehicle FMU, or the path of another vehicle FMU.
    track
        Path of another track FMU.
    vehicle_map, track_map
        Files that map the names of these FMUs to those of the contract (see
        :mod:`rail_cosim.name_map`); ``None`` where they have those names.
    speed
        In km/h; ``None`` for the vehicle's own.
    distance
        Distance travelled by the leading wheelset in m.
    until_steady
        End the run when it is steady: the largest relative change of wheel forces and axle-box
        accelerations from slab to slab (see :mod:`rail_cosim.steady`); ``distance`` is then
        the limit, and ``macro_step`` is shortened to the next whole part of a slab length.
        ``None`` for the whole distance.
    final_speed
        Speed of the car body at the end of the distance in km/h, reached by uniform acceleration
        from ``speed`` (the wheelsets follow on their suspension); ``None`` for a constant speed.
    irregularity
        A spectrum of the track FMU, ``rail_joint``, or a file (see
        :func:`rail_cosim.irregularity.irregularity_parameters`); ``None`` for the track's own.
    settings
        Texts ``track.NAME=VALUE`` and ``vehicle.NAME=VALUE``; they come last and win.
    macro_step
        Communication step in s.
    algorithm
        ``gauss-seidel``, ``jacobi`` or ``iterative-gauss-seidel``.
    record_every
        Record each step (1), each second (2), ...
    trust
        Whether to run FMUs that were not built here without saying so.
    out, plot
        NetCDF file and picture to write; ``None`` for none.
    variables
        Variables of the results, by names with the wildcards ``*`` and ``?``; empty for all.
        Time and ``distance`` are always there.
    animate
        Animation to write, .mp4 or .gif; ``None`` for none.
    slow_motion
        Seconds of the animation per second of the run.
    exaggeration
        Of vertical displacements in the animation; ``None``: so that the rails' largest is well
        seen.
    resume
        Resume where a run with the same options and ``out`` was stopped (see
        :mod:`rail_cosim.checkpoint`).
    checkpoint_interval
        Seconds between two checkpoints of a run that has ``out``.
    command
        The command as typed, for the record.
    """

    system: Path | None = None
    line: str | None = None
    vehicle: str | None = None
    track: Path | None = None
    vehicle_map: Path | None = None
    track_map: Path | None = None
    speed: float | None = None
    distance: float = 100.0
    until_steady: float | None = None
    final_speed: float | None = None
    irregularity: str | None = None
    settings: Sequence[str] = ()
    macro_step: float = MACRO_STEP
    algorithm: str = GaussSeidel.name
    record_every: int = 1
    trust: bool = False
    out: Path | None = None
    variables: Sequence[str] = ()
    plot: Path | None = None
    animate: Path | None = None
    slow_motion: float = 50.0
    exaggeration: float | None = None
    resume: bool = False
    checkpoint_interval: float = 60.0
    command: str = ""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            _check_kind(field, getattr(self, field.name))
        if self.system is not None:
            others = {"--line": self.line, "--vehicle": self.vehicle, "--track": self.track}
            for name, value in others.items():
                if value is not None:
                    limit = f"{self.system} has vehicle, track and their parameters"
                    raise ParameterError(name, str(value), limit, "change single ones with --set")
        for name, names, fmu in (
            ("vehicle", self.vehicle_map, self.vehicle),
            ("track", self.track_map, self.track),
        ):
            if names is not None and fmu is None:
                limit = "it maps the names of another FMU, and none is given"
                raise ParameterError(f"--{name}-map", str(names), limit, f"add --{name} FMU")
        _check_names("--variables", self.variables)
        limits = (
            ("--distance", self.distance, "m"),
            ("--macro-step", self.macro_step, "s"),
            ("--speed", self.speed, "km/h"),
            ("--until-steady", self.until_steady, ""),
            ("--final-speed", self.final_speed, "km/h"),
            ("--slow-motion", self.slow_motion, ""),
            ("--exaggeration", self.exaggeration, ""),
            ("--checkpoint-interval", self.checkpoint_interval, "s"),
        )
        for name, value, unit in limits:
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, f"must be greater than 0 {unit}".rstrip())
        if self.final_speed is not None and self.until_steady is not None:
            limit = "a run at changing speed does not become steady"
            raise ParameterError("--final-speed", self.final_speed, limit, "omit --until-steady")
        if self.record_every < 1:
            raise ParameterError("--record-every", self.record_every, "must be at least 1")
        if self.resume and self.animate is not None:
            limit = "of the part that was run before nothing is known but the records"
            raise ParameterError("--animate", str(self.animate), limit, "omit --resume")
        if self.resume and self.out is None:
            limit = "what was begun is found by its results"
            raise ParameterError("--resume", True, limit, "give the --out of the run begun")


_KINDS = {"float": "a number", "int": "a whole number", "str": "a text", "Path": "a path"}
_KINDS["bool"] = "true or false"


def _check_names(option: str, value: Any) -> None:
    """Refuse what is no list of texts, which a file may give."""
    if isinstance(value, str) or not all(isinstance(name, str) for name in value):
        raise ParameterError(option, repr(value), "must be a list of names")


def _check_kind(field: dataclasses.Field[Any], value: object) -> None:
    """Refuse a value of the wrong type, which a file or a script may give."""
    kind = str(field.type).partition(" | ")[0]
    if kind not in _KINDS or (value is None and field.default is None):
        return
    allowed = {
        "float": numbers.Real,
        "int": numbers.Integral,
        "str": str,
        "Path": Path,
        "bool": bool,
    }[kind]
    mixed = isinstance(value, bool) != (kind == "bool")  # to Python a bool is an int
    if mixed or not isinstance(value, allowed):
        raise ParameterError("--" + field.name.replace("_", "-"), value, f"must be {_KINDS[kind]}")
