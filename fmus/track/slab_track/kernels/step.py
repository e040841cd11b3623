"""A communication step of the track: what Python and the native FMU call."""

import math
from typing import NamedTuple

from rail_native import Array3, Matrix, Vector, kernel

from slab_track.contact.fastsim import FastsimGrid
from slab_track.contact.interaction import (
    Interaction,
    add_lateral,
    combine_symmetry_classes,
    interact,
    report_rails,
    wheel_outputs,
)
from slab_track.contact.tables import ContactTables
from slab_track.contact.wheelset import ContactWork
from slab_track.core import core
from slab_track.irregularity.kernels import IrregularityData, evaluate_into
from slab_track.kernels.arrays import copy
from slab_track.kernels.lateral import LateralConstants, LateralWork, close_rail, free_rail
from slab_track.kernels.motion import LEAST_SPAN, extrapolate, is_too_deep, jumps, push
from slab_track.kernels.shift import ShiftConstants, shift_fields
from slab_track.kernels.state import (
    DATUM,
    POINT_TIME,
    PREVIOUS_TIME,
    TIME,
    WINDOW_START,
    StateArrays,
)
from slab_track.kernels.vertical import (
    VerticalConstants,
    VerticalWork,
    close_step,
    couple_wheels,
    free_step,
)
from slab_track.kernels.waves import shapes_at_wheels

(
    GOOD,
    NOT_FINITE,
    TOO_DEEP,
    JUMPS,
    SHIFT_DUE,
    NEAR_THE_END,
    NO_SOLUTION,
    BEYOND_WINDOW,
) = range(8)
"""What becomes of a step."""


class Settings(NamedTuple):
    """How the track steps.

    Attributes
    ----------
    interface
        APPLIED, VERTICAL or PROFILES (see :mod:`slab_track.contact.interaction`).
    moves_sideways
        False if the rails are held laterally and in roll.
    is_standing
        True if the wheels stand in the window and the irregularity moves.
    shifts_here
        True if the window is shifted within the step; False: ``SHIFT_DUE`` is returned.
    hertz_constant
        Of eq. (1) for VERTICAL, m/N^(2/3).
    half_distance
        Of the rolling circles, m.
    axis_depth
        Of the rails' axes below their heads, m.
    shifts_at
        Mean of the first and the last wheel from the window's start, m, from which on a shift is
        due; infinite if the window stays.
    end_margin
        Nearest that a wheel may come to the window's ends, m; infinitely negative if it stands.
    length, shift
        Of the window, and by how much it moves, m.
    """

    interface: int
    moves_sideways: bool
    is_standing: bool
    shifts_here: bool
    hertz_constant: float
    half_distance: float
    axis_depth: float
    shifts_at: float
    end_margin: float
    length: float
    shift: float


class StepConstants(NamedTuple):
    """All constants of a track for one internal step size.

    Attributes
    ----------
    vertical, lateral, contact, grid, irregularity, shift, settings
        See there.
    step
        Internal step, s.
    count
        Internal steps in a communication step.
    """

    vertical: VerticalConstants
    lateral: LateralConstants
    contact: ContactTables
    grid: FastsimGrid
    irregularity: IrregularityData
    shift: ShiftConstants
    settings: Settings
    step: float
    count: int


class WheelsWork(NamedTuple):
    """Where the wheels are.

    Attributes
    ----------
    positions, in_window
        Of the wheelsets on the line and in the window, (w,), m.
    offsets, slopes
        Irregularity under the wheels, (w, 2, 2).
    shapes
        Of the waves under the wheels, (w, N).
    row
        A motion, (w, 11).
    """

    positions: Vector
    in_window: Vector
    offsets: Array3
    slopes: Array3
    shapes: Matrix
    row: Matrix


class StepWork(NamedTuple):
    """What a step computes on its way; ``at`` is what the rails under the wheels do."""

    vertical: VerticalWork
    lateral: LateralWork
    contact: ContactWork
    at: Interaction
    wheels: WheelsWork


