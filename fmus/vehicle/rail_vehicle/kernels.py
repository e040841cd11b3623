"""The step of the vehicle over plain arrays: kernels of the compiled core.

State vector (104): coordinates and rates of the linear system (90), pitch angles (4) and pitch
rates (4) of the wheelsets, yaw damper forces (4), position of the car body, its speed. The
equations are those of :mod:`rail_vehicle.equations`.
"""

import math
from typing import NamedTuple

import numpy as np
from rail_native import Indices, Matrix, Vector, kernel

from rail_vehicle.core import core
from rail_vehicle.linear_system import FORCE_COUNT, INTERNAL_COUNT, SIGNAL_COUNT, STATE_COUNT

PITCH_ANGLES = STATE_COUNT
PITCH_RATES = STATE_COUNT + 4
DAMPER_FORCES = STATE_COUNT + 8
POSITION = STATE_COUNT + 12
SPEED = STATE_COUNT + 13
VECTOR_COUNT = STATE_COUNT + 14

RESULT_COUNT = VECTOR_COUNT + FORCE_COUNT + 1 + INTERNAL_COUNT
"""Length of what outputs are made of: state, contact forces, acceleration, internal forces."""

GOOD, NOT_FOUND, BEYOND, NOT_FOLLOWED = range(4)
"""What :func:`step` says: done; internal forces not found, or a number is not finite; a number of
the state beyond its limit; forces that do not follow from those before."""

_INPUT_COUNT = 3 * FORCE_COUNT + 1 + INTERNAL_COUNT
_MAX_ITERATIONS = 60


class Operators(NamedTuple):
    """Matrices of one internal step, stored by columns (transposed).

    Attributes
    ----------
    known
        To the new state from (old state 90, force at start 24, at end 24, quadratic term 24,
        frame acceleration 1, internal forces at start 16), (179, 90).
    internal
        To the new state from the internal forces at the end, (16, 90).
    signals
        To the signals from the state, (90, 24).
    feedback
        To the signals from the internal forces at the end, (16, 24).
    """

    known: Matrix
    internal: Matrix
    signals: Matrix
    feedback: Matrix


class Laws(NamedTuple):
    """Constants of the non-linear elements, SI units."""

    yaw_damping: float
    yaw_blow_off_force: float
    yaw_blow_off_damping: float
    yaw_series_stiffness: float
    lateral_damping: float
    lateral_blow_off_force: float
    lateral_blow_off_damping: float
    stop_clearance: float
    stop_stiffness: float
    stop_cubic_stiffness: float


class Constants(NamedTuple):
    """What a step takes besides its operators.

    Attributes
    ----------
    laws
        Of the non-linear elements.
    spin_inertia
        Of a wheelset about its axle, kg m2.
    rolling_spin
        Pitch rate at the parameter ``speed``, rad/s; its gyroscopic moments are in the operators.
    static_force
        Vertical contact force of a wheelset at rest, N.
    acceleration_limit
        Of the longitudinal constraint of the car body, m/s2.
    limits
        Largest absolute value of each number of the state, (104,), SI units.
    output_offsets, output_values, output_columns, output_rows
        Outputs ``offsets + rows @ result``, the rows stored sparsely.
    """

    laws: Laws
    spin_inertia: float
    rolling_spin: float
    static_force: float
    acceleration_limit: float
    limits: Vector
    output_offsets: Vector
    output_values: Vector
    output_columns: Indices
    output_rows: Indices


class Workspace(NamedTuple):
    """Memory for what is computed within a step; no state."""

    state: Vector
    signals: Vector
    inputs: Vector
    new_state: Vector
    new_signals: Vector
    end_signals: Vector
    found_forces: Vector
    excess_momentum: Vector
    force_start: Vector
    force_end: Vector
    result: Vector
    force: Matrix


