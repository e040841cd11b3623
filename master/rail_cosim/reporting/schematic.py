"""Schematic of vehicle and window, drawn to scale as SVG."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from rail_cosim.window import periods

_WIDTH = 1000.0  # px
_VERTICAL = 10.0  # px/m: heights only, along the line the window fills the width


class Geometry(NamedTuple):
    """What the schematic needs, in m; not a number or empty where it is not known.

    Attributes
    ----------
    wheels
        Positions of the wheelsets at the start, (wheelsets,).
    radius
        Of the wheels.
    bogies
        Positions of the bogies' centres, (bogies,).
    half_wheelbase
        Of a bogie.
    window
        Rear and front end at the start.
    bay, slab, gap
        Fastener spacing, slab pitch, gap between slabs.
    """

    wheels: np.ndarray
    radius: float
    bogies: np.ndarray
    half_wheelbase: float
    window: tuple[float, float]
    bay: float
    slab: float
    gap: float


def geometry(run: xr.Dataset) -> Geometry:
    """Return what a run tells of its geometry."""
    about = run.attrs
    wheels = np.zeros(0)
    if "wheelset_longitudinal_position" in run:
        wheels = run["wheelset_longitudinal_position"].isel(time=0).to_numpy().astype(float)
    bay, slab = periods(run)
    half = float(about.get("vehicle.bogie.half_wheelbase", math.nan))
    between = float(about.get("vehicle.car_body.half_bogie_spacing", math.nan))
    bogies = np.zeros(0)
    if len(wheels) == 4 and not math.isnan(between):
        bogies = wheels.mean() + np.array([between, -between])
    window = (math.nan, math.nan)
    if "window_start_position" in run and slab > 0.0:
        start = float(run["window_start_position"].to_numpy()[0])
        window = start, start + slab * int(about.get("track.window.slab_count", 0))
    return Geometry(
        wheels=wheels,
        radius=float(about.get("vehicle.wheelset.radius", 0.46)),
        bogies=bogies,
        half_wheelbase=half,
        window=window,
        bay=bay,
        slab=slab,
        gap=float(about.get("track.slab.gap", 0.0)),
    )


def drawing(found: Geometry) -> str:
    """Return the schematic as SVG; empty if not even the wheels are known."""
    if len(found.wheels) == 0:
        return ""
    low, high = found.window
    if not high > low:
        low, high = found.wheels.min() - 8.0, found.wheels.max() + 8.0
    scale = _WIDTH / (high - low)
    picture = _Picture(low, scale)
    _draw_track(picture, found, low, high)
    _draw_vehicle(picture, found)
    return picture.svg(_caption(found))


class _Picture:
    """Shapes in px; x from positions in m, y upwards from the rails in px."""

    base = 95.0
    height = 165.0

    def __init__(self, low: float, scale: float) -> None:
        self._low, self.scale, self._shapes = low, scale, []

    def x(self, position: float) -> float:
        return (position - self._low) * self.scale

    def box(
        self, begin: float, end: float, bottom: float, top: float, fill: str, round_: float = 0.0
    ) -> None:
        x, width = self.x(begin), (end - begin) * self.scale
        self._shapes.append(
            f'<rect x="{x:.1f}" y="{self.base - top:.1f}" width="{width:.1f}" '
            f'height="{top - bottom:.1f}" rx="{round_:g}" fill="{fill}"/>'
        )

    def circle(self, position: float, up: float, radius: float, fill: str) -> None:
        self._shapes.append(
            f'<circle cx="{self.x(position):.1f}" cy="{self.base - up:.1f}" r="{radius:.1f}" '
            f'fill="{fill}" stroke="#fff"/>'
        )

    def text(self, position: float, up: float, words: str, anchor: str = "middle") -> None:
        self._shapes.append(
            f'<text x="{self.x(position):.1f}" y="{self.base - up:.1f}" text-anchor="{anchor}" '
            f'font-size="12" fill="#555">{words}</text>'
        )

    def arrow(self, position: float, up: float) -> None:
        x, y = self.x(position), self.base - up
        self._shapes.append(
            f'<path d="M{x:.1f} {y:.1f}h40m-9 -5l9 5l-9 5" fill="none" stroke="#555" '
            'stroke-width="1.5"/>'
        )

    def svg(self, caption: str) -> str:
        return (
            f'<svg viewBox="0 0 {_WIDTH:.0f} {self.height:.0f}" role="img" '
            f'aria-label="{caption}" xmlns="http://www.w3.org/2000/svg" '
            'font-family="system-ui, sans-serif">' + "".join(self._shapes) + "</svg>"
        )


def _draw_track(picture: _Picture, found: Geometry, low: float, high: float) -> None:
    if found.slab > 0.0:
        first, last = math.floor(low / found.slab + 1e-6), math.ceil(high / found.slab - 1e-6)
        for number in range(first, last):
            begin = max(low, number * found.slab + 0.5 * found.gap)
            end = min(high, (number + 1) * found.slab - 0.5 * found.gap)
            picture.box(begin, end, -18.0, -8.0, "#b8b8b8")
    if found.bay > 0.0:
        for number in range(math.ceil(low / found.bay - 0.5), math.floor(high / found.bay + 0.5)):
            place = (number + 0.5) * found.bay
            if low < place < high:
                picture.box(place - 0.1, place + 0.1, -8.0, -4.0, "#555")
    picture.box(low, high, -4.0, 0.0, "#7a4a2b")
    if found.window[1] > found.window[0]:
        front, rear = found.wheels.max(), found.wheels.min()
        for begin, end in ((low, rear), (front, high)):
            picture.text(0.5 * (begin + end), -36.0, f"{end - begin:.1f} m")
            picture.box(begin, end, -23.5, -22.5, "#888")
        picture.text(0.5 * (low + high), -58.0, f"sliding window of {high - low:.1f} m")


def _draw_vehicle(picture: _Picture, found: Geometry) -> None:
    # A circle stays one: the height in px per m follows the scale along the line.
    wheel = found.radius * picture.scale
    if len(found.bogies) == 2 and not math.isnan(found.half_wheelbase):
        for centre in found.bogies:
            reach = found.half_wheelbase + found.radius
            picture.box(centre - reach, centre + reach, wheel, 1.9 * wheel, "#4d6f8f", 2.0)
        rear, front = found.bogies.min() - 4.0, found.bogies.max() + 4.0
        picture.box(rear, front, 2.2 * wheel, 2.2 * wheel + 3.0 * _VERTICAL, "#9cc3e6", 8.0)
        picture.text(0.5 * (rear + front), 2.2 * wheel + 1.2 * _VERTICAL, "car body")
    for number, place in enumerate(found.wheels, start=1):
        picture.circle(place, wheel, wheel, "#333")
        picture.text(place, -33.0, str(number))
    picture.arrow(found.wheels.max() + 5.0, 3.0 * wheel)


def _caption(found: Geometry) -> str:
    words = f"{len(found.wheels)} wheelsets"
    if found.window[1] > found.window[0]:
        words += f" in a window of {found.window[1] - found.window[0]:.1f} m"
    return words
