"""Reading of measured irregularities: CSV, classic NetCDF (3) and NetCDF 4.

The kind of file is told from its first bytes, not from its name. Columns (CSV)
or one-dimensional variables (NetCDF) are ``distance`` and any of
:data:`COLUMNS`; units are metres unless the header says ``[mm]`` (``[km]`` for
the distance) or the variable's ``units`` attribute does.
"""

import csv
import dataclasses
import io
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rail_quantities import ParameterError, nearest
from scipy.io import netcdf_file

from slab_track.irregularity.spectra import CHANNELS, FloatArray

RAIL_COLUMNS = ("left_vertical", "left_lateral", "right_vertical", "right_lateral")
"""The rails' irregularities, in the flattened order of (side, direction)."""
COLUMNS = (*RAIL_COLUMNS, *CHANNELS)
_DISTANCE = "distance"
_EITHER_OR = (
    ({"left_vertical", "right_vertical"}, {"level", "cross_level"}),
    ({"left_lateral", "right_lateral"}, {"alignment", "gauge"}),
)
_UNITS = {"": 1.0, "m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0}
_DISTANCE_UNITS = {**_UNITS, "km": 1e3}
_VALUE_UNITS = {**_UNITS, "mm": 1e-3}
_HEADER = re.compile(r"^(?P<name>[^\[\](]*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?$")
_LARGEST = 0.1
_LONGEST_QUOTE = 300
_MOST_ROWS = 20_000_000


class IrregularityFileError(ParameterError):
    """The file of ``irregularity.file.path`` cannot be used."""

    def __init__(self, path: str, limit: str, remedy: str = "") -> None:
        if len(limit) > _LONGEST_QUOTE:  # what is quoted may be no text at all
            limit = limit[:_LONGEST_QUOTE] + "..."
        super().__init__("irregularity.file.path", path, limit, remedy)


def read_file(path: str) -> dict[str, FloatArray]:
    """Return the columns of a file, in metres: ``distance`` and some of :data:`COLUMNS`.

    Raises
    ------
    IrregularityFileError
        If the file is missing or unreadable, its columns are unknown, contradict
        each other or are of different length, a value is not finite or too large to
        be in metres, or the distance does not increase from row to row.
    """
    try:
        with Path(path).open("rb") as stream:
            start = stream.read(8)
    except (OSError, ValueError) as error:
        raise IrregularityFileError(
            path,
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            "a relative path counts from the working "
            "directory of the simulation tool: give the full path",
        ) from error
    if start[:4] in (b"CDF\x01", b"CDF\x02"):
        columns = _undamaged(_read_classic, path)
    elif start == b"\x89HDF\r\n\x1a\n":
        columns = _undamaged(_read_hdf5, path)
    elif start[:3] == b"CDF":
        raise IrregularityFileError(
            path, "is NetCDF in the CDF-5 variant", "write it as classic NetCDF 3 or as CSV"
        )
    else:
        columns = _read_csv(path)
    _check(path, columns)
    return columns


def _undamaged(read: Callable[[str], dict[str, FloatArray]], path: str) -> dict[str, FloatArray]:
    """Read NetCDF; the libraries answer damage with errors of any kind."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(path)
    except IrregularityFileError:
        raise
    except MemoryError as error:
        raise IrregularityFileError(path, "is damaged: it claims to be huge") from error
    except Exception as error:
        limit = f"is damaged NetCDF ({type(error).__name__}: {error})"
        raise IrregularityFileError(path, limit, "write it again") from error


def _read_csv(path: str) -> dict[str, FloatArray]:
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise IrregularityFileError(
            path, "is neither CSV text (UTF-8) nor NetCDF", "export it as CSV"
        ) from error
    lines = text.splitlines()
    first = next((i for i, line in enumerate(lines) if _has_content(line)), None)
    if first is None:
        raise IrregularityFileError(path, "is empty", "it needs a header line and rows")
    delimiter = next((mark for mark in ";\t" if mark in lines[first]), ",")
    header = [cell.strip() for cell in next(csv.reader([lines[first]], delimiter=delimiter))]
    names, scales = _read_header(path, header)
    if not any(_has_content(line) for line in lines[first + 1 :]):
        raise IrregularityFileError(path, "has no rows below its header")
    try:
        rows = np.loadtxt(io.StringIO(text), delimiter=delimiter, skiprows=first + 1, ndmin=2)
    except ValueError:
        raise _find_bad_line(path, lines, first, len(names), delimiter) from None
    if rows.shape[1] != len(names):
        raise _find_bad_line(path, lines, first, len(names), delimiter)
    return {name: rows[:, i] * scales[i] for i, name in enumerate(names)}


def _has_content(line: str) -> bool:
    return bool(line.split("#", 1)[0].strip())


def _read_header(path: str, header: list[str]) -> tuple[list[str], list[float]]:
    """Return names and factors to metres of a CSV header."""
    names, scales = [], []
    for cell in header:
        match = _HEADER.match(cell)
        if match is None:
            raise IrregularityFileError(path, f"has the column heading {cell!r}", _expected())
        name = match["name"].strip()
        _check_names(path, [name])
        names.append(name)
        scales.append(_scale(path, name, match["unit"] or ""))
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise IrregularityFileError(path, f"has the column {doubled[0]!r} twice")
    return names, scales


def _find_bad_line(
    path: str, lines: list[str], first: int, count: int, delimiter: str
) -> IrregularityFileError:
    """Return the error for the first line that does not hold ``count`` numbers."""
    for number, line in enumerate(lines[first + 1 :], start=first + 2):
        cells = line.split("#", 1)[0].split(delimiter)
        if not _has_content(line):
            continue
        if len(cells) != count:
            return IrregularityFileError(
                path, f"line {number} has {len(cells)} cells where the header has {count}"
            )
        for cell in cells:
            try:
                float(cell)
            except ValueError:
                return IrregularityFileError(
                    path, f"line {number}: {cell.strip()!r} is no number", "use a decimal point"
                )
    return IrregularityFileError(path, "cannot be read as rows of numbers")


def _read_classic(path: str) -> dict[str, FloatArray]:
    with netcdf_file(path, "r", mmap=False) as dataset:
        found = {
            name: _Variable(
                raw=np.array(variable.data),
                attributes={key: getattr(variable, key, None) for key in _ATTRIBUTES},
            )
            for name, variable in dataset.variables.items()
        }
    return _select(path, found)


def _read_hdf5(path: str) -> dict[str, FloatArray]:
    try:
        import h5py  # here, because only NetCDF 4 needs it
    except ImportError as error:
        raise IrregularityFileError(
            path,
            "is NetCDF 4 (HDF5), which needs the Python package h5py",
            "install h5py, or write the file as classic NetCDF (xarray: "
            "to_netcdf(..., format='NETCDF3_64BIT')) or as CSV",
        ) from error
    with h5py.File(path, "r") as dataset:
        found = {
            name: _Variable(
                raw=np.array(variable),
                attributes={key: variable.attrs.get(key) for key in _ATTRIBUTES},
            )
            for name, variable in dataset.items()
            if isinstance(variable, h5py.Dataset) and variable.dtype.kind in "iuf"
        }
    return _select(path, found)


_ATTRIBUTES = ("units", "scale_factor", "add_offset", "_FillValue", "missing_value")


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Variable:
    """A NetCDF variable: raw values and the attributes that matter."""

    raw: np.ndarray
    attributes: Mapping[str, Any]

    @property
    def is_column(self) -> bool:
        return self.raw.ndim == 1 and self.raw.dtype.kind in "iuf"

    @property
    def unit(self) -> str:
        unit = self.attributes["units"]
        return unit.decode() if isinstance(unit, bytes) else str(unit or "")

    def values(self) -> FloatArray:
        """Return the unpacked values, missing ones as not a number."""
        values = self.raw.astype(float)
        for key in ("_FillValue", "missing_value"):
            if (fill := self.attributes[key]) is not None:
                values[self.raw == np.ravel(fill)[0]] = np.nan
        for key, apply in (("scale_factor", np.multiply), ("add_offset", np.add)):
            if (number := self.attributes[key]) is not None:
                values = apply(values, float(np.ravel(number)[0]))
        return values


def _select(path: str, found: dict[str, _Variable]) -> dict[str, FloatArray]:
    """Return the one-dimensional variables, in metres."""
    columns = {name: variable for name, variable in found.items() if variable.is_column}
    _check_names(path, columns)
    return {
        name: variable.values() * _scale(path, name, variable.unit)
        for name, variable in columns.items()
    }


def _expected() -> str:
    return f"expected are {_DISTANCE} and any of " + ", ".join(COLUMNS)


def _check_names(path: str, names: Iterable[str]) -> None:
    for name in names:
        if name != _DISTANCE and name not in COLUMNS:
            close = nearest(name, (_DISTANCE, *COLUMNS), 1)
            remedy = f"did you mean {close[0]!r}? " if close else ""
            raise IrregularityFileError(
                path, f"has the unknown column {name!r}", remedy + _expected()
            )


def _scale(path: str, name: str, unit: str) -> float:
    units = _DISTANCE_UNITS if name == _DISTANCE else _VALUE_UNITS
    if unit.strip() not in units:
        known = "m or km" if name == _DISTANCE else "m or mm"
        raise IrregularityFileError(path, f"has {name!r} in {unit!r}", f"use {known}")
    return units[unit.strip()]


def _check(path: str, columns: dict[str, FloatArray]) -> None:
    if _DISTANCE not in columns or len(columns) < 2:
        missing = _DISTANCE if _DISTANCE not in columns else "irregularity"
        raise IrregularityFileError(path, f"has no column of {missing}", _expected())
    for first, second in _EITHER_OR:
        if first & columns.keys() and second & columns.keys():
            both = sorted((first | second) & columns.keys())
            raise IrregularityFileError(
                path,
                "gives one direction twice: " + ", ".join(both),
                "give either the two rails or their mean and difference",
            )
    distance = columns[_DISTANCE]
    if not 2 <= len(distance) <= _MOST_ROWS:
        raise IrregularityFileError(
            path, f"has {len(distance)} rows; possible are 2 to {_MOST_ROWS}"
        )
    for name, values in columns.items():
        _check_values(path, name, values, len(distance))
    falling = np.flatnonzero(~(np.diff(distance) > 0))
    if falling.size:
        k = falling[0]
        raise IrregularityFileError(
            path,
            f"row {k + 2}: distance {distance[k + 1]:g} m follows {distance[k]:g} m",
            "the distance must increase from row to row: sort the rows, remove doubled ones",
        )


def _check_values(path: str, name: str, values: FloatArray, count: int) -> None:
    if len(values) != count:
        raise IrregularityFileError(
            path, f"has {len(values)} values of {name!r} for {count} distances"
        )
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise IrregularityFileError(
            path, f"row {bad[0] + 1}: {name} is not a finite number", "interpolate gaps beforehand"
        )
    if name != _DISTANCE and np.max(np.abs(values)) > _LARGEST:
        row = int(np.argmax(np.abs(values)))
        raise IrregularityFileError(
            path,
            f"row {row + 1}: {name} is {values[row]:g} m, more than {_LARGEST:g} m",
            "values count as metres unless the heading says [mm]",
        )