def workspace() -> Workspace:
    """Return a workspace."""
    sizes = (VECTOR_COUNT, SIGNAL_COUNT, _INPUT_COUNT, STATE_COUNT, SIGNAL_COUNT, SIGNAL_COUNT)
    sizes += (INTERNAL_COUNT, 4, FORCE_COUNT, FORCE_COUNT, RESULT_COUNT)
    return Workspace(*(np.zeros(size) for size in sizes), force=np.zeros((3, FORCE_COUNT)))


# Linear algebra


@kernel
def copy_into(target, first, source):
    """Write ``source`` into ``target`` from index ``first`` on."""
    for index in range(source.size):
        target[first + index] = source[index]


@kernel
def set_zero(array):
    """Fill an array with zeros."""
    for index in range(array.size):
        array[index] = 0.0


@kernel
def add_product(matrix, first, vector, result):
    """Add ``matrix[first:first + n].T @ vector`` to ``result``, four columns at a time."""
    whole = vector.size - vector.size % 4
    for column in range(0, whole, 4):
        a, b, c, d = vector[column], vector[column + 1], vector[column + 2], vector[column + 3]
        row = first + column
        for index in range(result.size):
            result[index] += (
                matrix[row, index] * a
                + matrix[row + 1, index] * b
                + matrix[row + 2, index] * c
                + matrix[row + 3, index] * d
            )
    for column in range(whole, vector.size):
        for index in range(result.size):
            result[index] += matrix[first + column, index] * vector[column]


# Force laws


@kernel
def blow_off_force(rate, damping, limit, damping_after):
    """Force of a dashpot that blows off at the force ``limit``, N; ``rate`` in m/s."""
    force = damping * rate
    if abs(force) <= limit:
        return force
    return math.copysign(limit + damping_after * (abs(rate) - limit / damping), rate)


@kernel
def stop_force(elongation, clearance, stiffness, cubic):
    """Force of a stop with free play to both sides, N; ``elongation`` in m."""
    depth = abs(elongation) - clearance
    if depth <= 0.0:
        return 0.0
    return math.copysign(depth * (stiffness + cubic * depth * depth), elongation)


@kernel
def maxwell_force(force, rate, duration, spring, damping, limit, damping_after):
    """Force after ``duration`` of a blow-off dashpot in series with a spring.

    The ends part at the constant ``rate``. On each branch of the dashpot
    ``F' = spring (rate - v(F))`` is linear and solved exactly; when the force
    reaches the blow-off limit the rest of the time is spent on the next branch.
    Exact for constant rate, and stable whatever ``duration * spring / damping``.
    """
    left = duration
    for _ in range(4):
        # A force on the limit belongs to the branch it is about to enter.
        sign = math.copysign(1.0, force)
        at_limit = abs(abs(force) - limit) <= 1e-12 * limit
        growing = sign * rate > limit / damping
        outside = growing if at_limit else abs(force) > limit
        factor = damping_after if outside else damping
        offset = sign * limit * (1.0 / damping - 1.0 / damping_after) if outside else 0.0
        target = factor * (rate - offset)
        end = target + (force - target) * math.exp(-spring * left / factor)
        barrier = sign * limit
        if not outside and abs(end) > limit:
            barrier = math.copysign(limit, end)
        elif not outside or sign * end >= limit:
            return end
        left += factor / spring * math.log((barrier - target) / (force - target))
        force = barrier
        if left <= 0.0:
            return force
    return force


