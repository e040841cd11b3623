"""The rail before and after a slide, for several ways of solving eq. (10), as JSON.

``python -m slab_track.slide_study slide --line paper --out slide.json``: the wheelsets' static
loads run over the line at constant speed; at the second slide the rail's deflection and
acceleration are moved by each way. All values are in SI units.
"""

import argparse
import json
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.linalg
from rail_quantities import ParameterError, flatten

from slab_track.contact import ContactParameters
from slab_track.errors import TrackError
from slab_track.frequency.__main__ import apply_settings
from slab_track.model import TrackModel, TrackState
from slab_track.motion import MOTION
from slab_track.parameters import TrackParameters
from slab_track.presets import LINES
from slab_track.slide import sample_points, slide_operator, slide_rail

_PROGRAM = "slab_track.slide_study"
_STEP = 1e-4  # s
_SLIDES = 2
_LEFT_OUT = 5  # segments at the end without a sample point
_POINTS, _QUICK_POINTS = 2001, 501  # along the window, for the plot and the largest jump


class Rail(NamedTuple):
    """The left rail just before a slide.

    Attributes
    ----------
    model, state
        The track, which slides in the next step.
    wheels
        Places of the wheelsets in the window, m.
    """

    model: TrackModel
    state: TrackState
    wheels: np.ndarray

    def field(self, coordinates: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return deflection, velocity and acceleration at ``x``, (3, x), from (3, 2, N)."""
        linear = self.model.linear
        waves = np.sum(linear.participation * coordinates, axis=1)
        return np.sqrt(0.5) * waves @ linear.wave_shapes(x)


def way_points(name: str, length: float, count: int, samples: int) -> np.ndarray:
    """Return the sample points of a way to solve eq. (10), m, for ``count`` modes."""
    return {
        "least_squares": sample_points(length, samples),
        "middle": sample_points(length, count),
        "hinges": np.linspace(0.0, length, count),
        "end_left_out": np.arange(1, count + 1) * length / (count + _LEFT_OUT),
    }[name]


WAYS = ("least_squares", "middle", "hinges", "end_left_out")
"""Least squares, and the square system with sample points at the middle of equal segments, from
hinge to hinge, and equally spaced without the last of the window."""


def run_to_slide(parameters: TrackParameters, speed: float) -> Rail:
    """Let the static loads run at ``speed`` m/s until the next step would slide."""
    model = TrackModel(parameters)
    row = np.zeros((parameters.wheelset_count, len(MOTION)))
    row[:, 0], row[:, 5] = model.default_positions(), speed
    force = np.zeros((parameters.wheelset_count, 2, 3))
    force[:, :, 1] = parameters.static_wheel_load
    state = model.initial_state(row)
    while True:
        after, _ = model.step(state, row, _STEP, applied_force=force)
        if after.slide_count == _SLIDES:
            return Rail(model, state, row[:, 0] - state.window_start)
        state, row = after, row.copy()
        row[:, 0] += speed * _STEP


def slide_table(
    parameters: TrackParameters, speed: float, *, quick: bool = False
) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """Return single figures, and arrays over way of solving and place.

    ``target`` is the old field moved, eq. (9); ``after`` what the new coordinates give. The wheel
    force changes as Hertz's law has it when the rail under the wheel jumps.
    """
    rail = run_to_slide(parameters, speed)
    p, modes = rail.model.parameters, rail.model.linear.rail
    length, pitch, old = p.window_length, p.slide_length, rail.state.symmetric.rail
    x = np.linspace(0.0, length, _QUICK_POINTS if quick else _POINTS)
    target = np.where(x + pitch <= length, rail.field(old, np.minimum(x + pitch, length)), 0.0)
    under = rail.field(old, rail.wheels)[0]
    count = p.rail_mode_count
    after, jumps, condition, turning = [], [], [], []
    for name in WAYS:
        points = way_points(name, length, count, p.sample_count)
        new = _moved(rail, name, points)
        after.append(rail.field(new, x)[[0, 2]])
        jumps.append(np.max(np.abs(rail.field(new, rail.wheels - pitch)[0] - under)))
        condition.append(np.linalg.cond(modes.waves.shapes(points)))
        turning.append(np.linalg.cond(modes.waves.rotation_shapes(points)))
    force, constant = p.static_wheel_load, p.contact.hertz_constant_used
    approach = constant * force ** (2.0 / 3.0)
    jump = np.array(jumps)
    columns = {
        "place": x,
        "target": target[[0, 2]],
        "after": np.array(after),
        "condition_number": np.array(condition),
        "rotation_condition_number": np.array(turning),
        "jump_at_wheels": jump,
        "wheel_force_jump": ((approach + jump) / constant) ** 1.5 - force,
    }
    about = {"mode_count": count, "time": rail.state.time, "speed": speed, "pitch": pitch}
    return about, columns


def _moved(rail: Rail, name: str, points: np.ndarray) -> np.ndarray:
    """Return the coordinates after the slide; not a number if eq. (10) has no solution."""
    p, old = rail.model.parameters, rail.state.symmetric.rail
    with warnings.catch_warnings():
        # That the system is ill-conditioned is what is to be seen.
        warnings.simplefilter("ignore", scipy.linalg.LinAlgWarning)
        try:
            operator = slide_operator(
                rail.model.linear.rail,
                length=p.window_length,
                shift=p.slide_length,
                sample_count=points.size,
                solver="least_squares" if name == "least_squares" else "triangular",
                points=points,
            )
        except scipy.linalg.LinAlgError:
            return np.full_like(old, np.nan)
    return slide_rail(rail.model.linear.rail, operator, old)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog=f"python -m {_PROGRAM}", description=__doc__)
    add = parser.add_argument
    add("table", choices=("slide",), help="what to compute")
    add("--line", default="HD", choices=tuple(LINES), help="parameter set of the track")
    add("--track", action="append", default=[], metavar="NAME=VALUE", help="a parameter")
    add("--speed", type=float, default=300.0, help="km/h")
    add("--quick", action="store_true", help="fewer places along the window")
    add("--out", type=Path, required=True, help="JSON file to write")
    options = parser.parse_args(arguments)
    try:
        track = apply_settings(LINES[options.line], options.track)
        track = track.replace(
            interface="applied_force", contact=ContactParameters(model="vertical")
        )
        about, columns = slide_table(track, options.speed / 3.6, quick=options.quick)
    except (ParameterError, TrackError) as error:
        print(f"{_PROGRAM}: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, ParameterError) else 1
    used = {name: value for name, (_, value) in flatten(track).items()}
    values = {name: column.tolist() for name, column in columns.items()}
    content = {"about": about, "parameters": used, "columns": values}
    options.out.write_text(json.dumps(content), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
