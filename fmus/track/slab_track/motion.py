r"""Wheelset motion inside a communication step, from values at its ends.

A co-simulation partner gives position and velocity at communication points
only. Between the last two points they define a cubic (Hermite); used beyond the
last point it extrapolates with a local error of order H^4.
"""

from typing import NamedTuple

import numpy as np

POSITION_COLUMNS = slice(0, 5)
"""x, y, z, roll, yaw in a motion row (see :data:`MOTION`)."""

VELOCITY_COLUMNS = slice(5, 10)
"""Their rates in the same order."""

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
        seen = self.rates_seen | np.any(motion[:, VELOCITY_COLUMNS] != 0.0, axis=0)
        if time == self.time:
            return self._replace(motion=motion.copy(), rates_seen=seen)
        return MotionHistory(time, self.time, motion.copy(), self.motion, seen)

    def positions(self, times: np.ndarray) -> np.ndarray:
        """Return x, y, z, roll, yaw at ``times``, shape (times, wheelsets, 5)."""
        now = self.motion[:, POSITION_COLUMNS]
        rate = np.where(self.rates_seen, self.motion[:, VELOCITY_COLUMNS], 0.0)
        tau = (times - self.time)[:, None, None]
        span = self.time - self.previous_time
        if not span > 0.0:
            return now + rate * tau
        before = self.previous[:, POSITION_COLUMNS]
        rate_before = np.where(self.rates_seen, self.previous[:, VELOCITY_COLUMNS], 0.0)
        # Cubic now + rate tau + A tau^2 + B tau^3 through the previous point.
        d0 = (before - now + rate * span) / span**2
        d1 = (rate - rate_before) / span
        quadratic, cubic = 3.0 * d0 - d1, (2.0 * d0 - d1) / span
        hermite = now + tau * (rate + tau * (quadratic + tau * cubic))
        linear = now + tau * (now - before) / span
        return np.where(self.rates_seen, hermite, linear)
