"""Figure of the three models of Table 1 and the ring."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from rail_cosim.studies.plots import _DPI, _GRID, _figure

_STYLES = {  # those below are thicker: the curves lie on each other
    "sliding": {"color": "#56B4E9", "lw": 4.0},
    "moving_mass_long": {"color": "#E69F00", "lw": 2.4},
    "cyclic": {"color": "#009E73", "lw": 1.2},
    "moving_mass": {"color": "#D55E00", "lw": 1.2, "ls": "--"},
    "moving_irregularity": {"color": "0.45", "lw": 1.2},
}
_SHOWN = (14.0, 26.0)  # m; the moving mass ends in it
_FLOOR = 1e-2  # N


def plot_models(dataset: xr.Dataset, path: Path, words: Mapping[str, str]) -> None:
    """Draw the leading wheel's force over the way, and how far it is from the sliding window's."""
    figure = _figure(8.4, 6.4)
    upper, lower = figure.subplots(2, 1)
    way = dataset["distance"].to_numpy()
    shown = (way >= _SHOWN[0]) & (way <= _SHOWN[1])
    for model, style in _STYLES.items():
        force = dataset["leading_force"].sel(model=model).to_numpy()
        upper.plot(way[shown], force[shown] / 1e3, label=words[model], **style)
        if model != "sliding":
            off = dataset["force_difference"].sel(model=model).to_numpy()
            off = np.where(np.isnan(off), off, off.clip(_FLOOR))
            lower.semilogy(way, off, color=style["color"], lw=0.8, label=words[model])
    load = float(dataset.attrs["static_wheel_load"])
    lower.axhline(1e-3 * load, color="0.3", ls="--", lw=0.8, label="0.1 % of the load")
    upper.set_ylabel("force, leading left wheel (kN)")
    lower.set_ylabel("largest difference of any\nwheel from sliding (N)")
    for axes in (upper, lower):
        axes.set_xlabel("distance travelled by the leading wheelset (m)")
        axes.grid(**_GRID)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8)
    figure.savefig(path, dpi=_DPI)
