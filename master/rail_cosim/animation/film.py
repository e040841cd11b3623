"""What is recorded during a run for an animation.

Shapes and positions are recorded at every frame. Wheel forces are recorded as their envelope over
all steps: an impact of a millisecond falls between two frames and must not be missed.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError
from rail_cosim.slave import Slave, Vector

Array = NDArray[np.float64]

OPTION = "--animate"
FRAME_RATE = 25.0
"""Frames per second of the animation."""

MOST_FRAMES = 5000
_POINT = re.compile(r"rail_profile\.left\.vertical_displacement\[(\d+)\]")
PROFILES_WANTED = "rail_profile.enabled"
"""Parameter of the track that makes it compute its shapes."""
_EVERY_STEP = ("force", "position")
_FIRST, _SPACING = "rail_profile.first_offset", "rail_profile.spacing"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scene:
    """What does not move against the vehicle or the line, in m; NaN where it is not known.

    Attributes
    ----------
    offsets
        Places of the profiles' points ahead of the leading wheelset, (points,).
    bay, slab, gap
        Fastener spacing, slab pitch, gap between two slabs.
    window
        Length of the window.
    radius, half_wheelbase, half_bogie_spacing
        Of wheels, bogies, car body.
    """

    offsets: Array
    bay: float
    slab: float
    gap: float
    window: float
    radius: float
    half_wheelbase: float
    half_bogie_spacing: float


class Film:
    """Observer that records a frame every few steps, and the wheel forces of all steps.

    The shapes of rails and slabs are local variables of the track, which cost nothing in the
    steps between.

    Parameters
    ----------
    slow_motion
        Seconds of animation per second of the run.

    Attributes
    ----------
    slow_motion
        The same; after :meth:`begin` what comes out with whole steps between two frames.
    scene
        What does not move.
    every
        Macro steps between two frames.
    """

    scene: Scene

    def __init__(self, slow_motion: float) -> None:
        self.slow_motion, self.every = slow_motion, 1
        self._parts: dict[str, Vector] = {}
        self._times: list[float] = []
        self._frames: dict[str, list[Array]] = {}
        self._between: dict[str, list[Array]] = {}
        self._steps = 0

    def begin(
        self, track: Slave, vehicle: Slave, *, wheelsets: int, step_size: float, steps: int
    ) -> None:
        """Get ready to take frames of a run.

        Parameters
        ----------
        track, vehicle
            The initialised slaves.
        wheelsets
            How many there are.
        step_size
            Macro step in s.
        steps
            Macro steps planned.

        Raises
        ------
        ParameterError
            If the track does not give its shapes, or if the animation would be too long.
        """
        self.every = max(1, round(1.0 / (FRAME_RATE * self.slow_motion * step_size)))
        frames = steps // self.every + 1
        if frames > MOST_FRAMES:
            limit = f"the animation would have {frames} frames, at most {MOST_FRAMES} are drawn"
            remedy = "take less, or a shorter distance"
            raise ParameterError("--slow-motion", self.slow_motion, limit, remedy)
        self.slow_motion = 1.0 / (FRAME_RATE * self.every * step_size)
        count = _points(track)
        self.scene = _scene(track, vehicle, count)
        for what in ("rail", "slab"):
            names = [f"{what}_profile.left.vertical_displacement[{k + 1}]" for k in range(count)]
            self._add(what, track, names)
        numbers = range(1, wheelsets + 1)
        self._add("window", track, ["window.start_position"])
        self._add("force", track, [f"wheelset[{i}].left.normal_force" for i in numbers])
        self._add("position", vehicle, [f"wheelset[{i}].longitudinal_position" for i in numbers])
        self._add("wheel", vehicle, [f"wheelset[{i}].vertical_displacement" for i in numbers])
        for name in ("vertical_displacement", "pitch_angle"):
            self._add(f"bogie_{name}", vehicle, [f"bogie[{j}].{name}" for j in (1, 2)])
            self._add(f"car_{name}", vehicle, [f"car_body.{name}"])

    def _add(self, name: str, slave: Slave, variables: Sequence[str]) -> None:
        """Record some variables, if the slave has them all."""
        if all(one in slave.variables for one in variables):
            self._parts[name] = slave.vector(variables)

    def observe(self, time: float) -> None:
        """Record what belongs to this step; ``time`` in s."""
        for name in _EVERY_STEP:
            if name in self._parts:
                self._parts[name].read()
                self._between.setdefault(name, []).append(self._parts[name].values.copy())
        if self._steps % self.every == 0:
            self._record_frame(time)
        self._steps += 1

    def _record_frame(self, time: float) -> None:
        now: dict[str, Array] = {}
        for name, vector in self._parts.items():
            vector.read()
            now[name] = vector.values.copy()
        if "force" in self._parts:
            now["force"], now["force_position"] = self._envelope()
        for name, values in now.items():
            self._frames.setdefault(name, []).append(values)
        self._between.clear()
        self._times.append(time)  # last: an interrupted frame does not count

    def _envelope(self) -> tuple[Array, Array]:
        """Return the smallest, largest and last force of each wheel since the frame before.

        Both the forces and the leading wheelset's positions where they occur have the shape
        (3, wheelsets), in the order of their occurrence.
        """
        force, position = (np.array(self._between[name]) for name in _EVERY_STEP)
        last = np.full(force.shape[1], len(force) - 1)
        rows = np.sort([force.argmin(axis=0), force.argmax(axis=0), last], axis=0)
        return np.take_along_axis(force, rows, axis=0), position[rows, 0]

    @property
    def times(self) -> Array:
        """Instants of the frames in s, (frames,)."""
        return np.array(self._times)

    def frames(self) -> Mapping[str, Array]:
        """Return what was recorded, by name, (frames, ...).

        ``rail`` and ``slab`` (points), ``position``, ``wheel`` (wheelsets), ``window`` (1), the
        envelope of the forces since the frame before, ``force`` at ``force_position``
        (3, wheelsets), and where the vehicle has them ``bogie_vertical_displacement``,
        ``bogie_pitch_angle`` (2), ``car_vertical_displacement``, ``car_pitch_angle`` (1).
        """
        count = len(self._times)
        return {name: np.array(rows[:count]) for name, rows in self._frames.items()}


def check_track(variables: Mapping[str, object], name: str) -> None:
    """Make sure before a run that a track gives the shapes of its rails.

    Raises
    ------
    ParameterError
        If it does not.
    """
    if not any(_POINT.fullmatch(one) for one in variables):
        limit = "has no local variables rail_profile.left.vertical_displacement[1], ..."
        raise ParameterError(OPTION, name, limit, "leave the animation out, or take our track")


def _points(track: Slave) -> int:
    check_track(track.variables, track.name)
    return max(int(m[1]) for one in track.variables if (m := _POINT.fullmatch(one)))


def _scene(track: Slave, vehicle: Slave, count: int) -> Scene:
    def value(slave: Slave, name: str, otherwise: float = math.nan) -> float:
        return float(slave.get([name])[name]) if name in slave.variables else otherwise

    bay = value(track, "fastener.spacing")
    slab = bay * value(track, "fastener.count_per_slab")
    steps = np.arange(count, dtype=np.float64)
    offsets = value(track, _FIRST, 6.0) - value(track, _SPACING, 0.25) * steps
    return Scene(
        offsets=offsets,
        bay=bay,
        slab=slab,
        gap=value(track, "slab.gap", 0.0),
        window=slab * value(track, "window.slab_count"),
        radius=value(vehicle, "wheelset.radius", 0.46),
        half_wheelbase=value(vehicle, "bogie.half_wheelbase"),
        half_bogie_spacing=value(vehicle, "car_body.half_bogie_spacing"),
    )
