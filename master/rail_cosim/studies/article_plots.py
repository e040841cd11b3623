"""Figures of the studies that repeat the article's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_DPI = 200
_GRID = {"visible": True, "lw": 0.3, "color": "0.8"}
_WORDS = {"paper": "article's settings", "converged": "converged"}
Draw = Callable[[Axes, xr.Dataset], None]
_HIGHEST = 400.0  # Hz
_LOWEST = "_rail_cosim_lowest"


def panels(
    data: xr.Dataset, rows: Sequence[Draw], path: Path, *, title: str, height: float = 3.1
) -> None:
    """Draw each row once for each setting, side by side, with common axes in a row.

    Parameters
    ----------
    data
        With the dimension ``setting``.
    rows
        Each draws one panel from the data of one setting.
    path, title
        Of the picture.
    height
        Of a row in inches.
    """
    settings = [str(s) for s in data["setting"].to_numpy()]
    figure = Figure(figsize=(9.6, height * len(rows) + 0.3), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(len(rows), len(settings), sharex="row", sharey="row", squeeze=False)
    for row, draw in zip(grid, rows, strict=True):
        for axes, setting in zip(row, settings, strict=True):
            draw(axes, data.sel(setting=setting))
            axes.grid(**_GRID)
            axes.set_title(_WORDS.get(setting, setting), loc="left", fontsize="medium")
        for axes in row[1:]:
            axes.set_ylabel("")
    for row in grid:
        for axes in row:
            if (lowest := getattr(axes, _LOWEST, None)) is not None:
                axes.set_ylim(bottom=lowest)
        handles, labels = row[0].get_legend_handles_labels()
        if len(handles) > 1:  # beside the panels, where it hides no curve
            outside = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5)}
            row[-1].legend(handles, labels, frameon=False, fontsize="small", **outside)
    figure.suptitle(title, fontsize="medium", x=0.01, ha="left")
    figure.savefig(path, dpi=_DPI)


def begin_at(axes: Axes, lowest: float) -> None:
    """Let the vertical axis of a row begin at ``lowest``, once all its panels are drawn.

    A limit set before would keep the axis from growing with the panels beside.
    """
    setattr(axes, _LOWEST, lowest)


def spectrum_line(
    axes: Axes, frequencies: np.ndarray, amplitudes: np.ndarray, *, lowest: float, **style: Any
) -> None:
    """Draw a spectrum from 1 to 400 Hz, amplitudes on a logarithmic scale from ``lowest`` on."""
    there = (frequencies > 1.0) & (frequencies <= _HIGHEST)
    axes.semilogy(frequencies[there], amplitudes[there], lw=0.9, **style)
    begin_at(axes, lowest)
    axes.set_xlabel("frequency (Hz)")


def curves(
    axes: Axes,
    values: xr.DataArray,
    along: str,
    *,
    labels: Callable[[float], str],
    marks: Callable[[float], float] | None = None,
    style: str = ".-",
) -> None:
    """Draw a curve over speed for each value of another axis.

    Parameters
    ----------
    axes
        Where to draw.
    values
        Over ``speed`` and ``along``.
    along
        One curve for each value of it.
    labels
        Words for such a value.
    marks
        Speed (km/h) to mark for such a value, by a tick from below.
    """
    numbers = values[along].to_numpy()
    colours = colormaps["viridis"](np.linspace(0.0, 0.88, len(numbers)))
    for number, colour in zip(numbers, colours, strict=True):
        curve = values.sel({along: number})
        axes.plot(curve["speed"], curve, style, color=colour, lw=1.2, ms=3, label=labels(number))
        if marks is not None:
            axes.axvline(marks(number), ymax=0.06, color=colour, lw=1.6)
    axes.set_xlabel("speed (km/h)")
