"""The step of the vehicle over plain arrays, compiled by numba.

Python calls it through :mod:`rail_vehicle.stepping`. Numba's cache looks at the file
of the function called from outside only: after a change here delete ``__pycache__``
(FMUs are safe, their cache is keyed by all sources).

State vector (104): coordinates and rates of the linear system (90), pitch
angles (4) and pitch rates (4) of the wheelsets, yaw damper forces (4),
position of the car body, its speed.
"""

import math

import numpy as np
from numpy.typing import NDArray
from rail_quantities.uncounted import on_stack

from rail_vehicle.compiled import entry, kernel
from rail_vehicle.linear_system import FORCE_COUNT, INTERNAL_COUNT, SIGNAL_COUNT, STATE_COUNT

Array = NDArray[np.float64]

PITCH_ANGLES = STATE_COUNT
PITCH_RATES = STATE_COUNT + 4
DAMPER_FORCES = STATE_COUNT + 8
POSITION = STATE_COUNT + 12
SPEED = STATE_COUNT + 13
VECTOR_COUNT = STATE_COUNT + 14

RESULT_COUNT = VECTOR_COUNT + FORCE_COUNT + 1 + INTERNAL_COUNT
"""Length of what outputs are made of: state, contact forces, acceleration, internal forces."""

GOOD, NOT_FOUND, BEYOND = 0, 1, 2
"""What :func:`advance` says of a step."""

_INPUT_COUNT = 3 * FORCE_COUNT + 1 + INTERNAL_COUNT
"""Of a step: forces at start and end and bow, acceleration, internal forces at the start."""

_MAX_ITERATIONS = 60


# Plain loops throughout: numba compiles each array expression into a function of its own.


@kernel
def copy_into(target: Array, first: int, source: Array) -> None:
    """Write ``source`` into ``target`` from index ``first`` on."""
    for index in range(source.size):
        target[first + index] = source[index]


@kernel
def add_columns(matrix: Array, first: int, vector: Array, result: Array) -> None:
    """Add ``matrix[first:first + n].T @ vector`` to ``result``, four columns at a time."""
    whole = vector.size - vector.size % 4
    for column in range(0, whole, 4):
        a, b, c, d = vector[column], vector[column + 1], vector[column + 2], vector[column + 3]
        row_a, row_b = matrix[first + column], matrix[first + column + 1]
        row_c, row_d = matrix[first + column + 2], matrix[first + column + 3]
        for index in range(result.size):
            result[index] += (
                row_a[index] * a + row_b[index] * b + row_c[index] * c + row_d[index] * d
            )
    for column in range(whole, vector.size):
        factor, row = vector[column], matrix[first + column]
        for index in range(result.size):
            result[index] += row[index] * factor


@entry
def blow_off_force(rate: float, damping: float, limit: float, damping_after: float) -> float:
    """Force of a dashpot that blows off at the force ``limit``, N; ``rate`` in m/s."""
    force = damping * rate
    if abs(force) <= limit:
        return force
    over = abs(rate) - limit / damping
    return math.copysign(limit + damping_after * over, rate)


@entry
def stop_force(elongation: float, clearance: float, stiffness: float, cubic: float) -> float:
    """Force of a stop with free play to both sides, N; ``elongation`` in m."""
    depth = abs(elongation) - clearance
    if depth <= 0.0:
        return 0.0
    return math.copysign(depth * (stiffness + cubic * depth * depth), elongation)


@entry
def maxwell_force(
    force: float,
    rate: float,
    duration: float,
    spring: float,
    damping: float,
    limit: float,
    damping_after: float,
) -> float:
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


@entry
def element_forces(
    start_force: Array,
    start: Array,
    end: Array,
    duration: float,
    law: Array,
    forces: Array,
) -> None:
    """Write the forces of the eight elements at the end of a step.

    Parameters
    ----------
    start_force
        Yaw damper forces at the start, shape (4,), N.
    start, end
        Elongations (first 8) and their rates (next 8) at both ends, m and m/s.
    duration
        Length of the step, s; 0 gives the forces at the start.
    law
        Constants of the three laws, see :func:`rail_vehicle.nonlinear.law_constants`, shape (10,).
    forces
        Result, shape (8 or more,), N, against elongation.
    """
    for index in range(4):
        if law[0] > 0.0 and duration > 0.0:
            rate = (end[index] - start[index]) / duration
            forces[index] = maxwell_force(
                start_force[index], rate, duration, law[3], law[0], law[1], law[2]
            )
        else:
            forces[index] = start_force[index]
    for index in range(4, 6):
        forces[index] = blow_off_force(end[8 + index], law[4], law[5], law[6])
    for index in range(6, 8):
        forces[index] = stop_force(end[index], law[7], law[8], law[9])


