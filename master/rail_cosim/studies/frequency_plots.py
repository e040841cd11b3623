"""Figures of the track's frequency view."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import ScalarFormatter

_DPI = 200
_BLUE, _RED, _GREEN, _GREY = "#0072B2", "#D55E00", "#009E73", "0.45"  # Okabe and Ito
_GRID = {"visible": True, "which": "both", "lw": 0.3, "color": "0.85"}
_PLACES = {"mid_bay": ("mid-bay", "-"), "fastener": ("over a fastener", "--")}
_MN, _KMH = 1e-6, 3.6
_REACH = 3.5  # m of the line shown on either side of the wheelset
_DRAWN = 0.25  # height of a deflection of 1 in the mode's drawing


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plot_receptance(dataset: xr.Dataset, path: Path) -> None:
    """Draw magnitude and phase over frequency: vertical left, lateral right."""
    figure = _figure(9.0, 5.6)
    axes = figure.subplots(2, 2, sharex=True, height_ratios=[2.0, 1.0])
    curves = (
        (0, "same_rail", "same rail", _BLUE),
        (0, "next_wheel", f"same rail, {dataset.attrs['axle_distance']:g} m on", _GREEN),
        (0, "other_rail", "other rail", _RED),
        (1, "lateral", "head, per lateral force at it", _BLUE),
    )
    frequency = dataset["frequency"].to_numpy()
    for column, name, label, colour in curves:
        if not (dataset[f"{name}_magnitude"] > 0.0).all():
            continue
        for place, (word, style) in _PLACES.items():
            row = dataset.sel(place=place)
            line = {"color": colour, "ls": style, "lw": 1.2, "label": f"{label}, {word}"}
            axes[0, column].loglog(frequency, row[f"{name}_magnitude"], **line)
            if name in ("same_rail", "lateral"):
                phase = np.degrees(np.unwrap(row[f"{name}_phase"].to_numpy()))
                axes[1, column].semilogx(frequency, phase, **line)
    pinned = dataset.attrs["pinned_pinned_frequency"]
    for axis in axes[:, 0]:
        axis.axvline(pinned, color=_GREY, lw=0.8, ls=":")
    axes[0, 0].annotate(
        f"pinned-pinned\n{pinned:.0f} Hz", (pinned, 0.03), xycoords=("data", "axes fraction"),
        xytext=(-3, 0), textcoords="offset points", ha="right", va="bottom", fontsize=8,
        color=_GREY,
    )  # fmt: skip
    axes[0, 0].set_title("vertical", loc="left", fontsize=10)
    axes[0, 1].set_title("lateral", loc="left", fontsize=10)
    for axis in axes[0]:
        axis.set_ylabel("receptance (m/N)")
        if not axis.lines:
            axis.text(0.5, 0.5, "rails held laterally", transform=axis.transAxes, ha="center")
            continue
        low, high = axis.get_ylim()
        axis.set_ylim(low * 0.02, high)  # room for the legend
        axis.legend(frameon=False, fontsize=7, loc="lower left")
    for axis in axes[1]:
        axis.set_ylabel("phase (deg)")
        axis.set_xlabel("frequency (Hz)")
    for axis in axes.flat:
        axis.grid(**_GRID)
        axis.set_xlim(frequency[0], frequency[-1])
        axis.xaxis.set_major_formatter(ScalarFormatter())
    figure.savefig(path, dpi=_DPI)


def plot_p2(dataset: xr.Dataset, article: Mapping[float, tuple[float, float]], path: Path) -> None:
    """Draw P2 frequency and damping ratio over the stiffness of the fasteners."""
    figure = _figure(8.4, 6.4)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1.0])
    pads = dataset["pad_stiffness"].to_numpy() * _MN
    bay = dataset.attrs["spacing"]
    upper.plot(
        pads, dataset["formula_frequency"], "-", color="k", lw=1.2, label=f"(16), bay {bay:g} m"
    )
    upper.plot(
        pads, dataset["formula_article_frequency"], ":", color="k", lw=1.2,
        label=f"(16), bay {dataset.attrs['article_bay']:.2f} m",
    )  # fmt: skip
    x = [pad * _MN for pad in article]
    upper.plot(x, [f for f, _ in article.values()], "kx", ms=6, label="article, in the text")
    for name, label, colour in (
        ("rigid_contact", "coupled, rigid contact", _GREEN),
        ("hertz", "coupled, Hertz spring", _BLUE),
        ("primary", "coupled, Hertz spring and primary suspension", _RED),
    ):
        for axis, what in ((upper, "frequency"), (lower, "damping_ratio")):
            values = dataset[f"{name}_{what}"]
            low, high = values.min("place"), values.max("place")
            # From mid-bay to over a fastener: the frequency changes along each bay.
            axis.fill_between(pads, low, high, color=colour, alpha=0.35, lw=0, label=label)
            axis.plot(pads, values.mean("place"), color=colour, lw=0.8)
    upper.set_ylabel("P2 frequency (Hz)")
    upper.set_title(
        "bands: wheelset from mid-bay to over a fastener", loc="left", fontsize=9, color=_GREY
    )
    upper.legend(frameon=False, fontsize=8, loc="upper left")
    factor = _KMH * bay
    speed = upper.secondary_yaxis("right", functions=(lambda f: f * factor, lambda v: v / factor))
    speed.set_ylabel("speed of resonance (km/h)")
    lower.set_ylabel("damping ratio")
    lower.set_xlabel("stiffness of one fastener (MN/m)")
    lower.set_ylim(0.0)
    for axis in (upper, lower):
        axis.grid(**_GRID)
        axis.set_xlim(pads[0], pads[-1])
    figure.savefig(path, dpi=_DPI)


def plot_mode(dataset: xr.Dataset, path: Path) -> None:
    """Draw the mode as the article's Fig. 10 does, and its amplitudes along the line."""
    pads = dataset["pad_stiffness"].to_numpy()
    figure = _figure(4.6 * max(2, len(pads)), 4.6 if len(pads) > 1 else 6.4)
    axes = figure.subplots(2, len(pads), squeeze=False, sharex=True, height_ratios=[1.0, 1.8])
    for column, pad in enumerate(pads):
        mode = dataset.sel(pad_stiffness=pad)
        _draw_mode(axes[0, column], mode)
        _draw_amplitudes(axes[1, column], mode)
        axes[0, column].set_title(
            f"{_MN * pad:g} MN/m: {float(mode['natural_frequency']):.1f} Hz, "
            f"damping ratio {float(mode['damping_ratio']):.3f}",
            loc="left",
            fontsize=10,
        )
        axes[1, column].set_xlabel("distance from the wheelset (m)")
    axes[1, 0].set_ylabel("amplitude over wheelset's")
    axes[1, 0].legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=_DPI)


