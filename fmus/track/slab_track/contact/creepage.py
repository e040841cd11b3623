r"""Creepages and spin of a contact patch from the full kinematics of wheel and rail.

The contact frame is ``e_x`` along the rail, ``e_s = (0, cos g, sin g)`` across in the
tangent plane, and ``e_n = (0, -sin g, cos g)`` into the rail, with the contact
angle g (roll of the tangent plane in the track frame). With the wheel's and the rail's
material velocities at the patch and their angular velocities:

.. math:: \xi = \frac{(v_w - v_r)\cdot e_x}{V},\quad
          \eta = \frac{(v_w - v_r)\cdot e_s}{V},\quad
          \phi = \frac{(\omega_w - \omega_r)\cdot e_n}{V}

with ``V`` the rolling speed, the mean of the speeds at which the patch travels
over the wheel's and the rail's surface. The component of the velocity along
``e_n`` is the rate of penetration; it has no part in the creep forces.
"""

import math

from rail_native import Vector, kernel

from slab_track.core import core

SLOWEST = 0.1
"""Speed (m/s) below which creepages no longer grow: they stay finite at standstill."""

# Columns of a motion row (the contract's order) and of a rail's motion row.
X, Y, Z, ROLL, YAW, V_X, V_Y, V_Z, ROLL_RATE, YAW_RATE, PITCH_RATE = range(11)
RAIL_Y, RAIL_Z, RAIL_ROLL, RAIL_V_Y, RAIL_V_Z, RAIL_ROLL_RATE = range(6)


@kernel
def angular_velocity(motion):
    """Return the wheelset's angular velocity in the track frame (rad/s).

    Orientation is yaw, then roll; ``pitch_rate`` is the spin about the turned axle.
    """
    sin_yaw, cos_yaw = math.sin(motion[YAW]), math.cos(motion[YAW])
    sin_roll, cos_roll = math.sin(motion[ROLL]), math.cos(motion[ROLL])
    roll_rate, spin = motion[ROLL_RATE], motion[PITCH_RATE]
    return (
        cos_yaw * roll_rate - sin_yaw * cos_roll * spin,
        sin_yaw * roll_rate + cos_yaw * cos_roll * spin,
        motion[YAW_RATE] + sin_roll * spin,
    )


@core.entry
def creepages(
    motion: Vector,
    rail: Vector,
    arm_x: float,
    arm_y: float,
    arm_z: float,
    rail_arm_y: float,
    rail_arm_z: float,
    angle: float,
) -> tuple[float, float, float, float]:
    """Return longitudinal creepage, lateral creepage and spin of a patch.

    Parameters
    ----------
    motion
        The wheelset's motion row, shape (11,).
    rail
        Displacement and velocity of the rail at its axis: y, z, roll and rates, shape (6,).
    arm_x, arm_y, arm_z
        The patch from the wheelset's centre, track frame (m).
    rail_arm_y, rail_arm_z
        The patch from the rail's axis (m).
    angle
        Contact angle in the track frame (rad).

    Returns
    -------
    xi, eta (1), phi (1/m), wheel less rail, and the direction of travel (1 or -1).
    """
    w_x, w_y, w_z = angular_velocity(motion)
    v_x = motion[V_X] + w_y * arm_z - w_z * arm_y
    v_y = motion[V_Y] + w_z * arm_x - w_x * arm_z
    v_z = motion[V_Z] + w_x * arm_y - w_y * arm_x
    rail_rate = rail[RAIL_ROLL_RATE]
    v_y -= rail[RAIL_V_Y] - rail_rate * rail_arm_z
    v_z -= rail[RAIL_V_Z] + rail_rate * rail_arm_y
    cosine, sine = math.cos(angle), math.sin(angle)
    # The patch moves with the axle; yaw turns its arm along the track. The
    # rolling speed is the mean of those at which it passes over both surfaces.
    rolling = motion[V_X] - motion[YAW_RATE] * arm_y - 0.5 * v_x
    direction = 1.0 if rolling >= 0.0 else -1.0
    speed = max(abs(rolling), SLOWEST)
    return (
        v_x / speed,
        (cosine * v_y + sine * v_z) / speed,
        (-sine * w_y + cosine * w_z) / speed,
        direction,
    )
