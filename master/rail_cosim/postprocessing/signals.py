"""What all evaluations share: the records' time step, and functions applied along time."""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

from collections.abc import Callable, Hashable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError

Array = NDArray[np.float64]
FEWEST = 8
_UNEVEN = 1e-6


def time_step(array: xr.DataArray | xr.Dataset) -> float:
    """Return the time between records in s.

    Parameters
    ----------
    array
        With the coordinate ``time`` in s.

    Raises
    ------
    ParameterError
        If there are fewer than 8 records, or if they are not equidistant.
    """
    if "time" not in array.dims or array.sizes["time"] < FEWEST:
        limit = f"an evaluation over time needs the dimension time with {FEWEST} records or more"
        raise ParameterError("records", array.sizes.get("time", 0), limit)
    time = array["time"].to_numpy().astype(float)
    step = float((time[-1] - time[0]) / (len(time) - 1))
    deviation = np.abs(np.diff(time) - step).max()
    # Not a number must fail too.
    if not (step > 0.0 and deviation <= _UNEVEN * abs(step) * len(time)):
        limit = "the records must be equidistant in time"
        raise ParameterError("time", float(deviation), limit, "resample them first")
    return step


def sampling_rate(array: xr.DataArray | xr.Dataset) -> float:
    """Return the records per second in Hz (errors as in :func:`time_step`)."""
    return 1.0 / time_step(array)


def along_time(
    function: Callable[[Array], Array], array: xr.DataArray, **attributes: str
) -> xr.DataArray:
    """Return ``function(values)`` with ``values`` (time, ...) as an array like ``array``."""
    ordered = array.transpose("time", ...)
    found = ordered.copy(data=function(ordered.to_numpy().astype(float)))
    found.attrs.update(attributes)
    return found.transpose(*array.dims)


def to_lines(
    function: Callable[[Array], Array],
    array: xr.DataArray,
    dimension: str,
    coordinate: xr.Variable,
    **attributes: str,
) -> xr.DataArray:
    """Return ``function(values)``, which makes of (time, ...) an array (``dimension``, ...)."""
    ordered = array.transpose("time", ...)
    others: list[Hashable] = [d for d in ordered.dims if d != "time"]
    coordinates = {d: array[d] for d in others if d in array.coords}
    return xr.DataArray(
        function(ordered.to_numpy().astype(float)),
        dims=[dimension, *others],
        coords={**coordinates, dimension: coordinate},
        attrs={**array.attrs, **attributes},
        name=array.name,
    )


def squared_unit(array: xr.DataArray, per: str = "") -> str:
    """Return the unit of the array's square, divided by ``per``."""
    unit = str(array.attrs.get("units", "1"))
    square = "1" if unit == "1" else f"({unit})2"
    return f"{square}/{per}" if per else square