@kernel
def internal_forces(laws, momentum, damper_forces, start, end, duration, forces):
    """Write element forces (8) and gyroscopic moments (8) at the end of a step.

    ``start`` and ``end`` are the signals (24,): elongations, their rates, roll and yaw rates of
    the wheelsets; ``momentum`` (4,) is that of :func:`excess_momentum`; a ``duration`` of 0 gives
    the forces at the start.
    """
    for index in range(4):
        forces[index] = damper_forces[index]
        if laws.yaw_damping > 0.0 and duration > 0.0:
            forces[index] = maxwell_force(
                damper_forces[index],
                (end[index] - start[index]) / duration,
                duration,
                laws.yaw_series_stiffness,
                laws.yaw_damping,
                laws.yaw_blow_off_force,
                laws.yaw_blow_off_damping,
            )
    for index in range(4, 6):
        forces[index] = blow_off_force(
            end[8 + index],
            laws.lateral_damping,
            laws.lateral_blow_off_force,
            laws.lateral_blow_off_damping,
        )
    for index in range(6, 8):
        forces[index] = stop_force(
            end[index], laws.stop_clearance, laws.stop_stiffness, laws.stop_cubic_stiffness
        )
    for index in range(4):
        forces[8 + index] = momentum[index] * end[20 + index]
        forces[12 + index] = -momentum[index] * end[16 + index]


@kernel
def excess_momentum(constants, state, momentum):
    """Write the angular momentum of the wheelsets beyond that of the parameter ``speed``, (4,)."""
    for index in range(4):
        spin = state[PITCH_RATES + index] - constants.rolling_spin
        momentum[index] = constants.spin_inertia * spin


# Contact forces over a communication step (see :mod:`rail_vehicle.coupling`)

HISTORY_COUNT = 6 + 3 * FORCE_COUNT
"""Length of a force history: how many values it holds, their ages (3), s, the values, newest first,
and the extrapolation errors (see :class:`rail_vehicle.coupling.ForceHistory`)."""

PARABOLA_ERROR, LINE_ERROR = HISTORY_COUNT - 2, HISTORY_COUNT - 1

LEAST_SPAN = 0.5
"""Shortest time from the start of a step back to a value that its polynomial uses, in parts of the
step, as long as there are earlier ones."""

AVERAGING_STEPS = 200
"""Steps over which the extrapolation errors are averaged."""

LARGEST_RATIO = 1.3
"""Of the error of the parabola to that of the line. For a wave of ``n`` steps it is
``2 sin(pi / n)``: 1.3 for 4.4. The waves of an unstable coupling have 4.05 or less."""

_AGES, _VALUES = 1, 4


@kernel
def take_force(history, newest, elapsed, duration, at_end, unit):
    """Take in forces (24,) ``elapsed`` seconds after the newest, for a step of ``duration`` s.

    The value before the start of the step is left out where it is near and there is another: the
    parabola would magnify its error with the ratio of the times.
    """
    before = 1 if at_end else 0
    distance = history[_AGES + 1] if at_end else elapsed
    is_near = 0.0 < distance < LEAST_SPAN * duration and history[0] > before + 1.0
    if is_near and at_end:
        forget_force(history, before)
    if elapsed > 0.0 and history[0] > 2.0:
        compare_force(history, newest, elapsed, unit)
    if is_near and not at_end:
        forget_force(history, before)
    append_force(history, newest, elapsed)


@kernel
def compare_force(history, newest, elapsed, unit):
    """Add the distances of a value from parabola and line through those before to the errors."""
    before, earlier, parabola, line = history[_AGES + 1], history[_AGES + 2], 0.0, 0.0
    for column in range(FORCE_COUNT):
        last = history[_VALUES + column]
        second = history[_VALUES + FORCE_COUNT + column]
        third = history[_VALUES + 2 * FORCE_COUNT + column]
        slope = (last - second) / before
        curvature = (slope - (second - third) / (earlier - before)) / earlier
        miss = (newest[column] - last - elapsed * slope) / unit[column]
        line += miss * miss
        miss -= elapsed * (elapsed + before) * curvature / unit[column]
        parabola += miss * miss
    parabola, line = math.sqrt(6.0 * parabola / FORCE_COUNT), math.sqrt(6.0 * line / FORCE_COUNT)
    scale = 1.0 / max(1.0, parabola)
    history[PARABOLA_ERROR] += (scale * parabola - history[PARABOLA_ERROR]) / AVERAGING_STEPS
    history[LINE_ERROR] += (scale * line - history[LINE_ERROR]) / AVERAGING_STEPS


