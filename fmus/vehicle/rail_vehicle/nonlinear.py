"""Force laws of the non-linear elements, as numba functions of scalars."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rail_vehicle.parameters import VehicleParameters

ELEMENT_COUNT = 8
"""Four yaw dampers, two lateral dampers, two lateral stops."""


@njit(cache=True)
def blow_off_force(rate: float, damping: float, limit: float, damping_after: float) -> float:
    """Force of a dashpot that blows off at the force ``limit``, N; ``rate`` in m/s."""
    force = damping * rate
    if abs(force) <= limit:
        return force
    over = abs(rate) - limit / damping
    return math.copysign(limit + damping_after * over, rate)


@njit(cache=True)
def stop_force(elongation: float, clearance: float, stiffness: float, cubic: float) -> float:
    """Force of a stop with free play to both sides, N; ``elongation`` in m."""
    depth = abs(elongation) - clearance
    if depth <= 0.0:
        return 0.0
    return math.copysign(depth * (stiffness + cubic * depth * depth), elongation)


@njit(cache=True)
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


@njit(cache=True)
def element_forces(
    start_force: NDArray[np.float64],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    duration: float,
    law: NDArray[np.float64],
    forces: NDArray[np.float64],
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
        Constants of the three laws, see :func:`law_constants`, shape (10,).
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


def law_constants(parameters: VehicleParameters) -> NDArray[np.float64]:
    """Constants of the force laws: yaw damper (4), lateral damper (3), stop (3)."""
    yaw, lateral = parameters.yaw_damper, parameters.lateral_damper
    stop = parameters.lateral_bump_stop
    return np.array(
        [
            yaw.damping,
            yaw.blow_off_force,
            yaw.blow_off_damping,
            yaw.series_stiffness,
            lateral.damping,
            lateral.blow_off_force,
            lateral.blow_off_damping,
            stop.clearance,
            stop.stiffness,
            stop.cubic_stiffness,
        ]
    )


def largest_slopes(parameters: VehicleParameters, stroke: float) -> NDArray[np.float64]:
    """Largest slopes of the eight forces over elongation (8) and over its rate (8).

    The stop's slope is that at the compression ``stroke`` in m.
    """
    yaw, lateral = parameters.yaw_damper, parameters.lateral_damper
    stop = parameters.lateral_bump_stop
    slopes = np.zeros(2 * ELEMENT_COUNT)
    if yaw.damping > 0.0:
        slopes[0:4] = yaw.series_stiffness
    slopes[6:8] = stop.stiffness + 3.0 * stop.cubic_stiffness * stroke**2
    slopes[12:14] = lateral.damping
    return slopes
