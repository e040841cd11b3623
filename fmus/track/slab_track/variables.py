"""Names, units and meanings of the track's inputs and outputs, in the order of its arrays."""

from rail_quantities import terminals

from slab_track.motion import MOTION
from slab_track.parameters import WHEELSET_LIMIT

NUMBERS = range(1, WHEELSET_LIMIT + 1)
SIDES = ("left", "right")
CONTACT = tuple(member.name for member in terminals.CONTACT)
INPUT_TIME = "coupling.input_time"

RAIL_HEAD = {
    "vertical_force": ("N", "Vertical force on the rail head, downwards"),
    "lateral_force": ("N", "Lateral force on the rail head, to the right"),
    "roll_moment": (
        "N.m",
        "Moment on the rail head about the line, positive if it turns the head to the right",
    ),
}
WHEEL = {
    "normal_force": ("N", "Normal force between wheel and rail, positive in compression"),
    "longitudinal_creep_force": ("N", "Creep force on the wheel along the line, forwards"),
    "lateral_creep_force": ("N", "Creep force on the wheel in the contact plane, to the right"),
    "penetration": ("m", "Approach of wheel and rail, positive in contact, negative apart"),
    "contact_angle": (
        "rad",
        "Angle of the contact plane against the horizontal, positive where it falls to the right",
    ),
    "rail_vertical_displacement": (
        "m",
        "Displacement of the rail's axis under the wheel, downwards from the unloaded track",
    ),
    "rail_lateral_displacement": (
        "m",
        "Displacement of the rail's head under the wheel, to the right",
    ),
    "rail_roll_angle": (
        "rad",
        "Rotation of the rail under the wheel about the line, positive with its head to the right",
    ),
    "guiding_force": ("N", "Lateral wheel force Y, of the wheel on the rail, to the right"),
    "vertical_wheel_force": ("N", "Vertical wheel force Q, of the wheel on the rail, downwards"),
}
PROFILES = {
    "rail_profile": "Displacement of the rail, downwards from the unloaded track",
    "slab_profile": "Displacement of the slab under the rail, downwards from the unloaded track",
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
    return [f"wheelset[{i}].contact.{name}" for i in range(1, count + 1) for name in CONTACT]


def wheel_names(name: str, count: int) -> list[str]:
    """Names of one output of all wheels, left first."""
    return [f"wheelset[{i}].{side}.{name}" for i in range(1, count + 1) for side in SIDES]


def rail_head_names(name: str, count: int) -> list[str]:
    """Names of one force input of all rail heads, left first."""
    return [f"rail_head[{i}].{side}.{name}" for i in range(1, count + 1) for side in SIDES]