@core.entry
def step(
    vertical: VerticalConstants,
    lateral: LateralConstants,
    contact: ContactTables,
    grid: FastsimGrid,
    irregularity: IrregularityData,
    shift: ShiftConstants,
    settings: Settings,
    h: float,
    count: int,
    vertical_work: VerticalWork,
    lateral_work: LateralWork,
    contact_work: ContactWork,
    at: Interaction,
    wheels_work: WheelsWork,
    now: StateArrays,
    new: StateArrays,
    motion: Matrix,
    timing: Vector,
    applied: Array3,
    is_shifted: bool,
) -> int:
    """Make a communication step from ``now`` to ``new``.

    Parameters
    ----------
    vertical, ..., count
        Constants, see :class:`StepConstants`: one by one, since whatever takes a group out of a
        larger one in numba carries all of that.
    vertical_work, ..., wheels_work
        See :class:`StepWork`.
    now
        State at the start; what comes of it is of no use.
    new
        Written: state at the end. After an error it tells how far the step came.
    motion
        Wheelset motion, (w, 11).
    timing
        Instant of the motion, and end of the step, (2,), s.
    applied
        Forces on the rails' axes for APPLIED, (w, 2, 3).
    is_shifted
        True if a shift that was due has been made.

    Returns
    -------
    int
        GOOD, or why the step is not made.
    """
    head, row, shapes, in_window = (
        new.head,
        wheels_work.row,
        wheels_work.shapes,
        wheels_work.in_window,
    )
    points = new.motion_now, new.motion_before, new.rates_seen
    old_fields, old_lateral, fields, new_lateral = (
        now.vertical,
        now.lateral,
        new.vertical,
        new.lateral,
    )
    wheels, places, wheel_row = new.wheels, new.places, new.row
    positions, offsets, slopes = wheels_work.positions, wheels_work.offsets, wheels_work.slopes
    copy(now.small, new.small)
    ahead = now.head[TIME] + h * count - timing[0]
    found = _take_motion(motion, timing[0], ahead, now.head, now.motion_now, head, points)
    if found != GOOD:
        return found
    ends = _ends_of_path(h, count, head, points, row)
    # Half a millimetre early: how far it shifts is decided by the target.
    is_due = 0.5 * (ends[2] + ends[3]) > head[WINDOW_START] + settings.shifts_at - 5e-4
    if is_due and not is_shifted and not settings.shifts_here:
        return SHIFT_DUE
    if is_due and settings.shifts_here:
        target = shift_target(settings.shifts_at, settings.shift, ends[2], ends[3])
        if not target - head[WINDOW_START] < settings.length:
            return BEYOND_WINDOW
        while target > head[WINDOW_START] + 0.5 * settings.shift:
            shift_fields(shift, old_fields, old_lateral, head, fields, new_lateral)
            copy(new.fields, now.fields)
    first, last = head[WINDOW_START] + settings.end_margin, head[WINDOW_START] + settings.length
    if ends[0] < first or ends[1] > last - settings.end_margin:
        return NEAR_THE_END
    for index in range(count):
        if index > 0:
            copy(new.fields, now.fields)
        head[TIME] += h
        _place_wheels(settings.is_standing, head, points, places, wheel_row, positions, in_window)
        evaluate_into(positions, irregularity, offsets, slopes)
        _free_rails(
            vertical, lateral, settings.moves_sideways, h, old_fields, old_lateral, fields,
            new_lateral, in_window, shapes, vertical_work, lateral_work, at,
        )  # fmt: skip
        if not interact(
            contact, grid, contact_work, settings.interface, settings.half_distance,
            settings.hertz_constant, wheel_row, offsets, applied, at, wheels,
        ):  # fmt: skip
            return NO_SOLUTION
        _close_rails(
            vertical, lateral, settings.moves_sideways, h, old_fields, fields, new_lateral,
            wheels.rail_force, shapes, vertical_work, lateral_work,
        )  # fmt: skip
    head[TIME] = timing[1]
    report_rails(at, contact_work.rail_free, wheels)
    wheel_outputs(wheels, settings.axis_depth, new.outputs)
    # No comparison sees what is not a number: it would pass for a wheel without contact.
    is_good = _is_finite(wheels.wheelset) and _is_finite(new.outputs)
    return GOOD if is_good else NO_SOLUTION


