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
from rail_quantities.uncounted import on_stack, shaped

from slab_track.compiled import entry
from slab_track.contact.wheelset import NORMAL_FORCE, locate_wheel, patch_forces
from slab_track.errors import TrackError
from slab_track.frequency.__main__ import apply_settings
from slab_track.interaction import interact
from slab_track.model import TrackModel, TrackState
from slab_track.motion import MOTION
from slab_track.oscillators import add_force, product, step_damped
from slab_track.parameters import TrackParameters
from slab_track.presets import LINES
from slab_track.state import ROW
from slab_track.stepping import advance
from slab_track.views import class_fields, wheels_of

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
        Of the track; with ``contact.model = profiles``, and one internal step per step.
    speed
        Of the wheelsets, m/s.
    step
        Communication step, s.

    Returns
    -------
    dict
        Microseconds per step: ``total``; of it ``rails`` (vertical, lateral, torsion, fasteners,
        coupling with the wheels), ``slabs``, ``contact_geometry`` (location of patches, Hertz),
        ``fastsim`` (with creepages), ``forces`` (wheels and rails solved together, without these
        two), ``slide`` (its cost over the steps between two), ``python`` (the rest).
        ``slide_each``: one slide. ``slide_share``: part of the slide in the total (1).
    """
    model = TrackModel(parameters)
    state, motion = _run(model, speed, step)
    operator, steps, _ = model.stepper.operator(step)
    new, none = state.vector.copy(), np.zeros((parameters.wheelset_count, 2, 3))

    advance(operator, state.vector, new, motion, state.time, False, none, 0)
    parts = {
        "contact_geometry": _compiled(_locate, operator, new),
        "fastsim": _compiled(_creep, operator, new),
        "slabs": _compiled(_slabs, operator, state.vector, new),
    }
    touching = _compiled(_touch, operator, new, none)
    moving = _repeated(
        lambda: advance(operator, state.vector, new, motion, state.time, False, none, 0)
    )
    parts["rails"] = moving - touching - parts["slabs"]
    parts["forces"] = touching - parts["contact_geometry"] - parts["fastsim"]
    whole = steps * _repeated(lambda: model.step(state, motion, step))

    def steps_between() -> None:
        for _ in range(_BETWEEN):
            model.step(state, motion, step)

    each = 0.0
    if parameters.moves:
        each = _once(lambda: model.stepper.slide_once(state), steps_between)
    between = parameters.slide_length / (speed * step)
    parts = {name: steps * value for name, value in parts.items()}
    parts["python"] = whole - sum(parts.values())
    parts["slide"] = each / between if each else 0.0
    parts["total"] = whole + parts["slide"]
    share = parts["slide"] / parts["total"]
    return parts | {"slide_each": each, "slide_share": share}


def _run(model: TrackModel, speed: float, step: float) -> tuple[TrackState, np.ndarray]:
    motion = np.zeros((model.parameters.wheelset_count, len(MOTION)))
    motion[:, 0], motion[:, 5] = model.default_positions(), speed
    motion[:, 10] = -speed / model.parameters.contact.wheel_radius
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    state = model.with_motion(state, motion)
    for _ in range(_WARM_UP):
        state, _ = model.step(state, motion, step)
        motion[:, 0] += speed * step
    return state, motion


def _once(work: Callable[[], Any], others: Callable[[], None]) -> float:
    """Least CPU time of a call after ``others``, which leave nothing of it in the caches, us."""
    work()
    times = []
    for _ in range(_SLIDES):
        others()
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e6 * min(times)


def _repeated(work: Callable[[], Any], calls: int = _CALLS) -> float:
    """Least CPU time of a call among several rounds, us."""
    work()
    least = math.inf
    for _ in range(_ROUNDS):
        start = time.process_time()
        for _ in range(calls):
            work()
        least = min(least, time.process_time() - start)
    return 1e6 * least / calls


def _compiled(loop: Callable[..., None], *arguments: Any) -> float:
    """Least CPU time of a pass of a compiled loop, us."""
    return _repeated(lambda: loop(_CALLS, *arguments), 1) / _CALLS


@entry
def _locate(passes, op, new):
    """Locate the patches of all wheels."""
    count = op.scratch.x.size
    wheels, row = wheels_of(new, op.starts, count), shaped(new, op.starts[ROW], (count, 11))
    offset = on_stack(2)
    offset[0] = offset[1] = 0.0
    for _ in range(passes):
        for wheel in range(count):
            for side in range(2):
                locate_wheel(
                    op.contact, 2.0 * side - 1.0, row[wheel], wheels.rail[wheel, side], offset,
                    wheels.located[wheel, side],
                )  # fmt: skip


@entry
def _touch(passes, op, new, applied):
    """Find the forces between wheels and rails."""
    count = op.scratch.x.size
    wheels, row = wheels_of(new, op.starts, count), shaped(new, op.starts[ROW], (count, 11))
    for _ in range(passes):
        interact(op.contact, op.grid, op.settings, row, op.scratch.offsets, applied, op.at, wheels)


@entry
def _creep(passes, op, new):
    """Creepages and FASTSIM of all patches."""
    count = op.scratch.x.size
    wheels, row = wheels_of(new, op.starts, count), shaped(new, op.starts[ROW], (count, 11))
    for _ in range(passes):
        for wheel in range(count):
            for side in range(2):
                for patch in range(2):
                    out = wheels.forces[wheel, side, patch]
                    patch_forces(
                        op.contact, op.grid, row[wheel], wheels.rail[wheel, side],
                        wheels.located[wheel, side, patch], out[NORMAL_FORCE], out,
                    )  # fmt: skip


@entry
def _slabs(passes, op, old, new):
    """Free step of the slabs of both classes, their seats, and the answer to fastener forces."""
    starts, step = op.starts, op.settings.step
    fasteners = op.rail.damping.size
    for _ in range(passes):
        for symmetry in range(2):
            own = op.symmetric if symmetry == 0 else op.antisymmetric
            fields = class_fields(old, new, starts, symmetry, fasteners)
            step_damped(fields.old_slab, own.slab_softening, own.slab_drag, step, fields.new_slab)
            modes, count = own.seats.shape
            slabs = fasteners // count
            seats, modal = op.scratch.room.fasteners, op.scratch.room.slabs
            moved, force = shaped(seats, 0, (slabs, count)), shaped(modal, 0, (slabs, modes))
            product(shaped(fields.new_slab, 0, (slabs, modes)), own.seats, moved)
            product(moved, own.from_seats, force)
            all_modal = shaped(modal, 0, (slabs * modes,))
            add_force(fields.new_slab, 0, own.slab_weight, all_modal, step)


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
