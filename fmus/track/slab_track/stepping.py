"""The whole track over an internal step, in compiled code."""

import math
from typing import NamedTuple

import numpy as np
from rail_quantities.uncounted import flat, on_stack, shaped

from slab_track.compiled import entry, kernel
from slab_track.contact.fastsim import FastsimGrid
from slab_track.contact.tables import ContactTables
from slab_track.halves import half_size
from slab_track.interaction import (
    Interaction,
    add_lateral,
    answer,
    interact,
    put_together,
    report_rails,
)
from slab_track.irregularity.kernels import IrregularityData, evaluate_into
from slab_track.lateral_step import LateralConstants, close_rail, free_rail
from slab_track.motion import LEAST_SPAN, extrapolate, is_too_deep, jumps, push, reach
from slab_track.oscillators import copy
from slab_track.room import Room
from slab_track.state import (
    ANSWER,
    ANSWERS,
    DATUM,
    FASTENER_FORCE,
    LATERAL,
    MOTION_BEFORE,
    MOTION_NOW,
    PLACES,
    POINT_TIME,
    PREVIOUS_TIME,
    RATES_SEEN,
    ROW,
    TIME,
    WHEELSET,
    WINDOW_START,
)
from slab_track.vertical import (
    ClassOperator,
    FreeStep,
    RailOperator,
    WheelCoupling,
    close_class_step,
    free_class_step,
    wheel_coupling,
)
from slab_track.views import class_fields, class_force, part, side_force, wheels_of
from slab_track.wheel_shapes import wheel_shapes

GOOD, NOT_FINITE, TOO_DEEP, JUMPS, SLIDE_DUE, NEAR_THE_END, NO_SOLUTION = range(7)
"""What becomes of a step."""


class WindowLimits(NamedTuple):
    """Where the wheels may be.

    Attributes
    ----------
    slides_at
        Mean of the first and the last wheel from the window's start, m, from which on a slide is to
        be looked at; infinite if the window stays.
    margin
        Nearest that a wheel may come to the window's ends, m; infinitely negative if it stands.
    length
        Of the window, m.
    standing
        True if the wheels stand in the window and the irregularity moves.
    """

    slides_at: float
    margin: float
    length: float
    standing: bool


class Settings(NamedTuple):
    """What the contact and the internal step take besides their tables.

    Attributes
    ----------
    interface
        APPLIED, VERTICAL or PROFILES.
    moves_sideways
        False if the rails are held laterally and in roll.
    hertz_constant
        Of eq. (1) for VERTICAL, m/N^(2/3).
    half_distance
        Of the rolling circles, m.
    axis_depth
        Of the rails' axes below their heads, m.
    step
        Internal step, s.
    """

    interface: int
    moves_sideways: bool
    hertz_constant: float
    half_distance: float
    axis_depth: float
    step: float


class Scratch(NamedTuple):
    """Room for what is made and used within a step; no state.

    Attributes
    ----------
    path
        Wheelset motion at the end of each internal step, (steps, w, 11).
    x, places
        Wheelsets on the line and in the window, (w,), m.
    offsets, slopes
        Irregularity under the wheels, (w, 2, 2).
    shapes
        Of the waves under the wheels, (w, N).
    taken
        Of both rails, see :func:`slab_track.lateral_step.free_rail`, (2, 2, 2h).
    motion
        Of both rails, see there, (2, w, 4).
    room
        For what only one function uses.
    """

    path: np.ndarray
    x: np.ndarray
    places: np.ndarray
    offsets: np.ndarray
    slopes: np.ndarray
    shapes: np.ndarray
    taken: np.ndarray
    motion: np.ndarray
    room: Room

    @classmethod
    def empty(
        cls, steps: int, wheels: int, waves: int, fasteners: int, slab_modes: int
    ) -> "Scratch":
        """Return room for steps, wheelsets, waves, fasteners and modes of all slabs."""
        half = half_size(fasteners)
        return cls(
            path=np.empty((steps, wheels, 11)),
            x=np.empty(wheels),
            places=np.empty(wheels),
            offsets=np.empty((wheels, 2, 2)),
            slopes=np.empty((wheels, 2, 2)),
            shapes=np.empty((wheels, waves)),
            taken=np.empty((2, 2, 2 * half)),
            motion=np.empty((2, wheels, 4)),
            room=Room.empty(wheels, waves, fasteners, slab_modes),
        )