@kernel
def alternates(history, largest_error):
    """Whether the values turn from step to step, so that no polynomial follows them."""
    error = history[PARABOLA_ERROR]
    return error > largest_error and error > LARGEST_RATIO * history[LINE_ERROR]


@kernel
def forget_force(history, value):
    """Forget a value, 0 for the newest; those before it stay."""
    history[0] -= 1.0
    for later in range(value, 2):
        history[_AGES + later] = history[_AGES + later + 1]
        for column in range(FORCE_COUNT):
            place = _VALUES + FORCE_COUNT * later + column
            history[place] = history[place + FORCE_COUNT]


@kernel
def append_force(history, newest, elapsed):
    """Take in forces (24,) ``elapsed`` seconds after the newest; 0 replaces these."""
    if elapsed > 0.0:
        history[0] = min(3.0, history[0] + 1.0)
        for value in range(2, 0, -1):
            history[_AGES + value] = history[_AGES + value - 1] + elapsed
            for column in range(FORCE_COUNT):
                place = _VALUES + FORCE_COUNT * value + column
                history[place] = history[place - FORCE_COUNT]
    history[_AGES] = 0.0
    for column in range(FORCE_COUNT):
        history[_VALUES + column] = newest[column]


@kernel
def force_over_step(history, duration, order, at_end, force):
    """Write the polynomial through the newest values: start, end and quadratic term, (3, 24).

    Newton's divided differences; the newest value is that of the step's end or of its start.
    """
    count = min(order + 1, int(history[0]))
    before, earlier = history[_AGES + 1], history[_AGES + 2]
    for column in range(FORCE_COUNT):
        newest = history[_VALUES + column]
        second = history[_VALUES + FORCE_COUNT + column]
        slope, curvature = 0.0, 0.0
        if count > 1:
            slope = (newest - second) / before
        if count > 2:
            other = second - history[_VALUES + 2 * FORCE_COUNT + column]
            curvature = (slope - other / (earlier - before)) / earlier
        if at_end:
            force[0, column] = second if count > 1 else newest
            force[1, column] = newest
        else:
            reach = duration + (before if history[0] > 1.0 else 0.0)
            force[0, column] = newest
            force[1, column] = newest + duration * (slope + reach * curvature)
        force[2, column] = duration * duration * curvature


# The step


@kernel
def fill_inputs(inputs, start, end, quadratic, part, count):
    """Write the contact forces of the ``part``-th of ``count`` equal parts of the interval.

    The first 72 entries become the forces at its start and end and its quadratic term.
    """
    left, right = part / count, (part + 1) / count
    for index in range(FORCE_COUNT):
        slope = end[index] - start[index]
        inputs[index] = start[index] + slope * left + quadratic[index] * left * (left - 1.0)
        inputs[FORCE_COUNT + index] = (
            start[index] + slope * right + quadratic[index] * right * (right - 1.0)
        )
        inputs[2 * FORCE_COUNT + index] = quadratic[index] / (count * count)


@kernel
def spin_wheelsets(state, inputs, step, inertia):
    """Integrate pitch angles and rates under the contact's pitch moments, in place."""
    for index in range(4):
        column = 6 * index + 4
        start, end = inputs[column], inputs[FORCE_COUNT + column]
        quadratic = inputs[2 * FORCE_COUNT + column]
        twice = start / 3.0 + end / 6.0 - quadratic / 12.0
        once = 0.5 * (start + end) - quadratic / 6.0
        state[PITCH_ANGLES + index] += step * (state[PITCH_RATES + index] + step / inertia * twice)
        state[PITCH_RATES + index] += step / inertia * once


