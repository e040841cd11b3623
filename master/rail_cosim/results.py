"""Records as an xarray Dataset, and the Dataset as a NetCDF file."""

from __future__ import annotations

import dataclasses
import errno
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import xarray as xr

from rail_cosim.description import FmuDescription
from rail_cosim.errors import ResultsError
from rail_cosim.recorded import ALWAYS, chosen
from rail_cosim.recorder import Recorder
from rail_cosim.system import SystemStructure

SIDES = ("left", "right")
# What is counted together with what: one axle box and one primary suspension
# per wheelset and side, one secondary suspension per bogie and side.
_DIMENSION = {
    "axle_box": "wheelset",
    "primary_suspension": "wheelset",
    "rail_head": "wheelset",
    "secondary_suspension": "bogie",
    "yaw_damper": "bogie",
    "lateral_damper": "bogie",
    "lateral_bump_stop": "bogie",
    "anti_roll_bar": "bogie",
    "car_body_floor": "floor_place",
}
_INDEXED = re.compile(
    r"^(?P<group>\w+)\[(?P<index>\d+)\]\.(?:(?P<side>left|right)\.)?(?P<rest>.+)$"
)
_PART = 32768
"""Records in memory at a time while a long run is written."""
_SPARE = 2**20  # bytes
LEADING_POSITION = "wheelset[1].longitudinal_position"


@dataclasses.dataclass(frozen=True, slots=True)
class Place:
    """Where an output goes: a variable's name, its dimensions after time, the indices there."""

    variable: str
    dimensions: tuple[str, ...]
    indices: tuple[int, ...]


def place(name: str) -> Place:
    """Return where the output ``name`` of a slave goes in the Dataset.

    ``wheelset[2].left.normal_force`` is ``normal_force(time, wheelset, side)``,
    ``axle_box[2].left.vertical_acceleration`` is
    ``axle_box_vertical_acceleration(time, wheelset, side)``,
    ``bogie[1].vertical_acceleration`` is ``bogie_vertical_acceleration(time, bogie)``,
    ``window.slide_count`` is ``window_slide_count(time)``.
    """
    match = _INDEXED.match(name)
    if match is None:
        return Place(_plain(name), (), ())
    group, side, rest = match["group"], match["side"], _plain(match["rest"])
    dimension, index = _DIMENSION.get(group, group), int(match["index"]) - 1
    if side is None:
        return Place(f"{group}_{rest}", (dimension,), (index,))
    # A wheel's quantities go without the word: there is no other thing of a wheelset's side.
    variable = rest if group == "wheelset" else f"{group}_{rest}"
    return Place(variable, (dimension, "side"), (index, SIDES.index(side)))


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name).strip("_")


def variable_names(descriptions: Iterable[FmuDescription]) -> list[str]:
    """Return the names of the variables that a run of these FMUs records."""
    outputs = [
        place(variable.name).variable
        for about in descriptions
        for variable in about.variables.values()
        if variable.causality == "output"
    ]
    return list(dict.fromkeys([*outputs, ALWAYS]))


def to_dataset(
    system: SystemStructure,
    recorder: Recorder,
    attributes: Mapping[str, Any],
    *,
    start: int = 0,
    stop: int | None = None,
    variables: Sequence[str] = (),
) -> xr.Dataset:
    """Return what was recorded as a Dataset, in memory.

    Parameters
    ----------
    system
        The slaves; their descriptions give units and meanings.
    recorder
        The records.
    attributes
        Attributes of the Dataset; truth values become 0 and 1.
    start, stop
        Which records; all by default.
    variables
        Which variables (:func:`rail_cosim.recorded.chosen`); all by default.
    """
    rows = recorder.rows(start, len(recorder) if stop is None else stop)
    # All at once: a Dataset that grows by one variable is merged anew each time.
    found: dict[str, xr.Variable] = {}
    seen: set[str] = set()
    in_use = _wheelsets_in_use(system)
    for slave in system.slaves:
        names, values = recorder.names(slave.name), rows[:, recorder.columns(slave.name)]
        for variable, members in _group(names, in_use).items():
            key = f"{variable}_{slave.name}" if variable in seen else variable
            seen.add(variable)
            if not chosen(key, variables):
                continue
            about = slave.variables[names[members[0][0]]]
            array = _variable(values, members, about.unit, about.description)
            whole = about.kind == "integer" and not np.isnan(array.to_numpy()).any()
            found[key] = array.astype(np.int32) if whole else array
        if LEADING_POSITION in names and "distance" not in found:
            column = names.index(LEADING_POSITION)
            origin = recorder.rows(0, 1)[:, recorder.columns(slave.name)][:, column].sum()
            meaning = "distance travelled by the leading wheelset"
            about = {"units": "m", "long_name": meaning}
            found["distance"] = xr.Variable("time", values[:, column] - origin, about)
    times = xr.Variable("time", rows[:, 0], {"units": "s", "long_name": "time"})
    dataset = xr.Dataset(found, coords={"time": times})
    return _with_coordinates(
        dataset.assign_attrs({k: _attribute(v) for k, v in attributes.items()})
    )