class TrackOperator(NamedTuple):
    """All constants of a track for one communication step.

    Attributes
    ----------
    rail, symmetric, antisymmetric
        Vertical motion of the rails, and of both classes.
    lateral
        Lateral motion and torsion of either rail.
    contact, grid
        Tables of the contact, grid of FASTSIM.
    irregularity
        What :func:`slab_track.irregularity.kernels.evaluate_into` takes.
    settings, limits
        See there.
    starts
        Of the parts of the state, see :class:`slab_track.state.StateLayout`.
    scratch, coupling, free_s, free_a, at
        Room for what is made within a step.
    """

    rail: RailOperator
    symmetric: ClassOperator
    antisymmetric: ClassOperator
    lateral: LateralConstants
    contact: ContactTables
    grid: FastsimGrid
    irregularity: IrregularityData
    settings: Settings
    limits: WindowLimits
    starts: np.ndarray
    scratch: Scratch
    coupling: WheelCoupling
    free_s: FreeStep
    free_a: FreeStep
    at: Interaction


@kernel
def _take_motion(op, old, new, motion, time):
    """Copy what the wheels remember, take in their motion; say whether it can be.

    ``time`` is that of the motion, s.
    """
    starts, count = op.starts, motion.shape[0]
    end = starts[FASTENER_FORCE]
    copy(old[:end], new[:end])
    is_new = time != old[POINT_TIME]
    # After a short step before a long one the point before the last is the better one; without
    # it (not a number) there is no choice.
    ahead = old[TIME] + op.settings.step * op.scratch.path.shape[0] - time
    is_near = time - old[POINT_TIME] < LEAST_SPAN * ahead and not math.isnan(old[PREVIOUS_TIME])
    keeps = is_new and not is_near
    if keeps:
        new[PREVIOUS_TIME] = old[POINT_TIME]
    new[POINT_TIME] = time
    if not push(
        motion,
        keeps,
        shaped(new, starts[MOTION_NOW], (count, 11)),
        shaped(new, starts[MOTION_BEFORE], (count, 11)),
        part(new, starts, RATES_SEEN),
    ):
        return NOT_FINITE
    if is_too_deep(motion):
        return TOO_DEEP
    # Until the first step is made there is no motion yet, only a place where the run begins.
    moved = not math.isnan(old[PREVIOUS_TIME]) or old[TIME] > old[POINT_TIME]
    before = shaped(old, starts[MOTION_NOW], (count, 11))
    if is_new and moved and jumps(motion, before, time - old[POINT_TIME]):
        return JUMPS
    return GOOD


@kernel
def _make_path(op, new, path):
    """Fill the motion at the end of each internal step, (steps, wheelsets, 11)."""
    starts, count = op.starts, path.shape[1]
    now = shaped(new, starts[MOTION_NOW], (count, 11))
    before = shaped(new, starts[MOTION_BEFORE], (count, 11))
    ahead, span = new[TIME] - new[POINT_TIME], new[POINT_TIME] - new[PREVIOUS_TIME]
    for n in range(path.shape[0]):
        tau = ahead + op.settings.step * (n + 1)
        extrapolate(tau, span, now, before, part(new, starts, RATES_SEEN), path[n])


@kernel
def _check_places(limits, start, may_slide, path):
    """Say whether a slide is due, or a wheel too near to an end of the window."""
    ends = on_stack(4)
    reach(path, ends)
    # Half a millimetre early: whether it slides is decided outside.
    if may_slide and 0.5 * (ends[2] + ends[3]) > start + limits.slides_at - 5e-4:
        return SLIDE_DUE
    if ends[0] < start + limits.margin or ends[1] > start + limits.length - limits.margin:
        return NEAR_THE_END
    return GOOD


@kernel
def _place_wheels(op, new, turn):
    """Put the wheels where they are at the end of an internal step."""
    starts, scratch, limits = op.starts, op.scratch, op.limits
    count = scratch.x.size
    row = shaped(new, starts[ROW], (count, 11))
    copy(flat(scratch.path[turn]), flat(row))
    for wheel in range(count):
        scratch.x[wheel] = row[wheel, 0]
        scratch.places[wheel] = row[wheel, 0] - new[WINDOW_START]
        if limits.standing:
            scratch.places[wheel] = new[starts[PLACES] + wheel]
        row[wheel, 2] += new[DATUM]
    evaluate_into(scratch.x, op.irregularity, scratch.offsets, scratch.slopes)