@kernel
def internal_forces(
    damper_forces: Array,
    start: Array,
    end: Array,
    duration: float,
    momentum: Array,
    law: Array,
    forces: Array,
) -> None:
    """Write element forces and gyroscopic moments at the end of a step, shape (16,).

    ``momentum`` (4,) is that of :func:`excess_momentum`.
    """
    element_forces(damper_forces, start, end, duration, law, forces)
    for index in range(4):
        forces[8 + index] = momentum[index] * end[20 + index]
        forces[12 + index] = -momentum[index] * end[16 + index]


@kernel
def excess_momentum(vector: Array, constants: Array, momentum: Array) -> None:
    """Write the angular momentum of the wheelsets beyond that of the parameter ``speed``, (4,).

    The linear part contains the gyroscopic moments of the latter.
    """
    for index in range(4):
        momentum[index] = constants[0] * (vector[PITCH_RATES + index] - constants[1])


@kernel
def less_static(forces: Array, static: float, excess: Array) -> None:
    """Write contact forces (24,) less the vertical force of each wheelset at rest."""
    copy_into(excess, 0, forces)
    for index in range(4):
        excess[6 * index + 2] -= static


@kernel
def clear(array: Array) -> None:
    """Fill an array with zeros."""
    for index in range(array.size):
        array[index] = 0.0


@entry
def write_outputs(
    offsets: Array,
    values: Array,
    columns: NDArray[np.int32],
    row_starts: NDArray[np.int32],
    result: Array,
    outputs: Array,
) -> None:
    """Write ``offsets + rows @ result``, the rows stored sparsely."""
    for row in range(outputs.size):
        total = offsets[row]
        for place in range(row_starts[row], row_starts[row + 1]):
            total += values[place] * result[columns[place]]
        outputs[row] = total


@entry
def evaluate(
    vector: Array,
    forces: Array,
    acceleration: float,
    signals: Array,
    constants: Array,
    law: Array,
    result: Array,
) -> None:
    """Write state, contact forces less static, acceleration, internal forces to (145,)."""
    now = on_stack(SIGNAL_COUNT)
    clear(now)
    add_columns(signals, 0, vector[:STATE_COUNT], now)
    evaluate_with(vector, now, forces, acceleration, constants, law, result)


@kernel
def evaluate_with(
    vector: Array,
    now: Array,
    forces: Array,
    acceleration: float,
    constants: Array,
    law: Array,
    result: Array,
) -> None:
    """As :func:`evaluate`, with the signals (24,) of the state."""
    copy_into(result, 0, vector)
    less_static(forces, constants[2], result[VECTOR_COUNT : VECTOR_COUNT + FORCE_COUNT])
    result[VECTOR_COUNT + FORCE_COUNT] = acceleration
    momentum = on_stack(4)
    excess_momentum(vector, constants, momentum)
    internal_forces(
        vector[DAMPER_FORCES : DAMPER_FORCES + 4],
        now,
        now,
        0.0,
        momentum,
        law,
        result[VECTOR_COUNT + FORCE_COUNT + 1 :],
    )


@kernel
def spin_wheelsets(state: Array, inputs: Array, step: float, inertia: float) -> None:
    """Integrate pitch angles and rates under the contact's pitch moments, in place."""
    for index in range(4):
        column = 6 * index + 4
        start = inputs[column]
        end = inputs[FORCE_COUNT + column]
        bow = inputs[2 * FORCE_COUNT + column]
        turn = start / 3.0 + end / 6.0 - bow / 12.0
        gain = 0.5 * (start + end) - bow / 6.0
        state[PITCH_ANGLES + index] += step * (state[PITCH_RATES + index] + step / inertia * turn)
        state[PITCH_RATES + index] += step / inertia * gain


@kernel
def solve_internal(
    forces: Array,
    damper_forces: Array,
    start: Array,
    known: Array,
    feedback: Array,
    step: float,
    momentum: Array,
    law: Array,
) -> bool:
    """Find the internal forces at the end by fixed-point iteration; False if it fails.

    ``known`` (24,) are the signals at the end without the end's internal
    forces; ``forces`` (16,) hold the first guess and the result.
    """
    end, found = on_stack(SIGNAL_COUNT), on_stack(INTERNAL_COUNT)
    for _ in range(_MAX_ITERATIONS):
        copy_into(end, 0, known)
        add_columns(feedback, 0, forces, end)
        internal_forces(damper_forces, start, end, step, momentum, law, found)
        # Rounding of the elongations limits what can be reached behind a stiff spring.
        change, size = 0.0, 0.0
        for index in range(4):
            size = max(size, law[3] * abs(end[index]))
        for index in range(INTERNAL_COUNT):
            change = max(change, abs(found[index] - forces[index]))
            size = max(size, abs(found[index]))
            forces[index] = found[index]
        if change <= 1e-8 + 1e-12 * size:
            return True
    return False


