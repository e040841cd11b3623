"""Open the files that are to be reported, and say what they are if they are not runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from rail_cosim.errors import RailCosimError

_FEWEST = 8
MOST_RECORDS = 3_000_000
"""Records up to which a whole run is read: 25 km at 300 km/h, some 3 GB of memory."""

_SHOWN = (
    "distance",
    "normal_force",
    "vertical_wheel_force",
    "guiding_force",
    "axle_box_vertical_acceleration",
    "rail_vertical_displacement",
    "bogie_vertical_acceleration",
    "bogie_lateral_acceleration",
    "car_body_vertical_acceleration",
    "car_body_lateral_acceleration",
    "car_body_floor_vertical_acceleration",
    "car_body_floor_lateral_acceleration",
    "wheelset_longitudinal_position",
    "window_start_position",
    "window_slide_count",
    "window_slide_residual",
)


def labels(paths: Sequence[Path]) -> list[str]:
    """Return a short label for each file, no two alike: as much of its path as tells them apart."""
    parts = [path.resolve().with_suffix("").parts for path in paths]
    found: list[str] = []
    for own in parts:
        others = [one for one in parts if one != own]
        size = 1
        while any(one[-size:] == own[-size:] for one in others):
            size += 1
        name = "/".join(own[-size:])
        again = found.count(name) + sum(one.startswith(f"{name} (") for one in found)
        found.append(f"{name} ({again + 1})" if again else name)
    return found


class ReportError(RailCosimError):
    """A file or data set is not a run that can be reported."""

    exit_status = 2


def open_run(path: Path) -> xr.Dataset:
    """Return what the page shows of the run in a NetCDF file; closes the file.

    Raises
    ------
    ReportError
        If there is no such file, or it is no NetCDF, or something else than a run.
    """
    with open_dataset(path) as dataset:
        check_size(dataset, str(path))
        return dataset[[name for name in _SHOWN if name in dataset]].load()


def open_dataset(path: Path) -> xr.Dataset:
    """Return the run in a NetCDF file, whose data are read when they are used.

    Raises
    ------
    ReportError
        If there is no such file, or it is not NetCDF, or something else than a run.
    """
    if not path.is_file():
        what = "it is a directory" if path.is_dir() else "there is no such file"
        raise ReportError(f"{path}: cannot be read ({what})")
    try:
        dataset = xr.open_dataset(path, engine="h5netcdf")
    except Exception as error:  # the readers of NetCDF raise nothing more exact
        raise ReportError(
            f"{path}: is not a NetCDF file that can be read ({_short(error)}); give one that "
            "rail-cosim run --out wrote"
        ) from error
    try:
        check_run(dataset, str(path))
    except ReportError:
        dataset.close()
        raise
    return dataset


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


def check_size(dataset: xr.Dataset, name: str) -> None:
    """Make sure that a run is not too long to be shown at once.

    Raises
    ------
    ReportError
        If it is.
    """
    count = dataset.sizes["time"]
    if count > MOST_RECORDS:
        raise ReportError(
            f"{name}: has {count} records, more than {MOST_RECORDS} are not shown at once; report "
            "a part in Python: rail_cosim.report(dataset.isel(time=slice(...)), 'part.html')"
        )


def _short(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
