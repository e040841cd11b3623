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

# Colours that stay apart for the colour-blind, in print and on screen (Okabe and Ito).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
_WIDTH, _HEIGHT, _DPI = 7.2, 7.6, 200
FORMATS = (".png", ".pdf", ".svg")
_HIGHEST = 500.0


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
    """Draw a run to a file.

    Parameters
    ----------
    dataset
        The run.
    summary
        Its figures: the evaluated range is marked.
    path
        The picture; its ending says the format (png, pdf, svg).
    """
    check_format(path)
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
    FigureCanvasAgg(figure)
    force_axes, acceleration_axes, spectrum_axes = figure.subplots(3, 1)
    side = _plotted_side(dataset)
    force, acceleration = "normal_force", "axle_box_vertical_acceleration"
    _over_distance(force_axes, dataset, force, 1e-3, summary)
    force_axes.set_ylabel("wheel force (kN)")
    force_axes.set_title(_title(dataset, side), loc="left", fontsize="medium")
    _over_distance(acceleration_axes, dataset, acceleration, 1.0, summary)
    acceleration_axes.set_ylabel("axle-box acceleration (m/s²)")
    acceleration_axes.set_xlabel("distance of the leading wheelset (m)")
    _spectrum(spectrum_axes, dataset, acceleration, summary)
    handles, labels = force_axes.get_legend_handles_labels()
    if handles:
        figure.legend(
            handles, labels, loc="outside lower center", ncols=len(handles), frameon=False
        )
    figure.savefig(path, dpi=_DPI)


def _plotted_side(dataset: xr.Dataset) -> str:
    return str(dataset["side"].to_numpy()[0]) if "side" in dataset.coords else ""


def _title(dataset: xr.Dataset, side: str) -> str:
    about = dataset.attrs
    words = [f"line {about['line']}"] if about.get("line") else []
    if "speed_km_h" in about:
        words.append(f"{about['speed_km_h']:g} km/h")
    words.append(f"{side} wheels" if side else "wheels")
    if not about.get("complete", 1):
        words.append("incomplete run")
    return ", ".join(words)


def _over_distance(
    axes: Axes, dataset: xr.Dataset, name: str, factor: float, summary: Summary
) -> None:
    axes.axvspan(summary.range.start, summary.range.stop, color="0.94", lw=0, zorder=0)
    if name in dataset:
        values = dataset[name].isel(side=0)
        for i in range(values.sizes["wheelset"]):
            axes.plot(
                dataset["distance"],
                values.isel(wheelset=i) * factor,
                color=_COLOURS[i % len(_COLOURS)],
                lw=0.7,
                label=f"wheelset {i + 1}",
            )
    axes.set_xlim(float(dataset["distance"][0]), float(dataset["distance"][-1]))
    axes.grid(visible=True, lw=0.3, color="0.8")


def _spectrum(axes: Axes, dataset: xr.Dataset, name: str, summary: Summary) -> None:
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("amplitude (m/s²)")
    if name in dataset:
        part = dataset.isel(time=summary.range.rows)
        frequencies, lines = spectrum(part["time"].to_numpy(), part[name].isel(side=0).to_numpy())
        for i in range(lines.shape[1]):
            axes.plot(frequencies, lines[:, i], color=_COLOURS[i % len(_COLOURS)], lw=0.9)
        axes.set_xlim(0.0, min(_HIGHEST, float(frequencies[-1])))
    axes.set_ylim(bottom=0.0)
    marks = ((summary.sleeper_frequency, "sleeper passing"), (summary.slab_frequency, "slab"))
    for frequency, word in marks:
        if not math.isnan(frequency):
            axes.axvline(frequency, color="0.5", lw=0.8, ls="--", zorder=0)
            axes.annotate(
                word,
                (frequency, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(3, -3),
                textcoords="offset points",
                rotation=90,
                va="top",
                fontsize="small",
                color="0.35",
            )
    axes.grid(visible=True, lw=0.3, color="0.8")
