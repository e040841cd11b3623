"""One figure of a run: wheel force, axle-box acceleration and its spectrum."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rail_cosim.errors import ParameterError
from rail_cosim.presentation import COLOURS
from rail_cosim.reporting.charts import envelope
from rail_cosim.summary import Summary, spectrum
from rail_cosim.window import distances

_WIDTH, _HEIGHT, _DPI = 8.4, 8.4, 200
FORMATS = (".png", ".pdf", ".svg")
_HIGHEST = 500.0
_POINTS = 20_000  # of a line at most
_PART = 65_536  # records in memory at a time
_BOX = "axle_box_vertical_acceleration"


def check_format(path: Path) -> None:
    """Make sure that ``path`` ends in a format that can be drawn.

    Raises
    ------
    ParameterError
        If it does not.
    """
    if path.suffix.lower() not in FORMATS:
        raise ParameterError("--plot", str(path), "must end in " + " or ".join(FORMATS))


def plot_run(dataset: xr.Dataset, summary: Summary, path: Path) -> None:
    """Draw a run to a file: the whole distance, the last few metres, the spectrum.

    Long histories are drawn as their envelope, so that every peak is seen.

    Parameters
    ----------
    dataset
        The run.
    summary
        Its figures: the evaluation window is shaded.
    path
        The plot; its ending says the format (png, pdf, svg).
    """
    check_format(path)
    part = dataset.isel(time=summary.window.rows)
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic(
        [["force", "force_end"], ["box", "box_end"], ["spectrum", "spectrum"]],
        width_ratios=[1.7, 1.0],
    )
    for key, name, factor, label in (
        ("force", "normal_force", 1e-3, "wheel force (kN)"),
        ("box", _BOX, 1.0, "axle-box acceleration (m/s²)"),
    ):
        whole, end = axes[key], axes[f"{key}_end"]
        whole.axvspan(summary.window.start, summary.window.stop, color="0.94", lw=0, zorder=0)
        _over_distance(whole, dataset, name, factor)
        _over_distance(end, part, name, factor)
        end.set_xlim(*_end(summary))
        end.sharey(whole)
        end.tick_params(labelleft=False)
        whole.set_ylabel(label)
    axes["force"].set_title(_title(dataset), loc="left", fontsize="medium")
    last = f"last {summary.window.of} length" if summary.window.periods else "end"
    axes["force_end"].set_title(last, loc="left", fontsize="medium")
    for key in ("box", "box_end"):
        axes[key].set_xlabel("distance travelled (m)" if key == "box" else "(m)")
    _spectrum(axes["spectrum"], part, summary)
    _legend(figure, axes["force"])
    figure.savefig(path, dpi=_DPI)


def _end(summary: Summary) -> tuple[float, float]:
    """Return the last whole period of the evaluation window, or its last tenth."""
    start, stop = summary.window.start, summary.window.stop
    return stop - (stop - start) / (summary.window.periods or 10), stop


def _title(dataset: xr.Dataset) -> str:
    about = dataset.attrs
    words = [f"line {about['line']}"] if about.get("line") else []
    if "speed_km_h" in about:
        words.append(f"{about['speed_km_h']:.4g} km/h")
    if "side" in dataset.coords:
        words.append(f"{dataset['side'].to_numpy()[0]} wheels")
    if not about.get("complete", 1):
        words.append("incomplete run")
    return ", ".join(words)


def _over_distance(axes: Axes, dataset: xr.Dataset, name: str, factor: float) -> None:
    if name in dataset:
        for i in range(dataset.sizes["wheelset"]):
            distance, values = _envelope(dataset, dataset[name].isel(side=0, wheelset=i))
            colour = COLOURS[i % len(COLOURS)]
            axes.plot(distance, values * factor, color=colour, lw=0.8, label=f"wheelset {i + 1}")
    axes.set_xlim(*distances(dataset.isel(time=[0, -1])))
    axes.grid(visible=True, lw=0.3, color="0.8")


def _envelope(dataset: xr.Dataset, array: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Return a history thinned to its extremes, read part by part."""
    count = array.sizes["time"]
    points = max(4, round(_POINTS * min(1.0, _PART / count)))
    parts: list[tuple[np.ndarray, np.ndarray]] = []
    for start in range(0, count, _PART):
        rows = slice(start, start + _PART)
        values = array.isel(time=rows).to_numpy()
        parts.append(envelope(distances(dataset.isel(time=rows)), values, points))
    return np.concatenate([x for x, _ in parts]), np.concatenate([y for _, y in parts])


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        place = "outside lower center"
        legend = figure.legend(handles, labels, loc=place, ncols=len(handles), frameon=False)
        for line in legend.get_lines():
            line.set_linewidth(2.0)


def _spectrum(axes: Axes, part: xr.Dataset, summary: Summary) -> None:
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("amplitude (m/s²)")
    axes.set_title(
        "axle-box acceleration, evaluation window (shaded)", loc="left", fontsize="medium"
    )
    if _BOX in part:
        frequencies, lines = spectrum(part["time"].to_numpy(), part[_BOX].isel(side=0).to_numpy())
        for i in range(lines.shape[1]):
            axes.plot(frequencies, lines[:, i], color=COLOURS[i % len(COLOURS)], lw=0.9)
        axes.set_xlim(0.0, min(_HIGHEST, float(frequencies[-1])))
    axes.set_ylim(bottom=0.0)
    marks = (
        (summary.fastener_passing_frequency, "fastener passing"),
        (summary.slab_passing_frequency, "slab passing"),
    )
    for frequency, word in marks:
        if not math.isnan(frequency):
            axes.axvline(frequency, color="0.5", lw=0.8, ls="--", zorder=0)
            axes.annotate(
                word,
                (frequency, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(3, -4),
                textcoords="offset points",
                rotation=90,
                va="top",
                fontsize="small",
                color="0.35",
            )
    axes.grid(visible=True, lw=0.3, color="0.8")
