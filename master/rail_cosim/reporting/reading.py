"""Open a file that is to be reported, and say what it is if it is no run."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from rail_cosim.errors import RailCosimError

_FEWEST = 8


class ReportError(RailCosimError):
    """A file or data set is no run that can be reported."""

    exit_status = 2


def open_run(path: Path) -> xr.Dataset:
    """Return the run in a NetCDF file; closes the file.

    Raises
    ------
    ReportError
        If there is no such file, or it is no NetCDF, or something else than a run.
    """
    if not path.is_file():
        what = "it is a directory" if path.is_dir() else "there is no such file"
        raise ReportError(f"{path}: cannot be read ({what})")
    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            loaded = dataset.load()
    except Exception as error:  # the readers of NetCDF raise nothing more exact
        raise ReportError(
            f"{path}: is no NetCDF file that can be read ({_short(error)}); give one that "
            "rail-cosim run --out wrote"
        ) from error
    check_run(loaded, str(path))
    return loaded


def check_run(dataset: xr.Dataset, name: str) -> None:
    """Make sure that a data set is that of a run.

    Raises
    ------
    ReportError
        If it is not, with what it is.
    """
    if "time" not in dataset.dims:
        if "error" in dataset:
            raise ReportError(
                f"{name}: is the result of a sweep, not of a run; it has one value per point "
                "(open it with xarray, or run one of its points with rail-cosim run --out)"
            )
        raise ReportError(
            f"{name}: has no dimension time, so it is not the result of a run; give a file that "
            "rail-cosim run --out wrote"
        )
    count = dataset.sizes["time"]
    if count < _FEWEST:
        raise ReportError(
            f"{name}: has {count} records, too few to say anything ({_FEWEST} are needed); "
            "run a longer distance"
        )


def _short(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
