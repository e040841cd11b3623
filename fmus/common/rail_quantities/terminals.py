"""What vehicle and track exchange: the members of the terminal ``wheelset[i]``."""

from typing import NamedTuple

FRAME = (
    "SI units. Track frame: x along the line in running direction, y to the right, z down; roll "
    "about x, pitch about y, yaw about z, right-handed. Indices count from 1 at the leading end; "
    "left is y < 0. A wheelset's vertical_displacement is measured from the mean height of the "
    "wheelsets at rest. Contact forces and moments are those on the wheelset, reduced to its "
    "centre of mass: at rest the vertical one is minus the axle load. normal_force is positive in "
    "compression. pitch_rate is the total spin, -V/R in pure rolling."
)
"""Units, frame and signs of both FMUs, for their documentation."""


class Member(NamedTuple):
    """One member of a terminal.

    Attributes
    ----------
    name, unit, description
        As in both FMUs: dotted name without the terminal, SI unit, meaning with its sign.
    """

    name: str
    unit: str
    description: str


MOTION = (
    Member("longitudinal_position", "m", "Position of the wheelset's centre along the line"),
    Member("lateral_displacement", "m", "Displacement of the wheelset to the right"),
    Member("vertical_displacement", "m", "Displacement of the wheelset downwards from the datum"),
    Member("roll_angle", "rad", "Rotation about the line, positive with the right side down"),
    Member("yaw_angle", "rad", "Rotation about the vertical, positive turned to the right"),
    Member("longitudinal_velocity", "m/s", "Velocity of the wheelset's centre along the line"),
    Member("lateral_velocity", "m/s", "Velocity of the wheelset to the right"),
    Member("vertical_velocity", "m/s", "Velocity of the wheelset downwards"),
    Member("roll_rate", "rad/s", "Rate of the roll angle, positive with the right side going down"),
    Member("yaw_rate", "rad/s", "Rate of the yaw angle, positive turning to the right"),
    Member(
        "pitch_rate", "rad/s", "Total spin about the axle, negative forwards: -V/R in pure rolling"
    ),
)
"""Motion of a wheelset: outputs of the vehicle, inputs of the track."""

CONTACT = (
    Member("longitudinal_force", "N", "Contact force on the wheelset, forwards"),
    Member("lateral_force", "N", "Contact force on the wheelset, to the right"),
    Member(
        "vertical_force",
        "N",
        "Contact force on the wheelset, downwards: minus the axle load at rest",
    ),
    Member(
        "roll_moment",
        "N.m",
        "Contact moment on the wheelset about the line through its centre of mass, positive with "
        "the right side down",
    ),
    Member(
        "pitch_moment",
        "N.m",
        "Contact moment on the wheelset about its axle, positive backwards: it brakes the spin of "
        "rolling forwards",
    ),
    Member(
        "yaw_moment",
        "N.m",
        "Contact moment on the wheelset about the vertical through its centre of mass, positive "
        "turning to the right",
    ),
)
"""Contact force and moment on a wheelset, reduced to its centre of mass, in the track frame:
outputs of the track, inputs of the vehicle; names without ``contact.``."""
