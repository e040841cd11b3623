"""Figures of the studies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from rail_cosim.studies.critical_speed import Attempt

_DPI = 200
_BLUE, _RED = "#0072B2", "#D55E00"  # stay apart for the colour-blind (Okabe and Ito)
_GRID = {"visible": True, "lw": 0.3, "color": "0.8"}
_MM = 1e3


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plot_critical_speed(
    attempts: Sequence[Attempt], bracket: tuple[float | None, float | None], path: Path
) -> None:
    """Draw the envelopes over time, and growth rate and final amplitude over speed."""
    figure = _figure(8.4, 7.0)
    upper, lower = figure.subplots(2, 1, height_ratios=[1.2, 1.0])
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(attempts)))
    for one, colour in zip(attempts, colours, strict=True):
        label = f"{one.speed:.5g} km/h"
        if one.motion is None:
            # Too short for an envelope: the largest displacement so far.
            reached = np.maximum.accumulate(np.abs(one.lateral).max(axis=1)) * _MM
            upper.semilogy(one.time, reached, ":", color=colour, lw=1.4, label=f"{label}, derails")
            continue
        style = "-" if one.stable else "--"
        motion = one.motion
        upper.semilogy(
            motion.times, motion.amplitude * _MM, style, color=colour, lw=1.4, label=label
        )
    upper.set_xlabel("time (s)")
    upper.set_ylabel("lateral amplitude (mm)")
    upper.set_title(
        "amplitude of the wheelsets; dashed, dotted: does not die out", loc="left", fontsize=10
    )
    upper.grid(**_GRID)
    upper.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    speeds = [one.speed for one in attempts]
    rates = [np.nan if one.motion is None else one.motion.growth_rate for one in attempts]
    lower.axhline(0.0, color="0.4", lw=0.8)
    lower.plot(speeds, rates, color="0.7", lw=0.8, zorder=1)
    for stable, colour, word in ((True, _BLUE, "dies out"), (False, _RED, "does not die out")):
        chosen = [i for i, one in enumerate(attempts) if one.stable is stable]
        if np.isfinite(np.array(rates)[chosen]).any():
            x, y = np.array(speeds)[chosen], np.array(rates)[chosen]
            lower.plot(x, y, "o", color=colour, ms=5, label=word, zorder=2)
    derailed = [one.speed for one in attempts if one.motion is None]
    if derailed:
        lower.plot(derailed, np.zeros(len(derailed)), "x", color=_RED, label="derails")
    low, high = bracket
    if low is not None and high is not None:
        lower.axvspan(low, high, color=_RED, alpha=0.25, lw=0, label="critical speed")
    lower.set_xlabel("speed (km/h)")
    lower.set_ylabel("growth rate, second half (1/s)")
    lower.grid(**_GRID)
    lower.legend(loc="best", frameon=False, fontsize=8)
    figure.savefig(path, dpi=_DPI)


def plot_contact_geometry(table: xr.Dataset, title: str, path: Path) -> None:
    """Draw radius difference, contact angle and contact points over lateral displacement."""
    figure = _figure(8.4, 6.6)
    axes = figure.subplots(2, 2, sharex=True)
    y = table["lateral_displacement"].to_numpy() * _MM
    axes[0, 0].plot(y, table["rolling_radius_difference"] * _MM, color="0.2", lw=1.2)
    axes[0, 0].set_ylabel("rolling-radius difference (mm)")
    for axis, name, factor, label in (
        (axes[0, 1], "contact_angle", 180.0 / np.pi, "contact angle (deg)"),
        (axes[1, 0], "wheel_position", _MM, "contact point on the wheel (mm)"),
        (axes[1, 1], "rail_position", _MM, "contact point on the rail (mm)"),
    ):
        for side, colour in (("left", _BLUE), ("right", _RED)):
            values = table[name].sel(side=side).to_numpy() * factor
            axis.plot(y, values, ".-", color=colour, lw=0.8, ms=4, label=side)
        axis.set_ylabel(label)
    for axis in axes.flat:
        axis.grid(**_GRID)
    for axis in axes[1]:
        axis.set_xlabel("lateral displacement, to the right (mm)")
    axes[0, 1].legend(frameon=False, fontsize=8)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=_DPI)