def _wheelsets_in_use(system: SystemStructure) -> float:
    """Return the number of terminals that are connected; a track may have more of them."""
    places = [place(c.name) for c in system.connections]
    used = [w.indices[0] + 1 for w in places if w.dimensions[:1] == ("wheelset",)]
    return max(used, default=math.inf)


def _group(names: tuple[str, ...], in_use: float) -> dict[str, list[tuple[int, Place]]]:
    groups: dict[str, list[tuple[int, Place]]] = {}
    for column, name in enumerate(names):
        where = place(name)
        if where.dimensions[:1] != ("wheelset",) or where.indices[0] < in_use:
            groups.setdefault(where.variable, []).append((column, where))
    return groups


def _variable(
    values: np.ndarray, members: list[tuple[int, Place]], unit: str, meaning: str
) -> xr.Variable:
    dimensions = members[0][1].dimensions
    counts = [max(where.indices[i] for _, where in members) + 1 for i in range(len(dimensions))]
    if "side" in dimensions:
        counts[dimensions.index("side")] = len(SIDES)
    data = np.full((len(values), *counts), np.nan)
    for column, where in members:
        data[(slice(None), *where.indices)] = values[:, column]
    about = {"units": unit or "1", "long_name": _general(meaning)}
    return xr.Variable(("time", *dimensions), data, about)


def _general(meaning: str) -> str:
    """Take the place out of a description that was made for one wheelset or wheel."""
    return re.sub(r" (wheelset|bogie|axle box|wheel) \d+\b", r" the \1", meaning)


def _with_coordinates(dataset: xr.Dataset) -> xr.Dataset:
    coordinates: dict[str, Any] = {}
    for dimension, size in dataset.sizes.items():
        if dimension == "side":
            coordinates["side"] = list(SIDES)
        elif dimension != "time":
            text = f"number of the {dimension}, counted from the leading end"
            number = np.arange(1, size + 1, dtype=np.int32)
            coordinates[str(dimension)] = (dimension, number, {"long_name": text})
    return dataset.assign_coords(coordinates)


def _attribute(value: Any) -> Any:
    """Return a value in a type that NetCDF attributes have."""
    return np.int8(value) if isinstance(value, bool) else value


def write_netcdf(dataset: xr.Dataset, path: Path) -> Path:
    """Write a Dataset to ``path``: the whole file or nothing.

    If the place cannot be written to, the file is saved in the temporary
    directory, so that a long run is not lost.

    Raises
    ------
    ResultsError
        If it could not be written at ``path``; says where it is instead.
    """
    return _written(
        path, dataset.nbytes, lambda scratch: dataset.to_netcdf(scratch, engine="h5netcdf")
    )


def stream_netcdf(
    system: SystemStructure,
    recorder: Recorder,
    attributes: Mapping[str, Any],
    path: Path,
    variables: Sequence[str] = (),
) -> Path:
    """Write what was recorded to ``path`` part by part, in memory that does not depend on length.

    Same content as :func:`write_netcdf` of :func:`to_dataset`; same errors.
    """

    def write(scratch: Path) -> None:
        end = len(recorder)
        stop = min(_PART, end)
        first = to_dataset(system, recorder, attributes, stop=stop, variables=variables)
        first.to_netcdf(scratch, engine="h5netcdf", unlimited_dims=["time"])
        with h5netcdf.File(scratch, "a") as file:
            file.resize_dimension("time", end)
            for start in range(_PART, end, _PART):
                stop = min(start + _PART, end)
                part = to_dataset(system, recorder, {}, start=start, stop=stop, variables=variables)
                for name, values in part.variables.items():
                    if "time" in values.dims:
                        file.variables[str(name)][start:stop] = values.to_numpy()

    return _written(path, len(recorder) * recorder.width * 8, write)


def _written(path: Path, size: int, write: Callable[[Path], object]) -> Path:
    try:
        _replaced(path, size, write)
    except OSError as error:
        rescue = Path(tempfile.gettempdir()) / f"{path.stem}-{os.getpid()}.nc"
        try:
            _replaced(rescue, size, write)
        except OSError as second:
            raise ResultsError(
                f"{path}: the results could not be written ({error}), nor to {rescue} ({second})"
            ) from error
        raise ResultsError(
            f"{path}: the results could not be written there ({error}); they are in {rescue}"
        ) from error
    return path


def _replaced(path: Path, size: int, write: Callable[[Path], object]) -> None:
    # HDF5 crashes the process later if there is no room for what it has begun.
    if shutil.disk_usage(path.parent).free < 1.1 * size + _SPARE:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    scratch = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        write(scratch)
        os.replace(scratch, path)
    finally:
        scratch.unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Make sure before a run that a file can be written at ``path`` after it; make its folder.

    Raises
    ------
    ResultsError
        If it cannot, with the reason.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a directory")
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written ({error.strerror or error})") from error


def check_netcdf(path: Path) -> None:
    """Make sure before a run that NetCDF can be written at ``path``: the libraries are there too.

    Raises
    ------
    ResultsError
        If it cannot, with the reason.
    """
    check_writable(path)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent) as scratch:
            xr.Dataset(attrs={"test": 1}).to_netcdf(Path(scratch, "test.nc"), engine="h5netcdf")
    except (ImportError, ValueError) as error:
        raise ResultsError(
            f"{path}: NetCDF cannot be written ({error}); install h5netcdf and h5py"
        ) from error
