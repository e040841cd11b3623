"""Charts as plain dictionaries in the form that plotly.js draws.

Long records are thinned to an envelope: of every stretch the smallest and the largest value stay,
so that peaks are where they were and as high. Numbers travel as base64 of 32-bit floats.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Chart = dict[str, Any]

POINTS = 3000
"""Points of a line at most."""


def envelope(x: Array, y: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Return a line of at most ``points`` points with the same extremes.

    Parameters
    ----------
    x, y
        Shape (n,), in order of x.
    points
        At least 4.

    Returns
    -------
    tuple of ndarray
        Of each of ``points // 2`` stretches the smallest and the largest value, in their order;
        the whole line where it is short enough. First and last point stay.
    """
    count = len(x)
    if count <= points:
        return x, y
    edges = np.linspace(0, count, points // 2, dtype=int)
    # What is not a number must not hide the rest of its stretch.
    low = np.where(np.isfinite(y), y, np.inf)
    high = np.where(np.isfinite(y), y, -np.inf)
    rows = [0, count - 1]
    for begin, end in pairwise(edges):
        rows.append(begin + int(np.argmin(low[begin:end])))
        rows.append(begin + int(np.argmax(high[begin:end])))
    chosen = np.unique(rows)
    return x[chosen], y[chosen]


def packed(values: Array) -> dict[str, Any]:
    """Return numbers (any shape) as plotly.js unpacks them; infinite ones are left out."""
    small = np.ascontiguousarray(np.where(np.isfinite(values), values, np.nan), dtype="<f4")
    found: dict[str, Any] = {"dtype": "f4", "bdata": base64.b64encode(small.tobytes()).decode()}
    if small.ndim > 1:
        found["shape"] = ", ".join(map(str, small.shape))
    return found


def line(
    x: Array,
    y: Array,
    name: str,
    *,
    colour: str,
    dash: str = "solid",
    shown: bool = True,
    axis: str = "",
    step: bool = False,
) -> Chart:
    """Return a line, thinned.

    Parameters
    ----------
    x, y
        Shape (n,).
    name
        In the legend.
    colour, dash
        Of the line.
    shown
        False to have it in the legend only, until it is clicked.
    axis
        Number of the y axis, "" for the first.
    step
        True for a staircase with the steps midway between the points.
    """
    places, values = envelope(np.asarray(x, float), np.asarray(y, float))
    found: Chart = {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": packed(places),
        "y": packed(values),
        "line": {"color": colour, "width": 1.2, "dash": dash},
        "yaxis": f"y{axis}",
    }
    if step:
        found["line"]["shape"] = "hvh"
    if not shown:
        found["visible"] = "legendonly"
    return found


def heat_map(x: Array, y: Array, z: Array, *, unit: str) -> Chart:
    """Return a field ``z`` (y, x) in colours."""
    return {
        "type": "heatmap",
        "x": packed(x),
        "y": packed(y),
        "z": packed(z),
        "colorscale": "Viridis",
        "zsmooth": False,
        "colorbar": {"title": {"text": unit, "side": "right"}},
    }


def chart(
    traces: Sequence[Chart],
    *,
    x: str,
    y: str,
    height: int = 380,
    x_axis: Mapping[str, Any] | None = None,
    y_axis: Mapping[str, Any] | None = None,
    marks: Mapping[str, float] | None = None,
    shaded: tuple[float, float] | None = None,
) -> Chart:
    """Return a chart with its axes.

    Parameters
    ----------
    traces
        What is drawn.
    x, y
        Titles of the axes.
    height
        In px.
    x_axis, y_axis
        More of the axes, in plotly's words.
    marks
        Upright lines by their names.
    shaded
        Range of x that is grey.
    """
    layout: Chart = {
        "height": height,
        "margin": {"l": 70, "r": 40, "t": 20, "b": 50},
        "font": {"family": "system-ui, sans-serif", "size": 13},
        "plot_bgcolor": "#fff",
        "hovermode": "closest",
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
        "modebar": {"orientation": "v"},
        "xaxis": _axis(x) | dict(x_axis or {}),
        "yaxis": _axis(y) | dict(y_axis or {}),
        "shapes": [],
        "annotations": [],
    }
    if shaded is not None:
        band = {"type": "rect", "xref": "x", "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
        band |= {"x0": shaded[0], "x1": shaded[1], "line": {"width": 0}, "fillcolor": "#f2f2f2"}
        layout["shapes"].append(band)
    logarithmic = layout["xaxis"].get("type") == "log"
    for word, place in (marks or {}).items():
        upright = {"type": "line", "xref": "x", "yref": "paper", "y0": 0, "y1": 1}
        upright |= {"x0": place, "x1": place, "line": {"color": "#999", "width": 1, "dash": "dash"}}
        layout["shapes"].append(upright)
        # On a logarithmic axis an annotation stands at the logarithm, a shape at the value.
        at = float(np.log10(place)) if logarithmic else place
        word_at = {"x": at, "y": 1, "yref": "paper", "text": word, "showarrow": False}
        word_at |= {"textangle": -90, "xanchor": "left", "yanchor": "top"}
        layout["annotations"].append(word_at | {"font": {"size": 11, "color": "#666"}})
    return {"data": list(traces), "layout": layout}


def _axis(title: str) -> Chart:
    return {
        "title": {"text": title},
        "gridcolor": "#e6e6e6",
        "zerolinecolor": "#ccc",
        "linecolor": "#999",
        "automargin": True,
        "exponentformat": "power",
    }
