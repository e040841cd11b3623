r"""Wheelset motion inside a communication step, from values at its ends.

A co-simulation partner gives position and velocity at communication points only. Between the last
two points they define a cubic (Hermite); used beyond the last point it extrapolates with a local
error of order H^4.
"""

import math

from rail_native import Matrix, Vector, kernel

from slab_track.core import core

COLUMNS = 11
"""Of a motion row, see :data:`slab_track.motion.MOTION`."""

JUMP = 0.5
"""By so much may distance and velocity of the wheelsets differ between two points, m; more by a
tenth of the distance."""

DEEPEST = 0.3
"""Lowest place of a wheelset, m; rails and irregularities take it to 0.1 m at most."""


LEAST_SPAN = 0.5
"""Shortest time between two points that are extrapolated from, in parts of the step ahead: errors
of the values grow with the third power of its inverse."""


@kernel
def push(motion, keeps, now, before, rates_seen):
    """Take in a communication point; False if a number of it is not finite.

    ``motion`` (wheelsets, 11) replaces the last point ``now``, which becomes the one ``before`` it
    if it ``keeps``: not if the new one is the same instant once more, or too near. ``rates_seen``
    (5,) says which channels had a velocity different from zero at any time (1) or never (0): where
    a partner leaves velocities unconnected, positions alone are used.
    """
    finite = True
    for wheelset in range(motion.shape[0]):
        for column in range(COLUMNS):
            value = motion[wheelset, column]
            finite = finite and math.isfinite(value)
            if keeps:
                before[wheelset, column] = now[wheelset, column]
            now[wheelset, column] = value
        for channel in range(5):
            if motion[wheelset, channel + 5] != 0.0:
                rates_seen[channel] = 1.0
    return finite


@kernel
def is_too_deep(motion):
    """Whether a wheelset is inside its rails."""
    lowest = motion[0, 2]
    for wheelset in range(1, motion.shape[0]):
        lowest = max(lowest, motion[wheelset, 2])
    return lowest > DEEPEST


@kernel
def jumps(motion, before, elapsed):
    """Whether positions do not follow from the velocities since the point ``before``.

    Means over the wheelsets are compared. A partner that gives no velocities is not asked.
    """
    count, distance, speed, earlier = motion.shape[0], 0.0, 0.0, 0.0
    for wheelset in range(count):
        distance += (motion[wheelset, 0] - before[wheelset, 0]) / count
        speed += motion[wheelset, 5] / count
        earlier += before[wheelset, 5] / count
    expected = 0.5 * (speed + earlier) * elapsed
    return speed != 0.0 and not abs(distance - expected) <= JUMP + 0.1 * abs(expected)


@core.entry
def extrapolate(
    tau: float, span: float, now: Matrix, before: Matrix, rates_seen: Vector, out: Matrix
) -> None:
    """Evaluate the polynomials and their rates ``tau`` seconds after the last point.

    Parameters
    ----------
    tau
        s.
    span
        Time between the points ``before`` and ``now``, s; NaN if there is only one.
    now, before, rates_seen
        As in :func:`push`.
    out
        Written: the motion, (wheelsets, 11).
    """
    for wheelset in range(now.shape[0]):
        for channel in range(5):
            value, rate = now[wheelset, channel], now[wheelset, channel + 5]
            seen = rates_seen[channel] != 0.0
            if not seen:
                rate = 0.0
            quadratic = cubic = 0.0
            if span > 0.0:
                earlier = before[wheelset, channel]
                if seen:
                    # value + rate tau + A tau^2 + B tau^3 through the previous point.
                    d0 = (earlier - value + rate * span) / span**2
                    d1 = (rate - before[wheelset, channel + 5]) / span
                    quadratic, cubic = 3.0 * d0 - d1, (2.0 * d0 - d1) / span
                else:
                    rate = (value - earlier) / span
            out[wheelset, channel] = value + tau * (rate + tau * (quadratic + tau * cubic))
            out[wheelset, channel + 5] = rate + tau * (2.0 * quadratic + 3.0 * tau * cubic)
        spin, slope = now[wheelset, 10], 0.0
        if span > 0.0:
            slope = (spin - before[wheelset, 10]) / span
        out[wheelset, 10] = spin + slope * tau