def _real(mode: xr.Dataset, name: str) -> np.ndarray:
    return (mode[f"{name}_magnitude"] * np.cos(mode[f"{name}_phase"])).to_numpy()


def _draw_mode(axis: Axes, mode: xr.Dataset) -> None:
    """Side view at the instant of the wheelset's largest deflection, downwards as drawn."""
    x, z = mode["rail_position"].to_numpy(), -_DRAWN * _real(mode, "rail")
    at, seat = mode["fastener_position"].to_numpy(), -_DRAWN * _real(mode, "seat")
    rail_level, slab_level, radius = 0.0, -0.45, 0.46
    seen = np.abs(x) <= _REACH
    axis.plot(x[seen], np.full(seen.sum(), rail_level), ":", color=_GREY, lw=0.7)
    axis.plot(x[seen], rail_level + z[seen], color=_BLUE, lw=2.2, label="rail")
    on_rail = rail_level + np.interp(at, x, z)
    for place, top, bottom in zip(at, on_rail, slab_level + seat, strict=True):
        if abs(place) <= _REACH:
            axis.plot(*_spring(place, top, bottom), color=_GREEN, lw=0.7)
    slabs = -_DRAWN * _real(mode, "slab")[0]
    for place, shape in zip(mode["slab_position"].to_numpy(), slabs, strict=True):
        inside = np.abs(place) <= _REACH
        top = slab_level + shape[inside]
        axis.fill_between(place[inside], top - 0.16, top, color="0.75", ec=_GREY, lw=0.6)
    for centre, style, colour in ((radius, ":", _GREY), (radius - _DRAWN, "-", "k")):
        axis.add_patch(Circle((0.0, centre), radius, fill=False, ls=style, ec=colour, lw=1.0))
    axis.plot([0.0], [radius - _DRAWN], "k.", ms=4)
    axis.annotate(
        "", (0.0, radius - _DRAWN), (0.0, radius),
        arrowprops={"arrowstyle": "->", "color": _RED, "lw": 1.4},
    )  # fmt: skip
    axis.set_xlim(-_REACH, _REACH)
    axis.set_ylim(-0.7, 0.97)
    axis.set_aspect("equal", adjustable="box")
    axis.set_yticks([])
    for side in ("left", "right", "top"):
        axis.spines[side].set_visible(False)


def _spring(x: float, top: float, bottom: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of a zigzag."""
    along = np.array([0.0, 0.2, 0.3, 0.45, 0.6, 0.75, 0.8, 1.0])
    across = np.array([0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    return x + 0.07 * across, top + along * (bottom - top)


def _draw_amplitudes(axis: Axes, mode: xr.Dataset) -> None:
    axis.plot(mode["rail_position"], mode["rail_magnitude"], color=_BLUE, lw=1.4, label="rail")
    axis.plot(
        mode["fastener_position"], mode["fastener_magnitude"], "o", color=_GREEN, ms=3.5, mfc="w",
        label="compression of fasteners",
    )  # fmt: skip
    axis.plot(
        mode["fastener_position"], mode["seat_magnitude"], "s", color=_GREY, ms=3,
        label="slab at the seats",
    )  # fmt: skip
    axis.plot([0.0], [1.0], "k^", ms=5, label="wheelset")
    axis.set_ylim(0.0, 1.05)
    axis.grid(**_GRID)
