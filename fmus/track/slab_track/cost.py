"""What the parts of a step cost: ``python -m slab_track.cost --json``.

The wheelsets stand at their static heights and run over the line at constant speed. Each part is
repeated in compiled code on the state that has come about, without what is around it. CPU time,
the least of several rounds; of slides that come after many steps each.
"""

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rail_quantities import ParameterError

from slab_track.errors import TrackError
from slab_track.frequency.__main__ import apply_settings
from slab_track.kernels.shift import shift_window
from slab_track.model import TrackModel
from slab_track.motion import MOTION
from slab_track.parameters import TrackParameters
from slab_track.presets import LINES
from slab_track.stepper import March

_PROGRAM = "slab_track.cost"
_CALLS, _ROUNDS, _WARM_UP = 100, 15, 300
_SLIDES, _BETWEEN = 41, 50


def step_cost(
    parameters: TrackParameters, *, speed: float = 300.0 / 3.6, step: float = 1e-4
) -> dict[str, float]:
    """Measure what a communication step costs.

    Parameters
    ----------
    parameters
        Of the track; with ``contact.model = profiles``.
    speed
        Of the wheelsets, m/s.
    step
        Communication step, s.

    Returns
    -------
    dict
        Microseconds per step: ``total``; of it ``rails`` (rails, slabs and fasteners under given
        forces), ``contact`` (what the contact adds), ``slide`` (its cost over the steps between
        two). ``slide_each``: one shift of the window. ``slide_share``: its part of the total (1).
    """
    model = TrackModel(parameters)
    whole = _cost(model, speed, step)
    driven = _cost(TrackModel(parameters.replace(interface="applied_force")), speed, step)
    each = _shift_cost(model, speed, step) if parameters.moves else 0.0
    slide = each / (parameters.slide_length / (speed * step))
    return {
        "rails": driven,
        "contact": whole - driven,
        "slide": slide,
        "total": whole + slide,
        "slide_each": each,
        "slide_share": slide / (whole + slide),
    }


def _cost(model: TrackModel, speed: float, step: float) -> float:
    """Least CPU time of a step among several rounds, us."""
    march, motion = _run(model, speed, step)

    def steps() -> None:
        march.step(motion, step)
        motion[:, 0] += speed * step

    return _least(steps, _CALLS)


def _shift_cost(model: TrackModel, speed: float, step: float) -> float:
    """Least CPU time of a shift after steps, which leave nothing of it in the caches, us."""
    march, motion = _run(model, speed, step)
    stepper, times = model.stepper, []
    constants = stepper.constants(step)
    old = model.layout.arrays(march.vector.copy())
    new = model.layout.arrays(march.vector.copy())
    shift = shift_window.bind(
        constants.shift, old.vertical, old.lateral, new.head, new.vertical, new.lateral
    )
    for _ in range(_SLIDES):
        for _ in range(_BETWEEN):
            march.step(motion, step)
            motion[:, 0] += speed * step
        start = time.process_time()
        shift()
        times.append(time.process_time() - start)
    return 1e6 * min(times)


def _run(model: TrackModel, speed: float, step: float) -> tuple[March, np.ndarray]:
    """Return a track that has run a while, and the wheelsets' motion."""
    motion = np.zeros((model.parameters.wheelset_count, len(MOTION)))
    motion[:, 0], motion[:, 5] = model.default_positions(), speed
    motion[:, 10] = -speed / model.parameters.contact.wheel_radius
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    march = model.stepper.march(model.with_motion(state, motion))
    applied = np.zeros((motion.shape[0], 2, 3))
    applied[:, :, 1] = model.parameters.static_wheel_load
    march.step(motion, step, applied_force=applied)  # they stay
    for _ in range(_WARM_UP):
        march.step(motion, step)
        motion[:, 0] += speed * step
    return march, motion


def _least(work: Callable[[], Any], calls: int) -> float:
    """Least CPU time of a call among several rounds, us."""
    least = math.inf
    for _ in range(_ROUNDS):
        start = time.process_time()
        for _ in range(calls):
            work()
        least = min(least, time.process_time() - start)
    return 1e6 * least / calls


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog=f"python -m {_PROGRAM}", description=__doc__)
    add = parser.add_argument
    add("--line", default="HD", choices=tuple(LINES), help="parameter set of the track")
    add("--track", action="append", default=[], metavar="NAME=VALUE", help="a parameter")
    add("--speed", type=float, default=300.0, help="km/h")
    add("--step", type=float, default=1e-4, help="communication step, s")
    add("--json", action="store_true", help="print JSON")
    options = parser.parse_args(arguments)
    try:
        track = apply_settings(LINES[options.line], ["contact.model=profiles", *options.track])
        parts = step_cost(track, speed=options.speed / 3.6, step=options.step)
    except (ParameterError, TrackError) as error:
        print(f"{_PROGRAM}: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, ParameterError) else 1
    if options.json:
        print(json.dumps(parts))
        return 0
    for name, value in parts.items():
        unit = "" if name == "slide_share" else " us"
        print(f"{name:18s}{value:10.3g}{unit}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