@kernel
def solve_internal(operators, constants, work, damper_forces, step, forces):
    """Find the internal forces at the end by fixed-point iteration; False if it fails.

    ``forces`` (16,) hold the first guess and the result; ``work.new_signals`` (24,) are the
    signals at the end without them.
    """
    end, found, laws = work.end_signals, work.found_forces, constants.laws
    for _ in range(_MAX_ITERATIONS):
        copy_into(end, 0, work.new_signals)
        add_product(operators.feedback, 0, forces, end)
        internal_forces(laws, work.excess_momentum, damper_forces, work.signals, end, step, found)
        # Rounding of the elongations limits what can be reached behind a stiff spring.
        change, size = 0.0, 0.0
        for index in range(4):
            size = max(size, laws.yaw_series_stiffness * abs(end[index]))
        for index in range(INTERNAL_COUNT):
            change = max(change, abs(found[index] - forces[index]))
            size = max(size, abs(found[index]))
            forces[index] = found[index]
        if change <= 1e-8 + 1e-12 * size:
            return True
    return False


@kernel
def advance_part(operators, constants, work, step):
    """Advance state, signals and the internal forces (last 16 inputs) by one step, in place."""
    state, inputs = work.state, work.inputs
    acceleration, forces = inputs[3 * FORCE_COUNT], inputs[3 * FORCE_COUNT + 1 :]
    set_zero(work.new_state)
    set_zero(work.new_signals)
    add_product(operators.known, 0, state[:STATE_COUNT], work.new_state)
    add_product(operators.known, STATE_COUNT, inputs, work.new_state)
    spin_wheelsets(state, inputs, step, constants.spin_inertia)
    excess_momentum(constants, state, work.excess_momentum)
    add_product(operators.signals, 0, work.new_state, work.new_signals)
    damper_forces = state[DAMPER_FORCES : DAMPER_FORCES + 4]
    converged = solve_internal(operators, constants, work, damper_forces, step, forces)
    add_product(operators.internal, 0, forces, work.new_state)
    add_product(operators.feedback, 0, forces, work.new_signals)
    copy_into(work.signals, 0, work.new_signals)
    copy_into(state, 0, work.new_state)
    copy_into(state, DAMPER_FORCES, forces[:4])
    state[POSITION] += step * (state[SPEED] + 0.5 * acceleration * step)
    state[SPEED] += acceleration * step
    return converged


@kernel
def less_static(forces, static, excess):
    """Write contact forces (24,) less the vertical force of each wheelset at rest."""
    copy_into(excess, 0, forces)
    for index in range(4):
        excess[6 * index + 2] -= static


@kernel
def evaluate_into(constants, work, vector, signals, forces, acceleration, result):
    """Write what outputs are made of (145,) at a state with its signals."""
    copy_into(result, 0, vector[:VECTOR_COUNT])
    less_static(forces, constants.static_force, result[VECTOR_COUNT : VECTOR_COUNT + FORCE_COUNT])
    result[VECTOR_COUNT + FORCE_COUNT] = acceleration
    excess_momentum(constants, vector, work.excess_momentum)
    damper_forces = vector[DAMPER_FORCES : DAMPER_FORCES + 4]
    internal_forces(
        constants.laws,
        work.excess_momentum,
        damper_forces,
        signals,
        signals,
        0.0,
        result[VECTOR_COUNT + FORCE_COUNT + 1 :],
    )


@kernel
def write_outputs(constants, result, outputs):
    """Write all outputs from what they are made of."""
    for row in range(outputs.size):
        total = constants.output_offsets[row]
        for index in range(constants.output_rows[row], constants.output_rows[row + 1]):
            total += constants.output_values[index] * result[constants.output_columns[index]]
        outputs[row] = total


@core.entry
def evaluate(
    operators: Operators,
    constants: Constants,
    work: Workspace,
    vector: Vector,
    forces: Vector,
    acceleration: float,
    outputs: Vector,
) -> None:
    """Write the outputs at a state under contact forces (24,)."""
    set_zero(work.signals)
    add_product(operators.signals, 0, vector[:STATE_COUNT], work.signals)
    evaluate_into(constants, work, vector, work.signals, forces, acceleration, work.result)
    write_outputs(constants, work.result, outputs)


