"""One figure of a run: wheel force, axle-box acceleration and its spectrum."""

from __future__ import annotations

import math
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rail_cosim.errors import ParameterError
from rail_cosim.summary import Summary, spectrum
from rail_cosim.window import distances, last_records

# Colours that stay apart for the colour-blind, in print and on screen (Okabe and Ito).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
_WIDTH, _HEIGHT, _DPI = 8.4, 8.4, 200
FORMATS = (".png", ".pdf", ".svg")
_HIGHEST = 500.0
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
    """Draw a run to a file: the whole way, the last few metres, the spectrum.

    Of a long run only what its figures are made of (:func:`rail_cosim.window.last_records`).

    Parameters
    ----------
    dataset
        The run.
    summary
        Its figures: the evaluation window is shaded.
    path
        The picture; its ending says the format (png, pdf, svg).
    """
    check_format(path)
    part, dataset = dataset.isel(time=summary.window.rows), last_records(dataset)
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
        for ax in (whole, end):
            _over_distance(ax, dataset, name, factor)
        end.set_xlim(*_end(dataset, summary))
        end.sharey(whole)
        end.tick_params(labelleft=False)
        whole.set_ylabel(label)
    axes["force"].set_title(_title(dataset), loc="left", fontsize="medium")
    last = f"last {summary.window.of} length" if summary.window.periods else "end"
    axes["force_end"].set_title(last, loc="left", fontsize="medium")
    for key in ("box", "box_end"):
        axes[key].set_xlabel("distance of the leading wheelset (m)" if key == "box" else "(m)")
    _spectrum(axes["spectrum"], part, summary)
    _legend(figure, axes["force"])
    figure.savefig(path, dpi=_DPI)


def _end(dataset: xr.Dataset, summary: Summary) -> tuple[float, float]:
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
    way = distances(dataset)
    if name in dataset:
        values = dataset[name].isel(side=0)
        for i in range(values.sizes["wheelset"]):
            axes.plot(
                way,
                values.isel(wheelset=i) * factor,
                color=_COLOURS[i % len(_COLOURS)],
                lw=0.8,
                label=f"wheelset {i + 1}",
            )
    axes.set_xlim(way[0], way[-1])
    axes.grid(visible=True, lw=0.3, color="0.8")


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
            axes.plot(frequencies, lines[:, i], color=_COLOURS[i % len(_COLOURS)], lw=0.9)
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
