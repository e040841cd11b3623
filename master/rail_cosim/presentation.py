"""How the variables of a run are shown, in all plots alike: words, units, colours, round-off."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from rail_cosim.results import SIDES

# Colours that stay apart for the colour-blind, in print and on screen (Okabe and Ito).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555")

TITLES = {
    "normal_force": "wheel force",
    "vertical_wheel_force": "vertical wheel force Q",
    "guiding_force": "lateral wheel force Y",
    "track_shifting_force": "track shifting force (sum of Y)",
    "flange_climbing": "Y/Q, Y outwards",
    "axle_box_vertical_acceleration": "axle-box acceleration",
    "bogie_vertical_acceleration": "bogie acceleration, vertical",
    "bogie_lateral_acceleration": "bogie acceleration, lateral",
    "car_body_vertical_acceleration": "car body acceleration, vertical",
    "car_body_lateral_acceleration": "car body acceleration, lateral",
    "car_body_floor_vertical_acceleration": "car body acceleration at the floor, vertical",
    "car_body_floor_lateral_acceleration": "car body acceleration at the floor, lateral",
    "rail_vertical_displacement": "rail deflection under the wheel",
    "wheelset_vertical_displacement": "wheelset displacement, downwards",
}
"""Words for variables; others go by their ``long_name``."""

_UNITS = {"N": ("kN", 1e-3), "m": ("mm", 1e3), "m/s2": ("m/s²", 1.0), "1": ("", 1.0)}
_ROUND_OFF = 1e-9
_GRAVITY = 9.81
_NUMBERED = ("wheelset", "bogie", "floor_place")
_FLOOR_PLACES = {1: "over the leading bogie", 2: "at mid-car", 3: "over the trailing bogie"}


class Channel(NamedTuple):
    """One line of a plot.

    Attributes
    ----------
    name
        In the legend.
    values
        Of one place.
    colour
        By the number of the wheelset, bogie or place.
    dash
        ``solid`` or ``dot``, for the right wheels.
    shown
        Whether it is shown at first. Of the wheels the left ones are: on straight track they are
        nearly alike.
    """

    name: str
    values: xr.DataArray
    colour: str
    dash: str
    shown: bool


def channels(array: xr.DataArray) -> list[Channel]:
    """Return the channels of a variable: each wheelset and side, bogie, or place of the floor."""
    array = array.transpose("time", ...) if "time" in array.dims else array
    dimension = next((str(d) for d in array.dims if d in _NUMBERED), None)
    found: list[Channel] = []
    for index in range(array.sizes[dimension] if dimension else 1):
        one, name = array, TITLES.get(str(array.name), str(array.name or ""))
        if dimension:
            one = array.isel({dimension: index})
            number = int(array[dimension][index]) if dimension in array.coords else index + 1
            name = f"{dimension} {number}"
            if dimension == "floor_place":
                name = _FLOOR_PLACES.get(number, f"position {number}")
        colour = COLOURS[index % len(COLOURS)]
        if "side" not in array.dims:
            found.append(Channel(name, one, colour, "solid", True))
            continue
        for side in range(one.sizes["side"]):
            word = str(one["side"].to_numpy()[side]) if "side" in one.coords else SIDES[side]
            dash = "solid" if side == 0 else "dot"
            found.append(Channel(f"{name} {word}", one.isel(side=side), colour, dash, side == 0))
    return found


def title(array: xr.DataArray) -> str:
    """Return the words for a variable."""
    name = str(array.name or "")
    return TITLES.get(name) or str(array.attrs.get("long_name", name))


def shown_unit(array: xr.DataArray) -> tuple[str, float]:
    """Return the unit in which a variable is shown ("" for none), and the factor to it."""
    unit = str(array.attrs.get("units", "1"))
    return _UNITS.get(unit, (unit, 1.0))


def label(array: xr.DataArray) -> str:
    """Return words and unit, as at an axis."""
    unit = shown_unit(array)[0]
    return f"{title(array)} ({unit})" if unit else title(array)


def without_round_off(array: xr.DataArray, load: float) -> xr.DataArray:
    """Return a variable with 0 for values that are nothing but round-off.

    These are forces below 1e-9 of the static wheel load, accelerations below 1e-9 of gravity,
    ratios below 1e-9, displacements below 1e-12 m; other units stay as they are.

    Parameters
    ----------
    array
        With its unit in ``units``.
    load
        Static wheel load in N.
    """
    scales = {"N": load, "m/s2": _GRAVITY, "1": 1.0, "m": 1e-3}
    limit = _ROUND_OFF * scales.get(str(array.attrs.get("units", "")), math.nan)
    # Comparisons with NaN are false: what has no scale is left alone, and so is what is NaN.
    small = np.abs(array.to_numpy()) <= limit
    return array.copy(data=np.where(small, 0.0, array.to_numpy())) if small.any() else array


def all_without_round_off(data: xr.Dataset, load: float) -> xr.Dataset:
    """Return :func:`without_round_off` of all real variables of a run, or of its statistics."""
    return data.assign(
        {k: without_round_off(v, load) for k, v in data.data_vars.items() if v.dtype.kind == "f"}
    )