@kernel
def _take_motion(motion, time, ahead, old_head, old_motion, head, points):
    """Take in the wheelsets' motion at an instant; say whether it can be.

    ``ahead`` is the time to the end of the step, s; ``points`` are the last two communication
    points and which rates were seen.
    """
    is_new = time != old_head[POINT_TIME]
    # After a short step before a long one the point before the last is the better one; without
    # it (not a number) there is no choice.
    is_near = time - old_head[POINT_TIME] < LEAST_SPAN * ahead
    keeps = is_new and not (is_near and not math.isnan(old_head[PREVIOUS_TIME]))
    if keeps:
        head[PREVIOUS_TIME] = old_head[POINT_TIME]
    head[POINT_TIME] = time
    if not push(motion, keeps, points[0], points[1], points[2]):
        return NOT_FINITE
    if is_too_deep(motion):
        return TOO_DEEP
    # Until the first step is made there is no motion yet, only a place where the run begins.
    has_moved = not math.isnan(old_head[PREVIOUS_TIME]) or old_head[TIME] > old_head[POINT_TIME]
    if is_new and has_moved and jumps(motion, old_motion, time - old_head[POINT_TIME]):
        return JUMPS
    return GOOD


@kernel
def _motion_at(time, head, points, row):
    """Write the wheelsets' motion at a time, (w, 11)."""
    span = head[POINT_TIME] - head[PREVIOUS_TIME]
    extrapolate(time - head[POINT_TIME], span, points[0], points[1], points[2], row)


@kernel
def _ends_of_path(h, count, head, points, row):
    """Return smallest and largest position of a wheel in the step, and at its end, m."""
    smallest, largest, rear, front = math.inf, -math.inf, math.inf, -math.inf
    for index in range(count):
        _motion_at(head[TIME] + h * (index + 1), head, points, row)
        rear, front = math.inf, -math.inf
        for wheelset in range(row.shape[0]):
            rear, front = min(rear, row[wheelset, 0]), max(front, row[wheelset, 0])
        smallest, largest = min(smallest, rear), max(largest, front)
    return smallest, largest, rear, front


@kernel
def shift_target(shifts_at, shift, rear, front):
    """Return where the window belongs for wheels between ``rear`` and ``front``, m.

    As :func:`slab_track.window.place_window` for a window that follows them.
    """
    middle = 0.5 * (rear + front) - shifts_at
    # A nanometre on: wheels that come to the place of a shift exactly must not be left to rounding.
    return math.floor((middle + 1e-9) / shift + 1.0) * shift


@kernel
def _place_wheels(is_standing, head, points, places, row, positions, in_window):
    """Put the wheels where they are at the end of an internal step."""
    _motion_at(head[TIME], head, points, row)
    for wheel in range(row.shape[0]):
        positions[wheel] = row[wheel, 0]
        in_window[wheel] = places[wheel] if is_standing else row[wheel, 0] - head[WINDOW_START]
        row[wheel, 2] += head[DATUM]


@kernel
def _free_rails(
    vertical, lateral, moves_sideways, h, old, old_lateral, new, new_lateral, in_window, shapes,
    work, lateral_work, at,
):  # fmt: skip
    """Step rails and slabs without wheel forces, and find what these would add."""
    shapes_at_wheels(vertical.wave_number, in_window, shapes)
    couple_wheels(vertical, in_window, work)
    free_step(vertical, old, new, shapes, h, work)
    combine_symmetry_classes(work, at)
    if not moves_sideways:
        return
    aliasing = vertical.aliasing
    free_rail(
        lateral, aliasing, old_lateral[0], shapes, h, lateral_work, new_lateral[0],
        lateral_work.fastener_left, lateral_work.motion_left,
    )  # fmt: skip
    free_rail(
        lateral, aliasing, old_lateral[1], shapes, h, lateral_work, new_lateral[1],
        lateral_work.fastener_right, lateral_work.motion_right,
    )  # fmt: skip
    add_lateral(lateral, in_window, h, lateral_work, at)


@kernel
def _close_rails(
    vertical, lateral, moves_sideways, h, old, new, new_lateral, force, shapes, work, lateral_work
):
    """Add what the forces of wheels and fasteners do."""
    close_step(vertical, old, new, shapes, force, h, work)
    if not moves_sideways:
        return
    aliasing = vertical.aliasing
    close_rail(
        lateral, aliasing, lateral_work.fastener_left, shapes, force, 0, h, lateral_work,
        new_lateral[0],
    )  # fmt: skip
    close_rail(
        lateral, aliasing, lateral_work.fastener_right, shapes, force, 1, h, lateral_work,
        new_lateral[1],
    )  # fmt: skip


@kernel
def _is_finite(values):
    """Whether all numbers of an array are finite."""
    for i in range(values.size):  # noqa: SIM110
        if not math.isfinite(values.flat[i]):
            return False
    return True
