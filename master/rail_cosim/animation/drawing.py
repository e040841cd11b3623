"""The frames of an animation: side view of vehicle and track, the window, the wheel forces.

Vertical displacements are exaggerated, lengths are not. The eye goes with the vehicle: fasteners
and slabs pass below it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from rail_cosim.animation.film import Film, Scene
from rail_cosim.presentation import COLOURS

Array = NDArray[np.float64]
_SIZE = (12.0, 6.0)
_RAIL, _FASTENER, _SLAB = 0.18, 0.16, 0.35  # heights in the picture, m
_HEIGHTS = {"bogie": 0.65, "car": 1.5}  # of the lower edges above the rail, m
_SEEN = 0.35  # m, that the rails' largest deflection has in the picture
_LOWEST, _HIGHEST = -1.35, 4.4
_FINE = 4  # points drawn per point known


def default_exaggeration(film: Film) -> float:
    """Return the factor that makes the largest rail deflection visible: 1, 2 or 5 times 10^n."""
    largest = float(np.abs(film.frames()["rail"]).max())
    if largest <= 0.0:
        return 1.0
    wanted = _SEEN / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(f for f in (1.0, 2.0, 5.0) if f * power <= wanted * (1.0 + 1e-9)) * power)


class Stage:
    """The figure of an animation, set to one frame after the other.

    Parameters
    ----------
    film
        What was recorded.
    exaggeration
        Of vertical displacements.
    """

    def __init__(self, film: Film, exaggeration: float) -> None:
        self._film, self._factor = film, exaggeration
        self._frames: Mapping[str, Array] = film.frames()
        self._scene: Scene = film.scene
        # Rails sink under the vehicle, whose heights count from there.
        self._sunk = float(self._rail_at(0, self._relative(0)).mean())
        self.figure = Figure(figsize=_SIZE, layout="constrained")
        FigureCanvasAgg(self.figure)
        rows = {"height_ratios": [6.0, 1.1, 2.2]}
        self._view, self._strip, self._force = self.figure.subplots(3, 1, gridspec_kw=rows)
        self._make_view()
        self._make_strip()
        self._make_force()
        self._title = self._view.set_title(" ", loc="left", fontsize="medium")
        # Laid out once: else everything would shake, and take three times as long.
        self.show(0)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")

    def show(self, number: int) -> None:
        """Set the figure to a frame (0, 1, ...)."""
        time = float(self._film.times[number])
        position = self._frames["position"][:, 0]
        self._title.set_text(
            f"{1e3 * time:.1f} ms, {position[number] - position[0]:.2f} m; "
            f"slow motion × {self._film.slow_motion:.3g}, "
            f"vertical displacements × {self._factor:g}"
        )
        self._show_track(number)
        self._show_vehicle(number)
        self._show_strip(number)
        self._show_force(number)

    # -- geometry ------------------------------------------------------------

    def _relative(self, number: int) -> Array:
        """Places of the wheelsets against the leading one, m."""
        position = self._frames["position"][number]
        return position - position[0]

    def _rail_at(self, number: int, places: Array) -> Array:
        offsets = self._scene.offsets
        return CubicSpline(offsets[::-1], self._frames["rail"][number][::-1])(places)

    def _fine(self) -> Array:
        offsets = self._scene.offsets
        return np.linspace(offsets[-1], offsets[0], _FINE * len(offsets))

    def _multiples(self, length: float, shift: float, low: float, high: float) -> Array:
        """Places (k + shift) length on the line within low to high, m."""
        if not length > 0.0:
            return np.zeros(0)
        first, last = np.ceil(low / length - shift), np.floor(high / length - shift)
        return (np.arange(first, last + 1.0) + shift) * length

    # -- side view -----------------------------------------------------------

    def _make_view(self) -> None:
        axes, offsets = self._view, self._scene.offsets
        axes.set_xlim(offsets[-1], offsets[0])
        axes.set_ylim(_LOWEST, _HIGHEST)
        axes.set_aspect("equal")
        axes.set_yticks([])
        axes.set_xlabel("position relative to the leading wheelset (m), running direction: right")
        axes.spines[["top", "left", "right"]].set_visible(False)
        self._slabs = PolyCollection([], facecolors="#c4c4c4", edgecolors="#8a8a8a", lw=0.5)
        self._fasteners = LineCollection([], colors="#444", linewidths=2.0)
        self._rail = axes.fill_between([0.0, 1.0], [0.0, 0.0], color="#7a4a2b", lw=0)
        axes.add_collection(self._slabs)
        axes.add_collection(self._fasteners)
        self._wheels = [
            Circle((0.0, 0.0), self._scene.radius, facecolor="#333", edgecolor="white", zorder=4)
            for _ in self._frames["position"][0]
        ]
        self._spokes = [
            Line2D([], [], color="white", lw=1.2, zorder=5) for _ in self._frames["position"][0]
        ]
        self._bodies: dict[str, list[Polygon]] = {"bogie": [], "car": []}
        counts = {"bogie": 2, "car": 1}
        for name, colour in (("car", "#9cc3e6"), ("bogie", "#4d6f8f")):
            if f"{name}_vertical_displacement" in self._frames and self._has_bogies:
                self._bodies[name] = [
                    Polygon(np.zeros((4, 2)), closed=True, facecolor=colour, edgecolor="#345")
                    for _ in range(counts[name])
                ]
        for patch in (*self._bodies["car"], *self._bodies["bogie"], *self._wheels):
            axes.add_patch(patch)
        for spoke in self._spokes:
            axes.add_line(spoke)

    @property
    def _has_bogies(self) -> bool:
        scene = self._scene
        known = np.isfinite([scene.half_wheelbase, scene.half_bogie_spacing]).all()
        return bool(known) and len(self._frames["position"][0]) == 4

    def _show_track(self, number: int) -> None:
        scene, factor = self._scene, self._factor
        leading = float(self._frames["position"][number, 0])
        places = self._fine()
        top = -factor * self._rail_at(number, places)
        self._rail.remove()
        self._rail = self._view.fill_between(
            places, top - _RAIL, top, color="#7a4a2b", lw=0, zorder=3
        )
        slab = -factor * np.interp(places, scene.offsets[::-1], self._frames["slab"][number][::-1])
        slab -= _RAIL + _FASTENER
        low, high = leading + places[0], leading + places[-1]
        seats = self._multiples(scene.bay, 0.5, low, high) - leading
        ends = np.interp(seats, places, top - _RAIL), np.interp(seats, places, slab)
        self._fasteners.set_segments(
            [[(x, a), (x, b)] for x, a, b in zip(seats, *ends, strict=True)]
        )
        shapes = []
        for middle in self._multiples(scene.slab, 0.5, low - scene.slab, high + scene.slab):
            half = 0.5 * (scene.slab - scene.gap)
            inside = (places > middle - leading - half) & (places < middle - leading + half)
            x, y = places[inside], slab[inside]
            if x.size > 1:
                outline = np.stack([np.r_[x, x[::-1]], np.r_[y, y[::-1] - _SLAB]], axis=1)
                shapes.append(outline)
        self._slabs.set_verts(shapes)

    def _show_vehicle(self, number: int) -> None:
        scene, frames = self._scene, self._frames
        places = self._relative(number)
        heights = -self._factor * (self._sunk + frames["wheel"][number])
        travelled = frames["position"][number] - frames["position"][0]
        for wheel, spoke, x, y, way in zip(
            self._wheels, self._spokes, places, heights, travelled, strict=True
        ):
            wheel.center = (x, y + scene.radius)
            turn = -way / scene.radius
            tip = 0.8 * scene.radius * np.array([np.cos(turn), np.sin(turn)])
            middle = y + scene.radius
            spoke.set_data([x - tip[0], x + tip[0]], [middle - tip[1], middle + tip[1]])
        centres = {
            "car": [places.mean()],
            "bogie": [places.mean() + s * scene.half_bogie_spacing for s in (1, -1)],
        }
        reach = {
            "car": scene.half_bogie_spacing + 3.2,
            "bogie": scene.half_wheelbase + 0.5 * scene.radius,
        }
        tall = {"car": 2.3, "bogie": 0.45}
        for name, bodies in self._bodies.items():
            for j, body in enumerate(bodies):
                down = self._sunk + frames[f"{name}_vertical_displacement"][number, j]
                pitch = frames[f"{name}_pitch_angle"][number, j] if self._pitches(name) else 0.0
                x = np.array([-1.0, 1.0, 1.0, -1.0]) * reach[name]
                y = _HEIGHTS[name] + np.array([0.0, 0.0, 1.0, 1.0]) * tall[name]
                # Positive pitch lifts the front.
                body.set_xy(
                    np.stack([centres[name][j] + x, y - self._factor * (down - pitch * x)], axis=1)
                )

    def _pitches(self, name: str) -> bool:
        return f"{name}_pitch_angle" in self._frames

    # -- the window on the line ----------------------------------------------

    def _make_strip(self) -> None:
        axes = self._strip
        axes.set_ylim(-1.0, 1.0)
        axes.set_yticks([])
        axes.set_xlabel("position along the line (m)")
        axes.spines[["top", "left", "right"]].set_visible(False)
        self._joints = LineCollection([], colors="#999", linewidths=1.0)
        axes.add_collection(self._joints)
        self._window = Rectangle((0.0, -0.55), 0.0, 1.1, facecolor="#E69F00", alpha=0.25)
        axes.add_patch(self._window)
        (self._train,) = axes.plot([], [], "o", color="#333", markersize=5)
        self._told = axes.text(0.0, 0.6, "", fontsize="small", color="#7a5200", va="bottom")

    def _show_strip(self, number: int) -> None:
        scene = self._scene
        position = self._frames["position"][number]
        reach = 1.25 * scene.window if scene.window > 0.0 else 80.0
        middle = float(position.mean())
        low, high = middle - 0.5 * reach, middle + 0.5 * reach
        self._strip.set_xlim(low, high)
        joints = self._multiples(scene.slab, 0.0, low, high)
        self._joints.set_segments([[(x, -0.4), (x, 0.4)] for x in joints])
        self._train.set_data(position, np.zeros_like(position))
        if "window" in self._frames and scene.window > 0.0:
            start = float(self._frames["window"][number, 0])
            self._window.set_bounds(start, -0.55, scene.window, 1.1)
            self._told.set_text(f"window, {start:.1f} m to {start + scene.window:.1f} m")
            self._told.set_x(start)

    # -- forces ----------------------------------------------------------------

    def _make_force(self) -> None:
        axes = self._force
        travelled = self._frames["position"][:, 0] - self._frames["position"][0, 0]
        force = self._frames.get("force")
        axes.set_xlabel("distance travelled (m)")
        axes.set_ylabel("wheel force (kN)")
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_xlim(0.0, max(float(travelled[-1]), 1e-3))
        self._lines: list[Line2D] = []
        if force is None:
            axes.set_yticks([])
            return
        low, high = float(force.min()) / 1e3, float(force.max()) / 1e3
        margin = 0.05 * (high - low) + 1e-3
        axes.set_ylim(low - margin, high + margin)
        for i in range(force.shape[2]):
            self._lines += _line(axes, COLOURS[i % len(COLOURS)], f"wheelset {i + 1}, left")
        place = {"loc": "lower left", "bbox_to_anchor": (0.0, 0.95)}
        axes.legend(**place, ncols=4, fontsize="x-small", frameon=False)

    def _show_force(self, number: int) -> None:
        for i, drawn in enumerate(self._lines):
            position = self._frames["force_position"][: number + 1, :, i].ravel()
            force = self._frames["force"][: number + 1, :, i].ravel()
            drawn.set_data(position - self._frames["position"][0, 0], force / 1e3)


def _line(axes: Axes, colour: str, label: str) -> list[Line2D]:
    return axes.plot([], [], color=colour, lw=1.0, label=label)