@core.entry
def force_curve(
    history: Vector,
    newest: Vector,
    elapsed: float,
    duration: float,
    order: int,
    at_end: bool,
    unit: Vector,
    force: Matrix,
) -> None:
    """Take in forces (24,), and write those over a step of ``duration`` s, (3, 24)."""
    take_force(history, newest, elapsed, duration, at_end, unit)
    force_over_step(history, duration, order, at_end, force)


@core.entry
def step(
    operators: Operators,
    constants: Constants,
    work: Workspace,
    vector: Vector,
    force: Matrix,
    timing: Vector,
    count: int,
    new_vector: Vector,
    outputs: Vector,
) -> int:
    """Advance by a communication step of ``count`` internal steps.

    Parameters
    ----------
    operators
        Of the internal step.
    constants, work
        See there.
    vector
        State at the start, (104,); not changed.
    force
        Contact forces over the step, rows start, end and quadratic term, (3, 24):
        ``start + (end - start) s + quadratic s (s - 1)``.
    timing
        Length of the communication step, s, and the speed to be reached at its end, m/s (2,).
    count
        Internal steps.
    new_vector
        Written: state at the end; if that is ``BEYOND``, for the message.
    outputs
        Written if all is well.

    Returns
    -------
    int
        ``GOOD``, ``NOT_FOUND`` or ``BEYOND``.
    """
    duration, limit = timing[0], constants.acceleration_limit
    acceleration = min(max((timing[1] - vector[SPEED]) / duration, -limit), limit)
    state, inputs, result = work.state, work.inputs, work.result
    copy_into(state, 0, vector)
    set_zero(work.signals)
    add_product(operators.signals, 0, state[:STATE_COUNT], work.signals)
    evaluate_into(constants, work, state, work.signals, force[1], acceleration, result)
    inputs[3 * FORCE_COUNT] = acceleration
    copy_into(inputs, 3 * FORCE_COUNT + 1, result[VECTOR_COUNT + FORCE_COUNT + 1 :])
    less_static(force[0], constants.static_force, work.force_start)
    less_static(force[1], constants.static_force, work.force_end)
    good = True
    for part in range(count):
        fill_inputs(inputs, work.force_start, work.force_end, force[2], part, count)
        good = advance_part(operators, constants, work, duration / count) and good
    copy_into(result, 0, state)
    copy_into(result, VECTOR_COUNT + FORCE_COUNT + 1, inputs[3 * FORCE_COUNT + 1 :])
    for index in range(result.size):
        good = good and math.isfinite(result[index])
    if not good:
        return NOT_FOUND
    copy_into(new_vector, 0, state)
    for index in range(VECTOR_COUNT):
        if abs(result[index]) > constants.limits[index]:
            return BEYOND
    write_outputs(constants, result, outputs)
    return GOOD


@core.entry
def coupled_step(
    operators: Operators,
    constants: Constants,
    work: Workspace,
    vector: Vector,
    history: Vector,
    newest: Vector,
    timing: Vector,
    order: int,
    at_end: bool,
    unit: Vector,
    largest_error: float,
    count: int,
    new_vector: Vector,
    outputs: Vector,
) -> int:
    """As :func:`step`, with the contact forces at communication points.

    Parameters
    ----------
    history, newest
        Force history (HISTORY_COUNT,), and the forces (24,) that come to it.
    timing
        As for :func:`step`, and third the time since the forces before, s, (3,).
    order, at_end
        Degree of the forces over the step, and whether ``newest`` stands for its end.
    unit, largest_error
        What counts as a large force or moment, (24,), N and N.m; the largest error of the
        parabola.
    """
    take_force(history, newest, timing[2], timing[0], at_end, unit)
    if alternates(history, largest_error):
        return NOT_FOLLOWED
    force_over_step(history, timing[0], order, at_end, work.force)
    return step(operators, constants, work, vector, work.force, timing, count, new_vector, outputs)
