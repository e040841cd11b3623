"""Finished points on disk: a file each, so that a sweep that was stopped resumes."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import xarray as xr

from rail_cosim.errors import ResultsError
from rail_cosim.sweeps.point import PointResult

_ERROR, _REMARKS = "error", "remarks"
_SEPARATOR = "\x1e"
_ENGINE, _MAGIC = "scipy", b"CDF"
"""NetCDF 3: written and read in 5 ms where HDF5 takes 90."""


class Store:
    """A folder with one NetCDF file per point, named by the task's key.

    A file appears whole or not at all. Two sweeps may share a folder: what both need
    is run once, unless they run at the same time.

    Raises
    ------
    ResultsError
        If the folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ResultsError(f"{folder}: cannot be made ({error.strerror})") from error

    def path(self, key: str) -> Path:
        """Return where the point with this key is, or would be."""
        return self.folder / f"{key}.nc"

    def load(self, key: str) -> PointResult | None:
        """Return a finished point, ``None`` if there is none that can be read."""
        path = self.path(key)
        if not path.is_file():
            return None
        try:
            with path.open("rb") as file:
                engine = _ENGINE if file.read(len(_MAGIC)) == _MAGIC else "h5netcdf"
            with xr.open_dataset(path, engine=engine) as file:
                data = file.load()
        except (OSError, ValueError, KeyError):
            return None  # not ours, or damaged: it is run again and replaced
        error, remarks = data.attrs.pop(_ERROR, ""), data.attrs.pop(_REMARKS, "")
        return PointResult(
            data=data, error=error, remarks=tuple(remarks.split(_SEPARATOR)) if remarks else ()
        )

    def save(self, key: str, result: PointResult) -> None:
        """Keep a finished point.

        Raises
        ------
        ResultsError
            If it cannot be written.
        """
        about = {_ERROR: result.error, _REMARKS: _SEPARATOR.join(result.remarks)}
        scratch = self.folder / f".{key}.{os.getpid()}.part"
        try:
            result.data.assign_attrs(about).to_netcdf(scratch, engine=_ENGINE)
            os.replace(scratch, self.path(key))
        except OSError as error:
            raise ResultsError(f"{self.path(key)}: cannot be written ({error})") from error
        finally:
            with contextlib.suppress(OSError):
                scratch.unlink()
