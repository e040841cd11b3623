"""From a specification to tasks: what each point runs, checked, and a key that says so."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from rail_cosim.archives import LARGEST, opened, read_member
from rail_cosim.description import FmuDescription
from rail_cosim.errors import UnknownNameError
from rail_cosim.options import RunOptions
from rail_cosim.results import variable_names
from rail_cosim.runner import find_fmus, gather_parameters
from rail_cosim.slave import Renaming, Value
from rail_cosim.sweeps.specification import SweepSpecification
from rail_cosim.window import WindowChoice

FORMAT = 2
"""Raised when the same task would give another result: old stores are then not read."""

_DATE = re.compile(rb'generationDateAndTime="[^"]*"')


@dataclasses.dataclass(frozen=True, kw_only=True)
class FmuFile:
    """An FMU, known by its content: its file's name, and a hash of all but the build date.

    ``renamings`` are its variables that have other names in the contract.
    """

    name: str
    identity: str
    renamings: tuple[Renaming, ...] = ()

    @property
    def key(self) -> object:
        """What the result depends on."""
        renamings = [dataclasses.astuple(one) for one in self.renamings]
        return [self.identity, renamings] if renamings else self.identity


@dataclasses.dataclass(frozen=True, kw_only=True)
class Task:
    """One point of a sweep.

    Attributes
    ----------
    options
        Of the run; parameters and FMUs are taken from the fields below.
    parameters
        All values to set, by FMU and name, checked.
    fmus
        The FMUs, by ``track`` and ``vehicle``.
    keep, window, history, history_every
        As in :class:`SweepSpecification`.
    """

    options: RunOptions
    parameters: Mapping[str, Mapping[str, Value]]
    fmus: Mapping[str, FmuFile]
    keep: Mapping[str, Sequence[str]]
    history: Sequence[str]
    history_every: int
    window: WindowChoice | None = None

    @functools.cached_property
    def key(self) -> str:
        """Hash of all that the result depends on."""
        options = self.options
        content = {
            "format": FORMAT,
            "fmus": {name: file.key for name, file in self.fmus.items()},
            "parameters": {
                owner: {name: _fingerprint(value) for name, value in sorted(values.items())}
                for owner, values in self.parameters.items()
            },
            "distance": options.distance,
            "until_steady": options.until_steady,
            "macro_step": options.macro_step,
            "algorithm": options.algorithm,
            "record_every": options.record_every,
            "keep": {name: list(statistics) for name, statistics in self.keep.items()},
            "window": None if self.window is None else dataclasses.asdict(self.window),
            "history": [*self.history, self.history_every],
        }
        if options.final_speed is not None:  # only then: keys of other runs stay as they are
            content["final_speed"] = options.final_speed
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plan:
    """All tasks of a sweep, in the order of its points.

    Attributes
    ----------
    specification
        What was asked for.
    tasks
        One for each point.
    files
        The FMUs' paths by identity.
    about
        Unit and meaning of each axis.
    """

    specification: SweepSpecification
    tasks: Sequence[Task]
    files: Mapping[str, Path]
    about: Mapping[str, tuple[str, str]]


def make_plan(specification: SweepSpecification) -> Plan:
    """Return the tasks of a sweep.

    Raises
    ------
    RailCosimError
        If a name or value is wrong at any point, as far as the FMUs' descriptions tell.
    """
    found: dict[tuple, _Found] = {}
    tasks: list[Task] = []
    for point in specification.all_points():
        options = specification.options(point)
        maps = (options.vehicle_map, options.track_map)
        which = (options.line, options.vehicle, options.track, *maps)
        if which not in found:
            found[which] = _find(options)
            _check_variables(specification, found[which].descriptions)
        fmus = found[which]
        task = Task(
            options=options,
            parameters=gather_parameters(options, fmus.descriptions, fmus.presets),
            fmus=fmus.files,
            keep=specification.keep,
            window=specification.window_choice,
            history=specification.history,
            history_every=specification.history_every,
        )
        tasks.append(task)
    files = {
        file.identity: fmus.descriptions[name].path
        for fmus in found.values()
        for name, file in fmus.files.items()
    }
    some = next(iter(found.values()))
    about = {axis: _about(axis, some.descriptions) for axis in specification.axes}
    return Plan(specification=specification, tasks=tasks, files=files, about=about)


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Found:
    descriptions: Mapping[str, FmuDescription]
    presets: Mapping[str, str]
    files: Mapping[str, FmuFile]


def _find(options: RunOptions) -> _Found:
    descriptions, presets = find_fmus(options)
    files = {
        name: FmuFile(
            name=about.path.name,
            identity=identity(about.path),
            renamings=tuple(v.renaming for v in about.variables.values() if v.renaming),
        )
        for name, about in descriptions.items()
    }
    return _Found(descriptions=descriptions, presets=presets, files=files)


def identity(path: Path) -> str:
    """Return a hash of an FMU's content; the same for a rebuild from the same sources."""
    digest = hashlib.sha256()
    with opened(path) as archive:
        for name in sorted(archive.namelist()):
            content = read_member(archive, name, LARGEST)
            if name == "modelDescription.xml":
                content = _DATE.sub(b"", content, count=1)
            digest.update(f"{name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:32]


def _fingerprint(value: Value) -> Value:
    """Return what a parameter's value stands for: of a file its content."""
    if isinstance(value, str) and value and Path(value).is_file():
        return "file " + hashlib.sha256(Path(value).read_bytes()).hexdigest()
    return value


def _check_variables(
    specification: SweepSpecification, descriptions: Mapping[str, FmuDescription]
) -> None:
    """Refuse what runs will not have before the first of them.

    Raises
    ------
    UnknownNameError
        For a variable to keep that is no output.
    """
    known = variable_names(descriptions.values())
    for option, names in (("keep", specification.keep), ("history", specification.history)):
        for name in names:
            if name not in known:
                raise UnknownNameError(option, name, known, "variable in a run", name)


_OPTIONS = {
    "speed": ("km/h", "running speed"),
    "final_speed": ("km/h", "speed at the end of the distance"),
    "distance": ("m", "largest distance travelled"),
    "until_steady": ("1", "largest relative change from slab to slab"),
    "macro_step": ("s", "largest communication step"),
    "line": ("1", "parameter set of the track"),
    "vehicle": ("1", "parameter set or FMU of the vehicle"),
    "track": ("1", "FMU of the track"),
}


def _about(axis: str, descriptions: Mapping[str, FmuDescription]) -> tuple[str, str]:
    """Return unit and meaning of an axis."""
    owner, dot, name = axis.partition(".")
    if not dot:
        return _OPTIONS.get(axis, ("1", axis.replace("_", " ")))
    variable = descriptions[owner].variables[name]
    return variable.unit or "1", variable.description
