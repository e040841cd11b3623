"""The track's FMI variables beside its parameters: names, units, meanings."""

from rail_fmi import Variable

from slab_track.motion import MOTION
from slab_track.parameters import WHEELSET_LIMIT

NUMBERS = range(1, WHEELSET_LIMIT + 1)
SIDES = ("left", "right")
INPUT_TIME = "coupling.input_time"

_MOTION_UNITS = dict(
    zip(MOTION, ("m", "m", "m", "rad", "rad", "m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"),
        strict=True)
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
}


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


def inputs() -> list[Variable]:
    """Return the input variables."""
    motion = [
        Variable(
            f"wheelset[{i}].{name}",
            causality="input",
            unit=unit,
            description=f"Wheelset {i}: {name.replace('_', ' ')}",
        )
        for i in NUMBERS
        for name, unit in _MOTION_UNITS.items()
    ]
    rail_head = [
        Variable(
            f"rail_head[{i}].{side}.{name}",
            causality="input",
            unit=unit,
            description=f"{name.replace('_', ' ').capitalize()} on the {side} rail head under "
            f"wheelset {i}; used with interface = applied_force",
        )
        for name, unit in RAIL_HEAD.items()
        for i in NUMBERS
        for side in SIDES
    ]
    return motion + rail_head


def settings() -> list[Variable]:
    """Return the parameters of the interface."""
    return [
        Variable(
            INPUT_TIME,
            kind="string",
            causality="parameter",
            choices=("step_start", "step_end"),
            description="Instant of the communication step that the inputs stand for",
        )
    ]


def outputs() -> list[Variable]:
    """Return the output variables."""
    contact = [
        Variable(
            f"wheelset[{i}].contact.{name}",
            causality="output",
            unit=unit,
            description=f"Contact {name.replace('_', ' ')} on wheelset {i}, at its centre of mass",
        )
        for i in NUMBERS
        for name, unit in CONTACT_UNITS.items()
    ]
    wheels = [
        Variable(
            f"wheelset[{i}].{side}.{name}", causality="output", unit=unit, description=description
        )
        for name, (unit, description) in WHEEL.items()
        for i in NUMBERS
        for side in SIDES
    ]
    heights = [
        Variable(
            f"wheelset[{i}].static_vertical_displacement",
            causality="output",
            unit="m",
            description=f"Equilibrium height of wheelset {i} at the start above the datum, "
            "downwards; constant during the run",
        )
        for i in NUMBERS
    ]
    window = [
        Variable(
            "window.start_position",
            causality="output",
            unit="m",
            description="Rear end of the window on the line",
        ),
        Variable(
            "window.slide_count",
            kind="integer",
            causality="output",
            description="Slides of the window since the start",
        ),
        Variable(
            "window.slide_residual",
            causality="output",
            unit="m",
            description="Largest change of the rails' deflection by the last slide",
        ),
    ]
    return contact + wheels + heights + window