@kernel
def fill_inputs(inputs: Array, start: Array, end: Array, bow: Array, part: int, count: int) -> None:
    """Write the contact forces of the ``part``-th of ``count`` equal parts of the interval.

    The first 72 entries become the forces at its start and end and its bow.
    """
    left, right = part / count, (part + 1) / count
    for index in range(FORCE_COUNT):
        slope = end[index] - start[index]
        inputs[index] = start[index] + slope * left + bow[index] * left * (left - 1.0)
        inputs[FORCE_COUNT + index] = (
            start[index] + slope * right + bow[index] * right * (right - 1.0)
        )
        inputs[2 * FORCE_COUNT + index] = bow[index] / (count * count)


@kernel
def advance_part(
    state: Array,
    inputs: Array,
    now: Array,
    step: float,
    known: Array,
    internal: Array,
    signals: Array,
    feedback: Array,
    constants: Array,
    law: Array,
) -> bool:
    """Advance state, signals and the internal forces (last 16 inputs) by one step, in place."""
    forces = inputs[3 * FORCE_COUNT + 1 :]
    acceleration = inputs[3 * FORCE_COUNT]
    ahead, then, momentum = on_stack(STATE_COUNT), on_stack(SIGNAL_COUNT), on_stack(4)
    clear(ahead)
    clear(then)
    add_columns(known, 0, state[:STATE_COUNT], ahead)
    add_columns(known, STATE_COUNT, inputs, ahead)
    spin_wheelsets(state, inputs, step, constants[0])
    excess_momentum(state, constants, momentum)
    add_columns(signals, 0, ahead, then)
    damper_forces = state[DAMPER_FORCES : DAMPER_FORCES + 4]
    converged = solve_internal(forces, damper_forces, now, then, feedback, step, momentum, law)
    add_columns(internal, 0, forces, ahead)
    add_columns(feedback, 0, forces, then)
    copy_into(now, 0, then)
    copy_into(state, 0, ahead)
    copy_into(state, DAMPER_FORCES, forces[:4])
    state[POSITION] += step * (state[SPEED] + 0.5 * acceleration * step)
    state[SPEED] += acceleration * step
    return converged


@kernel
def advance(
    vector: Array,
    forces: Array,
    acceleration: float,
    step: float,
    count: int,
    known: Array,
    internal: Array,
    signals: Array,
    feedback: Array,
    constants: Array,
    law: Array,
    limits: Array,
    result: Array,
) -> int:
    """Advance by ``count`` steps of length ``step``.

    Parameters
    ----------
    vector
        State at the start, shape (104 or more,); not changed.
    forces
        Contact forces over the whole interval, rows start, end and bow, shape (3, 24):
        ``start + (end - start) s + bow s (s - 1)``.
    acceleration
        Of the car body over the interval, m/s2.
    known, internal, signals, feedback
        See :class:`rail_vehicle.integration.Operators`.
    constants
        Spin inertia in kg m2, the spin of the parameter ``speed`` in rad/s,
        and the vertical force of a wheelset at rest in N.
    law
        Constants of the non-linear elements.
    limits
        Largest absolute value of each number of the state, shape (104,), SI units.
    result
        Written as by :func:`evaluate` at the end, shape (145,).

    Returns
    -------
    int
        ``GOOD``; ``NOT_FOUND`` if internal forces were not found or a number is not finite;
        ``BEYOND`` if a number of the state is beyond its limit.
    """
    state, now = on_stack(VECTOR_COUNT), on_stack(SIGNAL_COUNT)
    copy_into(state, 0, vector[:VECTOR_COUNT])
    clear(now)
    add_columns(signals, 0, state[:STATE_COUNT], now)
    evaluate_with(state, now, forces[1], acceleration, constants, law, result)
    inputs = on_stack(_INPUT_COUNT)
    inputs[3 * FORCE_COUNT] = acceleration
    copy_into(inputs, 3 * FORCE_COUNT + 1, result[VECTOR_COUNT + FORCE_COUNT + 1 :])
    first, last = on_stack(FORCE_COUNT), on_stack(FORCE_COUNT)
    less_static(forces[0], constants[2], first)
    less_static(forces[1], constants[2], last)
    good = True
    for part in range(count):
        fill_inputs(inputs, first, last, forces[2], part, count)
        good &= advance_part(
            state, inputs, now, step, known, internal, signals, feedback, constants, law
        )
    copy_into(result, 0, state)
    copy_into(result, VECTOR_COUNT + FORCE_COUNT + 1, inputs[3 * FORCE_COUNT + 1 :])
    for value in result:
        good &= math.isfinite(value)
    if not good:
        return NOT_FOUND
    beyond = 0
    for index in range(VECTOR_COUNT):
        beyond += abs(result[index]) > limits[index]
    return BEYOND if beyond else GOOD
