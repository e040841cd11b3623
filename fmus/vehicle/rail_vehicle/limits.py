"""Limits of motion: where a vehicle is no longer one that runs on a track.

The equations are those of small displacements and angles; at 1 rad a sine is 16 % less than its
angle. On rails wheelsets stay within centimetres (a flange is 28 mm high), bogies within their
bump stops. Whoever pushes a vehicle farther than these limits, which are far more, gets an error
and no numbers.
"""

import math
from typing import Any

import numpy as np
from rail_quantities import ParameterError, Quantity
from rail_quantities.ranges import SIZES

from rail_vehicle.coordinates import (
    BODY_COUNT,
    BOGIES,
    BOX_START,
    CAR_BODY,
    FREE,
    SIDES,
    X,
    Y,
    Z,
)
from rail_vehicle.errors import StepError
from rail_vehicle.kernels import PITCH_RATES, VECTOR_COUNT
from rail_vehicle.multibody import Array
from rail_vehicle.parameters import LARGEST_DISPLACEMENT, VehicleParameters

LARGEST_ROTATION = 1.0
"""Of any body from its place at rest, rad; spins of wheelsets apart."""

LARGEST_SPEED = SIZES["m/s"][1]
"""Of the vehicle, m/s."""

LARGEST_RIM_SPEED = 1e4
"""Of a wheel's rim about its axle, m/s; a steel disc bursts at a thirtieth of it."""

SHORTEST_STEP = 1e-6
"""Shortest internal step, s: with it a communication step of 0.1 ms takes 100 of them."""

_WORDS = ("longitudinal_displacement", "lateral_displacement", "vertical_displacement")
_WORDS += ("roll_angle", "pitch_angle", "yaw_angle")
_ELEMENTS = (
    *4 * ("yaw_damper.series_stiffness",),
    *2 * ("lateral_damper.damping",),
    *2 * ("lateral_bump_stop.cubic_stiffness",),
)


def motion_limits(parameters: VehicleParameters) -> Array:
    """Return the largest absolute value of each number of the state, shape (104,), SI units."""
    limits = np.full(VECTOR_COUNT, math.inf)
    is_length = (FREE < BOX_START) & np.isin(FREE % 6, (X, Y, Z))
    limits[: FREE.size] = np.where(is_length, LARGEST_DISPLACEMENT, LARGEST_ROTATION)
    limits[PITCH_RATES : PITCH_RATES + 4] = LARGEST_RIM_SPEED / parameters.wheelset.radius
    return limits


def beyond(vector: Array, limits: Array) -> str:
    """Return what in a state is farthest beyond its limit, with value and limit; else nothing.

    Parameters
    ----------
    vector
        State, shape (104 or more,), SI units.
    limits
        As :func:`motion_limits` returns them.
    """
    shares = np.abs(vector[:VECTOR_COUNT]) / limits
    place = int(np.argmax(shares))
    if shares[place] <= 1.0:
        return ""
    name, unit = _named(place)
    return f"{name} = {vector[place]:.6g} {unit}, beyond {limits[place]:.4g} {unit}"


def _named(place: int) -> tuple[str, str]:
    """Return name and unit of a number of the state that has a limit."""
    if place >= PITCH_RATES:
        return f"wheelset[{place - PITCH_RATES + 1}].pitch_rate", "rad/s"
    number = int(FREE[place])
    if number >= BOX_START:
        wheelset, side = divmod(number - BOX_START, 2)
        return f"axle_box[{wheelset + 1}].{SIDES[side]}.pitch_angle", "rad"
    body, direction = divmod(number, 6)
    first = 1 + len(BOGIES)
    names = ["car_body", *(f"bogie[{i}]" for i in range(1, first))]
    names += [f"wheelset[{i}]" for i in range(1, BODY_COUNT - first + 1)]
    return f"{names[CAR_BODY + body]}.{_WORDS[direction]}", "m" if direction <= Z else "rad"


def check_setpoint(setpoint: float) -> None:
    """Refuse a speed that no vehicle has.

    Raises
    ------
    StepError
        If it is not finite, or beyond the limit.
    """
    if not abs(setpoint) <= LARGEST_SPEED:
        raise StepError(
            f"speed_setpoint = {setpoint!r} m/s: must be finite and at most {LARGEST_SPEED:g} m/s"
        )


def check_heights(heights: Array) -> None:
    """Refuse wheelsets that start farther up or down than any may get.

    Raises
    ------
    ParameterError
        If one of the heights (4,) in m is not finite, or beyond the limit.
    """
    for number, height in enumerate(heights, start=1):
        if not abs(height) <= LARGEST_DISPLACEMENT:
            raise ParameterError(
                f"wheelset[{number}].initial_vertical_displacement",
                float(height),
                f"must be finite and from {-LARGEST_DISPLACEMENT:g} to {LARGEST_DISPLACEMENT:g} m",
                "heights count from the datum of the track",
            )


def check_start(vector: Array, limits: Array, heights: Array) -> None:
    """Refuse heights of the wheelsets that put another body beyond its limit.

    Raises
    ------
    ParameterError
        If they do; with the largest of the heights (4,) in m.
    """
    if why := beyond(vector, limits):
        first = int(np.argmax(np.abs(heights)))
        raise ParameterError(
            f"wheelset[{first + 1}].initial_vertical_displacement",
            float(heights[first]),
            f"the heights of the wheelsets put {why}",
            "take heights that differ less",
        )


def refuse_short_step(
    step: float, parameters: dict[str, tuple[Quantity, Any]], shares: Array
) -> None:
    """Say that the elements' forces can be found with too short steps only.

    Parameters
    ----------
    step
        The step that is needed, s, or a longer one.
    parameters
        All parameters with their descriptions, by dotted name.
    shares
        What each of the eight elements does to that, shape (8,).

    Raises
    ------
    ParameterError
        Always: with the element that does most.
    """
    name = _ELEMENTS[int(np.argmax(shares))]
    raise ParameterError(
        name,
        parameters[name][1],
        f"needs internal steps below {step:.2g} s on these bodies, and the shortest possible is "
        f"{SHORTEST_STEP:g} s",
        "make it less, or the bodies' masses and inertias more, or its lever arms shorter",
    )
