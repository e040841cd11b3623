"""Figures of the studies of the sliding window."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter1d

from rail_cosim.studies.plots import _BLUE, _DPI, _GRID, _RED, _figure

_SHOWN = ("article: 200 plain modes, M = 250", "sharp end", "default", "hard pads, 180 km/h")
_DIVERGED = 100.0  # % of the load
_ENVELOPE = 0.3  # m


def plot_slide(dataset: xr.Dataset, path: Path) -> None:
    """Draw the largest difference for each way of sliding, and some of them over the way."""
    names = [str(name) for name in dataset["variant"].to_numpy()]
    load = dataset.attrs["static_wheel_load"]
    share = 100.0 * dataset["largest_difference"].to_numpy() / load
    figure = _figure(9.6, 1.6 + 0.24 * len(names))
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.1))
    rows = np.arange(len(names))
    hard = ["hard" in name for name in names]
    felt = np.where(share < _DIVERGED, share, _DIVERGED)
    left.barh(rows, felt, color=np.where(hard, _RED, _BLUE), height=0.7)
    left.set_yticks(
        rows, [n if s < _DIVERGED else f"{n} (diverges)" for n, s in zip(names, share, strict=True)]
    )
    left.invert_yaxis()
    left.set_xscale("log")
    for limit, colour in ((0.01, _BLUE), (0.1, _RED)):
        left.axvline(limit, color=colour, ls="--", lw=1.2)
    left.set_xlabel("largest difference of a wheel force\n(% of the static load; dashed: limits)")
    way = dataset["distance"].to_numpy()
    for name in (n for n in _SHOWN if n in names):
        values = dataset["difference"].sel(variant=name).to_numpy()
        right.semilogy(way, values.clip(1e-3), lw=0.9, label=name)
    right.set_xlabel("distance travelled (m)")
    right.set_ylabel("largest difference of a wheel force (N)")
    right.legend(frameon=False, fontsize=8)
    for axis in (left, right):
        axis.grid(**_GRID)
        axis.set_axisbelow(True)
        axis.tick_params(labelsize=8)
    figure.savefig(path, dpi=_DPI)


def plot_joint(dataset: xr.Dataset, path: Path) -> None:
    """Draw the leading wheel's force over the way, and how far the models are apart."""
    figure = _figure(8.4, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    way = dataset["distance"].to_numpy()
    styles = {"moving_mass": (_RED, "-", 2.6), "sliding": (_BLUE, "--", 1.0)}
    for name, (colour, dashes, width) in styles.items():
        values = dataset["leading_force"].sel(model=name).to_numpy() / 1e3
        label = name.replace("_", " ")
        upper.plot(way, values, color=colour, ls=dashes, lw=width, label=label)
    upper.set_ylabel("normal force, leading wheel (kN)")
    upper.legend(frameon=False)
    window = max(1, round(_ENVELOPE / (way[1] - way[0])))
    for name in dataset["model"].to_numpy():
        if name != "moving_mass":
            difference = dataset["difference"].sel(model=name).to_numpy()
            envelope = maximum_filter1d(difference, window)
            label = str(name).replace("_", " ")
            lower.semilogy(
                way, envelope.clip(1e-3), lw=2.0 if name == "sliding" else 1.1, label=label
            )
    lower.set_xlabel("distance travelled by the leading wheelset (m)")
    lower.set_ylabel("largest difference of any wheel from\nthe moving mass within 0.3 m (N)")
    lower.legend(frameon=False)
    for axis in (upper, lower):
        axis.grid(**_GRID)
    figure.savefig(path, dpi=_DPI)


_FIELDS = {"deflection": ("mm", 1e3, 0.5), "acceleration": ("m/s²", 1.0, 20.0)}
"""Unit and its factor, and up to where the scale is linear if the field diverges, by field."""


def plot_fields(dataset: xr.Dataset, path: Path, labels: Mapping[str, str]) -> None:
    """Draw the rail's fields after a slide, a row for each way of solving eq. (10)."""
    ways = dataset["way"].to_numpy()
    columns = [(s, field) for s in dataset["setting"].to_numpy() for field in _FIELDS]
    figure = _figure(4.4 * len(columns), 1.9 * len(ways) + 0.8)
    axes = figure.subplots(len(ways), len(columns), sharex=True, squeeze=False)
    place = dataset["place"].to_numpy()
    for column, (setting, field) in enumerate(columns):
        unit, factor, linear = _FIELDS[field]
        target = factor * dataset[f"target_{field}"].sel(setting=setting).to_numpy()
        for row, way in enumerate(ways):
            axis = axes[row, column]
            values = factor * dataset[field].sel(setting=setting, way=way).to_numpy()
            axis.plot(place, values, color=_RED, lw=1.0, label="after the shift")
            axis.plot(place, target, color=_BLUE, lw=0.8, label="before, moved")
            if bool(dataset["diverges"].sel(setting=setting, way=way)):
                largest = np.nanmax(np.abs(values), initial=10.0 * linear)
                end = 10.0 ** np.floor(np.log10(largest))
                axis.set_yscale("symlog", linthresh=linear)
                axis.set_yticks([-end, 0.0, end])
                axis.minorticks_off()
            axis.set_title(f"{setting}: {labels[str(way)]}", loc="left", fontsize=9)
            axis.set_ylabel(f"{field} ({unit})", fontsize=8)
            axis.grid(**_GRID)
        axes[-1, column].set_xlabel("place in the window (m)")
    figure.suptitle(
        "rail before and after a window shift; logarithmic where it diverges", fontsize=9
    )
    axes[0, 0].legend(frameon=False, fontsize=8, loc="center right")
    figure.savefig(path, dpi=_DPI)
