r"""Wheelset motion inside a communication step, from values at its ends.

A co-simulation partner gives position and velocity at communication points
only. Between the last two points they define a cubic (Hermite); used beyond the
last point it extrapolates with a local error of order H^4.
"""

from typing import NamedTuple

import numba
import numpy as np

VELOCITY_COLUMNS = slice(5, 10)
"""Rates of x, y, z, roll, yaw in a motion row (see :data:`MOTION`)."""

MOTION = (
    "longitudinal_position",
    "lateral_displacement",
    "vertical_displacement",
    "roll_angle",
    "yaw_angle",
    "longitudinal_velocity",
    "lateral_velocity",
    "vertical_velocity",
    "roll_rate",
    "yaw_rate",
    "pitch_rate",
)
"""Columns of a motion array, shape (wheelsets, 11); SI units."""


class MotionHistory(NamedTuple):
    """The last two communication points.

    Attributes
    ----------
    time, previous_time
        Times in s; ``previous_time`` is NaN while there is only one point.
    motion, previous
        Motion arrays, shape (wheelsets, 11).
    rates_seen
        True for the five channels whose velocity was ever different from zero.
        Where a partner leaves velocities unconnected, positions alone are used.
    """

    time: float
    previous_time: float
    motion: np.ndarray
    previous: np.ndarray
    rates_seen: np.ndarray

    @classmethod
    def begin(cls, time: float, motion: np.ndarray) -> "MotionHistory":
        """Start with a single communication point."""
        seen = np.any(motion[:, VELOCITY_COLUMNS] != 0.0, axis=0)
        return cls(time, np.nan, motion.copy(), motion.copy(), seen)

    def push(self, time: float, motion: np.ndarray) -> "MotionHistory":
        """Return the history with one more communication point."""
        motion, seen = motion.copy(), self.rates_seen.copy()
        _look_for_rates(motion, seen)
        if time == self.time:
            return MotionHistory(time, self.previous_time, motion, self.previous, seen)
        return MotionHistory(time, self.time, motion, self.motion, seen)

    def path(self, times: np.ndarray) -> np.ndarray:
        """Return motion rows at ``times``, shape (times, wheelsets, 11)."""
        return _path(
            times - self.time,
            self.time - self.previous_time,
            self.motion,
            self.previous,
            self.rates_seen,
        )


@numba.njit(cache=True)
def _look_for_rates(motion, seen):
    """Mark the channels whose velocity is not zero, in place."""
    for wheelset in range(motion.shape[0]):
        for channel in range(5):
            if motion[wheelset, channel + 5] != 0.0:
                seen[channel] = True


@numba.njit(cache=True)
def finite_reach(motion, path, out):
    """Fill ``out`` with what a step must check about the wheelsets' motion.

    Smallest and largest position on ``path`` (steps, wheelsets, 11), and at its end, m, (4,).
    Returns False if a number in ``motion`` is not finite.
    """
    last = path.shape[0] - 1
    out[0] = out[1] = path[0, 0, 0]
    out[2] = out[3] = path[last, 0, 0]
    for n in range(path.shape[0]):
        for wheelset in range(path.shape[1]):
            x = path[n, wheelset, 0]
            out[0], out[1] = min(out[0], x), max(out[1], x)
            if n == last:
                out[2], out[3] = min(out[2], x), max(out[3], x)
    finite = True
    for value in motion.flat:
        finite &= np.isfinite(value)
    return finite


@numba.njit(cache=True)
def _path(tau, span, motion, previous, rates_seen):
    """Evaluate the polynomials and their rates at the times ``tau`` after the last point."""
    path = np.empty((tau.size, motion.shape[0], 11))
    for wheelset in range(motion.shape[0]):
        for channel in range(5):
            now, rate = motion[wheelset, channel], motion[wheelset, channel + 5]
            if not rates_seen[channel]:
                rate = 0.0
            quadratic = cubic = 0.0
            if span > 0.0:
                before = previous[wheelset, channel]
                if rates_seen[channel]:
                    # now + rate tau + A tau^2 + B tau^3 through the previous point.
                    d0 = (before - now + rate * span) / span**2
                    d1 = (rate - previous[wheelset, channel + 5]) / span
                    quadratic, cubic = 3.0 * d0 - d1, (2.0 * d0 - d1) / span
                else:
                    rate = (now - before) / span
            for n in range(tau.size):
                t = tau[n]
                path[n, wheelset, channel] = now + t * (rate + t * (quadratic + t * cubic))
                path[n, wheelset, channel + 5] = rate + t * (2.0 * quadratic + 3.0 * t * cubic)
        spin, slope = motion[wheelset, 10], 0.0
        if span > 0.0:
            slope = (spin - previous[wheelset, 10]) / span
        for n in range(tau.size):
            path[n, wheelset, 10] = spin + slope * tau[n]
    return path
