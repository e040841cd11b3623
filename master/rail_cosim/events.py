"""What happened in a run outside its evaluation window."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rail_cosim.extremes import BOX, FORCE, wheels
from rail_cosim.results import SIDES
from rail_cosim.window import EvaluationWindow, time_between

Array = NDArray[np.float64]
_CLEARLY = 2.0
_LEAST_SHARE, _LEAST_ACCELERATION = 0.05, 1.0  # of the mean wheel force; m/s2


def wheel_name(wheelset: int, side: int) -> str:
    """Return what a wheel is called, by its indices."""
    return f"{wheelset + 1} {SIDES[side]}"


def events_outside(run: xr.Dataset, found: xr.Dataset, window: EvaluationWindow) -> list[str]:
    """Return in words what happened outside a window and is clearly beyond what it has seen.

    That is an extreme that deviates from the window's mean more than twice as much as any value
    in the window, and by at least 5 % of the mean wheel force or 1 m/s2; and a loss of contact.
    Of several wheels the one with the largest deviation is named.

    Parameters
    ----------
    run
        The run.
    found
        Its :func:`rail_cosim.extremes.extremes`.
    window
        The window.
    """
    part = run.isel(time=window.rows)
    events: list[str] = []
    if FORCE in run:
        force = wheels(part, FORCE)
        mean = force.mean(axis=0)
        least = _LEAST_SHARE * np.abs(mean)
        for name, seen in (("max", force.max(axis=0)), ("min", force.min(axis=0))):
            events += _extreme(found, f"wheel_force_{name}", seen, mean, least)
        events += _losses(found, (force <= 0.0).sum(axis=0) * time_between(run))
    if BOX in run:
        seen = np.abs(wheels(part, BOX)).max(axis=0)
        least = np.full_like(seen, _LEAST_ACCELERATION)
        events += _extreme(found, "axle_box_acceleration_peak", seen, 0.0 * seen, least)
    return events


def _extreme(found: xr.Dataset, name: str, seen: Array, centre: Array, least: Array) -> list[str]:
    values = found[name].to_numpy()
    deviation = np.abs(values - centre)
    clear = deviation > np.maximum(_CLEARLY * np.abs(seen - centre), least)
    if not clear.any():
        return []
    wheel = np.unravel_index(np.where(clear, deviation, -1.0).argmax(), clear.shape)
    unit, factor = ("kN", 1e-3) if found[name].attrs["units"] == "N" else ("m/s²", 1.0)
    words, place = found[name].attrs["long_name"], float(found[f"{name}_distance"][wheel])
    return [
        f"{words} {values[wheel] * factor:.3f} {unit} at {place:.2f} m "
        f"(wheel {wheel_name(*map(int, wheel))}; in the window {seen[wheel] * factor:.3f} {unit})"
    ]


def _losses(found: xr.Dataset, inside: Array) -> list[str]:
    """Return which wheels lost contact longer than the times (s) in the window."""
    outside = found["loss_of_contact_total"].to_numpy() > inside * (1.0 + 1e-9)
    names = [wheel_name(*map(int, wheel)) for wheel in np.argwhere(outside)]
    return ["loss of contact (wheel " + ", ".join(names) + ")"] if names else []
