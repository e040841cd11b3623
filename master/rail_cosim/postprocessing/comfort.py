r"""Ride comfort from accelerations at the floor of the car body.

Weighted root mean square (ISO 2631-1): :math:`a_w = \sqrt{\overline{a_w^2(t)}}`.

EN 12299 takes it over blocks of 5 s, :math:`C_{Cx}, C_{Cy}` with Wd and :math:`C_{Cz}` with Wb:
continuous comfort. From their 95th percentiles, over 5 minutes, is the mean comfort

.. math:: N_{MV} = 6\sqrt{(a^{Wd}_{XP95})^2+(a^{Wd}_{YP95})^2+(a^{Wb}_{ZP95})^2}.

Sperling's ride index is, for one sine of amplitude :math:`a` in cm/s2,
:math:`W_z = \sqrt[10]{a^3 B^3(f)}`, and for any motion, with the root mean square of the
acceleration weighted by B in m/s2,

.. math:: W_z = 4.42\,(a_{w})^{0.3}:

the factor is :math:`(100\sqrt2)^{0.3}`. It does not depend on the length of the record, as sums of
cubes over spectral lines do. The older tables give for a sine
:math:`W_z = 0.896 \sqrt[10]{a^3 F(f)/f}` with piecewise F(f): see :func:`sperling_of_sine`.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

import numpy as np
import xarray as xr

from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing.signals import time_step
from rail_cosim.postprocessing.weighting import weighted

BLOCK = 5.0
"""Length of a block of EN 12299, s."""

BLOCKS = 60
"""Blocks that EN 12299 requires for the mean comfort: 5 minutes."""

SETTLING = 5.0
"""Time at the start of a run that is left to its transient, s: the first block."""

_SPERLING_FACTOR = (100.0 * np.sqrt(2.0)) ** 0.3


def weighted_rms(acceleration: xr.DataArray, name: str, *, start: float = 0.0) -> xr.DataArray:
    """Return the root mean square of a weighted acceleration.

    Parameters
    ----------
    acceleration
        In m/s2; dimensions ``time`` and any others.
    name
        Of the weighting, see :func:`rail_cosim.postprocessing.weighted`.
    start
        Time in s from which on it counts, so that the transient at the start of a run does not
        (:data:`SETTLING`); what is before goes through the filter only.

    Returns
    -------
    xarray.DataArray
        Without ``time``, in m/s2.
    """
    chosen = _from(weighted(acceleration, name), start)
    found = (chosen**2).mean("time") ** 0.5
    return found.assign_attrs(units="m/s2", weighting=name, evaluated_over=_window(chosen))


def _from(array: xr.DataArray, start: float) -> xr.DataArray:
    found = array.isel(time=array["time"].to_numpy() >= start)
    if found.sizes["time"] == 0:
        raise ParameterError("start", start, "must be before the end of the record")
    return found


def _window(array: xr.DataArray) -> str:
    time = array["time"].to_numpy()
    return f"{time[0]:.6g} to {time[-1]:.6g} s" if time.size else ""


def continuous_comfort(
    acceleration: xr.DataArray, name: str, *, start: float = 0.0
) -> xr.DataArray:
    """Return the weighted root mean square of blocks of 5 s, one after the other (EN 12299).

    Parameters
    ----------
    acceleration
        In m/s2; dimensions ``time`` and any others.
    name
        ``Wd`` horizontally, ``Wb`` vertically.
    start
        Time in s from which on it counts, see :func:`weighted_rms`.

    Returns
    -------
    xarray.DataArray
        Dimension ``time``: the end of each block in s; empty where less than 5 s count.
    """
    step = time_step(acceleration)
    rows = round(BLOCK / step)
    squares = _from(weighted(acceleration, name), start) ** 2
    count = squares.sizes["time"] // rows
    whole = squares.isel(time=slice(0, count * rows))
    if count == 0:
        found = whole**0.5
    else:
        found = whole.coarsen(time=rows).reduce(np.mean) ** 0.5
        begin = float(squares["time"].to_numpy()[0])
        found = found.assign_coords(time=begin + BLOCK * np.arange(1, count + 1))
    return found.assign_attrs(units="m/s2", weighting=name, evaluated_over=_window(whole))


def mean_comfort(
    lateral: xr.DataArray,
    vertical: xr.DataArray,
    longitudinal: xr.DataArray | None = None,
    *,
    start: float = 0.0,
) -> xr.DataArray:
    """Return the mean comfort index N_MV of EN 12299 at the floor.

    Parameters
    ----------
    lateral, vertical, longitudinal
        Accelerations in m/s2 with the same dimensions; without a longitudinal one it counts as 0.
    start
        Time in s from which on it counts, see :func:`weighted_rms`.

    Returns
    -------
    xarray.DataArray
        Without ``time``; not a number where less than 5 s count. Its attribute ``blocks`` is
        the number of blocks: the standard requires 60.
    """
    directions = [(lateral, "Wd"), (vertical, "Wb")]
    if longitudinal is not None:
        directions.append((longitudinal, "Wd"))
    squares = []
    blocks, window = 0, ""
    for acceleration, name in directions:
        values = continuous_comfort(acceleration, name, start=start)
        blocks, window = values.sizes["time"], values.attrs["evaluated_over"]
        if blocks == 0:
            squares.append(acceleration.isel(time=0, drop=True) * np.nan)
        else:
            squares.append(values.quantile(0.95, "time").drop_vars("quantile") ** 2)
    found = 6.0 * np.sqrt(sum(squares[1:], squares[0]))
    return found.rename("mean_comfort").assign_attrs(
        units="1",
        long_name="mean comfort N_MV, EN 12299",
        blocks=blocks,
        evaluated_over=window,
    )


def comfort_in_words(index: float) -> str:
    """Return what EN 12299 calls a mean comfort ``index`` (N_MV, dimensionless)."""
    words = ("very comfortable", "comfortable", "medium", "uncomfortable")
    for limit, word in zip((1.5, 2.5, 3.5, 4.5), words, strict=True):
        if index < limit:
            return word
    return "very uncomfortable" if index >= 4.5 else ""


def sperling_index(
    acceleration: xr.DataArray, direction: str, *, start: float = 0.0
) -> xr.DataArray:
    """Return Sperling's ride index Wz.

    Parameters
    ----------
    acceleration
        In m/s2; dimensions ``time`` and any others.
    direction
        ``lateral`` or ``vertical``.
    start
        Time in s from which on it counts.

    Returns
    -------
    xarray.DataArray
        Without ``time``: about 1 just noticeable, 2.5 good, 3 still acceptable for passengers.

    Raises
    ------
    ParameterError
        For another direction.
    """
    if direction not in ("lateral", "vertical"):
        raise ParameterError("direction", direction, "must be lateral or vertical")
    rms = weighted_rms(acceleration, f"sperling_{direction}", start=start)
    found = _SPERLING_FACTOR * rms**0.3
    about = {"units": "1", "long_name": f"Sperling index Wz, {direction}"}
    return found.assign_attrs(about, evaluated_over=rms.attrs["evaluated_over"])


def sperling_of_sine(amplitude: float, frequency: float, direction: str) -> float:
    """Return Sperling's index of one sine from the tables of GB/T 5599: for comparison.

    ``W = 3.57 (a^3 F(f)/f)^(1/10)`` with a in m/s2 (0.896 with cm/s2); F is 0.325 f^2 to 5.9 Hz,
    400/f^2 to 20 Hz and 1 above vertically; 0.8 f^2 to 5.4 Hz, 650/f^2 to 26 Hz and 1 above
    laterally.

    Parameters
    ----------
    amplitude
        In m/s2.
    frequency
        In Hz, from 0.5 on.
    direction
        ``lateral`` or ``vertical``.
    """
    rise, first, fall, second = (0.325, 5.9, 400.0, 20.0)
    if direction == "lateral":
        rise, first, fall, second = (0.8, 5.4, 650.0, 26.0)
    f = frequency
    factor = rise * f**2 if f < first else fall / f**2 if f < second else 1.0
    return float(3.57 * (amplitude**3 * factor / f) ** 0.1)