@entry
def advance(op, old, new, motion, time, may_slide, applied, turn):
    """Make an internal step.

    At the start of a communication step the wheelsets' motion is taken in before, and it is seen
    where it leads.

    Parameters
    ----------
    op
        Reference to a :class:`TrackOperator`.
    old, new
        Vector of the state at the start, and the one that is to receive the state at the end;
        for further internal steps it is what the one before left, and ``old`` a copy of it.
    motion
        Wheelset motion at the instant ``time`` (s), (wheelsets, 11).
    may_slide
        False to go on where a slide is due.
    applied
        Forces on the rails' axes for APPLIED, (wheels, 2, 3).
    turn
        Number of the internal step, 0 for the first one; after the last one the state's answers
        are written.

    Returns
    -------
    int
        GOOD, or why the step cannot be made.
    """
    found = _begin(op, old, new, motion, time, may_slide, turn)
    return found if found != GOOD else _finish(op, old, new, applied, turn)


@kernel
def _begin(op, old, new, motion, time, may_slide, turn):
    """Step rails and slabs without wheel forces to the end of an internal step."""
    if turn == 0:
        found = _take_motion(op, old, new, motion, time)
        if found != GOOD:
            return found
        _make_path(op, new, op.scratch.path)
        found = _check_places(op.limits, new[WINDOW_START], may_slide, op.scratch.path)
        if found != GOOD:
            return found
    starts, settings, rail, scratch = op.starts, op.settings, op.rail, op.scratch
    step, shapes, places = settings.step, scratch.shapes, scratch.places
    new[TIME] = old[TIME] + step
    _place_wheels(op, new, turn)
    fasteners = (starts[FASTENER_FORCE + 1] - starts[FASTENER_FORCE]) // 2
    wheel_shapes(rail.wave_number, places, shapes)
    coupling, free_s, free_a = op.coupling, op.free_s, op.free_a
    wheel_coupling(rail, places, scratch.room.fasteners, coupling)
    fields = class_fields(old, new, starts, 0, fasteners)
    free_class_step(rail, op.symmetric, fields, coupling, shapes, step, scratch.room, free_s)
    fields = class_fields(old, new, starts, 1, fasteners)
    free_class_step(rail, op.antisymmetric, fields, coupling, shapes, step, scratch.room, free_a)
    put_together(free_s, free_a, op.at)
    lateral, size = starts[LATERAL], (starts[LATERAL + 1] - starts[LATERAL]) // 2
    if not settings.moves_sideways:
        copy(old[lateral : lateral + 2 * size], new[lateral : lateral + 2 * size])
        return GOOD
    for side in range(2):
        first = lateral + side * size
        free_rail(
            op.lateral, rail.folding, shaped(old, first, (3, size // 3)), shapes, step,
            shaped(new, first, (3, size // 3)), scratch.taken[side], scratch.motion[side],
            scratch.room,
        )  # fmt: skip
    add_lateral(op.lateral, places, step, scratch.motion, op.at)
    return GOOD


@kernel
def _finish(op, old, new, applied, turn):
    """Find the forces between wheels and rails, and add what they and the fasteners do."""
    count, starts = op.scratch.x.size, op.starts
    row = shaped(new, starts[ROW], (count, 11))
    wheels = wheels_of(new, starts, count)
    if not interact(
        op.contact, op.grid, op.settings, row, op.scratch.offsets, applied, op.at, wheels
    ):
        return NO_SOLUTION
    settings, rail = op.settings, op.rail
    step, shapes = settings.step, op.scratch.shapes
    force = wheels.rail_force
    fasteners = (starts[FASTENER_FORCE + 1] - starts[FASTENER_FORCE]) // 2
    room = op.scratch.room
    own = room.forces[0]
    class_force(force, 1.0, own)
    fields = class_fields(old, new, starts, 0, fasteners)
    close_class_step(rail, op.symmetric, fields, op.free_s, shapes, own, step, room)
    class_force(force, -1.0, own)
    fields = class_fields(old, new, starts, 1, fasteners)
    close_class_step(rail, op.antisymmetric, fields, op.free_a, shapes, own, step, room)
    begin, size = starts[LATERAL], (starts[LATERAL + 1] - starts[LATERAL]) // 2
    if settings.moves_sideways:
        for side in range(2):
            first = begin + side * size
            side_force(force, side, room.forces)
            close_rail(
                op.lateral, rail.folding, op.scratch.taken[side], shapes, room.forces, step, room,
                shaped(new, first, (3, size // 3)),
            )  # fmt: skip
    if turn == op.scratch.path.shape[0] - 1:
        report_rails(op.at, wheels)
        answer(wheels, settings.axis_depth, shaped(new, starts[ANSWER], (ANSWERS, count, 2)))
        # No comparison sees what is no number: it would pass for a wheel without contact.
        for place in range(starts[WHEELSET], starts[ANSWER + 1]):
            if not math.isfinite(new[place]):
                return NO_SOLUTION
    return GOOD
