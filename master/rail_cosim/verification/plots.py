"""Plots of the report, as PNG."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rail_cosim.verification.rows import Curve, Row, Values

# Colours that stay apart for the colour-blind, in print and on screen (Okabe and Ito).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#555555")
_MARKS = ("o", "s", "^", "D")
_SIZE, _DPI = (6.4, 4.0), 130
_DEVIATIONS = "Deviation of each judged value, in tolerances"
_SHOWN = 1.5
_ROW_HEIGHT = 0.155  # inch


def plots(values: Values) -> dict[str, bytes]:
    """Return the pictures by title: all deviations, then one per plot of the curves."""
    judged = [row for row in values.rows if row.limit]
    pictures = {_DEVIATIONS: _png(_deviations(judged))} if judged else {}
    by_title: dict[str, list[Curve]] = {}
    for curve in values.curves:
        by_title.setdefault(curve.plot, []).append(curve)
    return pictures | {title: _png(_lines(curves)) for title, curves in by_title.items()}


def _figure(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DPI)
    return buffer.getvalue()


def _deviations(rows: Sequence[Row]) -> Figure:
    """Deviation over tolerance, a point per row; what is beyond the axis is at its edge."""
    figure, axes = _figure(9.0, 1.0 + _ROW_HEIGHT * len(rows))
    sections = list(dict.fromkeys(row.section for row in rows))
    for place, row in enumerate(rows):
        ratio = row.deviation / (row.limit or math.nan)
        ratio = _SHOWN if math.isnan(ratio) else min(max(ratio, -_SHOWN), _SHOWN)
        colour = _COLOURS[sections.index(row.section) % len(_COLOURS)]
        failed = row.verdict == "FAIL"
        colour, mark = ("#C00000", "X") if failed else (colour, "o")
        axes.plot(ratio, place, mark, color=colour, markersize=6 if failed else 4, clip_on=False)
    axes.axvspan(-1.0, 1.0, color="0.95", zorder=0)
    axes.axvline(0.0, color="0.6", linewidth=0.8)
    axes.set_xlim(-_SHOWN, _SHOWN)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [row.name for row in rows], fontsize=6)
    axes.set_xlabel("deviation / tolerance (shaded: passes)")
    return figure


def _lines(curves: Sequence[Curve]) -> Figure:
    figure, axes = _figure(*_SIZE)
    references = [curve for curve in curves if curve.points]
    lines = [curve for curve in curves if not curve.points]
    for number, curve in enumerate(lines):
        # A line with few values shows them.
        mark = "." if len(curve.x) < 20 else ""
        colour = _COLOURS[number % len(_COLOURS)]
        axes.plot(curve.x, curve.y, color=colour, marker=mark, linewidth=1.2, label=curve.label)
    for number, curve in enumerate(references):
        style = {"markerfacecolor": "none", "color": "0.15", "markersize": 6}
        mark = _MARKS[number % len(_MARKS)]
        axes.plot(curve.x, curve.y, mark, label=curve.label, **style)
    axes.set_xlabel(curves[0].x_label)
    axes.set_ylabel(curves[0].y_label)
    axes.set_ylim(bottom=0.0)
    if len(curves) > 1:
        axes.legend(frameon=False, fontsize=8)
    return figure
