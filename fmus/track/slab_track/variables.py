"""Names, units and meanings of the track's inputs and outputs, in the order of its arrays."""

from slab_track.motion import MOTION
from slab_track.parameters import WHEELSET_LIMIT

NUMBERS = range(1, WHEELSET_LIMIT + 1)
SIDES = ("left", "right")
INPUT_TIME = "coupling.input_time"

MOTION_UNITS = dict(
    zip(
        MOTION,
        ("m", "m", "m", "rad", "rad", "m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"),
        strict=True,
    )
)
CONTACT_UNITS = {
    "longitudinal_force": "N",
    "lateral_force": "N",
    "vertical_force": "N",
    "roll_moment": "N.m",
    "pitch_moment": "N.m",
    "yaw_moment": "N.m",
}
RAIL_HEAD = {"vertical_force": "N", "lateral_force": "N", "roll_moment": "N.m"}
WHEEL = {
    "normal_force": ("N", "Normal force, positive in compression"),
    "longitudinal_creep_force": ("N", "Longitudinal creep force on the wheel"),
    "lateral_creep_force": ("N", "Lateral creep force on the wheel"),
    "penetration": ("m", "Approach of wheel and rail; negative when separated"),
    "contact_angle": ("rad", "Angle of the contact plane against the horizontal"),
    "rail_vertical_displacement": ("m", "Rail under the wheel, downwards"),
    "rail_lateral_displacement": ("m", "Rail under the wheel, to the right"),
    "rail_roll_angle": ("rad", "Rotation of the rail under the wheel"),
    "guiding_force": ("N", "Lateral force of the wheel on the rail, Y, to the right"),
    "vertical_wheel_force": ("N", "Vertical force of the wheel on the rail, Q, downwards"),
}
PROFILES = {
    "rail_profile": "{side} rail, vertical displacement from the unloaded track, downwards",
    "slab_profile": "slab under the {side} rail, vertical displacement, downwards",
}
PROFILE_POINTS = 121
PROFILES_WANTED = "rail_profile.enabled"
FIRST_OFFSET, SPACING = "rail_profile.first_offset", "rail_profile.spacing"
"""Place of the first point ahead of the leading wheelset, and distance from point to point, m."""


def profile_names(group: str) -> list[str]:
    """Names of a profile's points, left first."""
    return [
        f"{group}.{side}.vertical_displacement[{k}]"
        for side in SIDES
        for k in range(1, PROFILE_POINTS + 1)
    ]


def motion_names(count: int) -> list[str]:
    """Names of the wheelset motions, row by row as in a motion array."""
    return [f"wheelset[{i}].{name}" for i in range(1, count + 1) for name in MOTION]


def contact_names(count: int) -> list[str]:
    """Names of the contact forces, row by row."""
    return [f"wheelset[{i}].contact.{name}" for i in range(1, count + 1) for name in CONTACT_UNITS]


def wheel_names(name: str, count: int) -> list[str]:
    """Names of one output of all wheels, left first."""
    return [f"wheelset[{i}].{side}.{name}" for i in range(1, count + 1) for side in SIDES]


def rail_head_names(name: str, count: int) -> list[str]:
    """Names of one force input of all rail heads, left first."""
    return [f"rail_head[{i}].{side}.{name}" for i in range(1, count + 1) for side in SIDES]
