"""The contract between a vehicle and a track: names, units and causality of what they exchange."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping
from typing import Literal

from rail_cosim.slave import Kind, Variable

Role = Literal["vehicle", "track"]
Level = Literal["fault", "note"]

WHEELSET_LIMIT = 4
MOTION: Mapping[str, str] = {
    "longitudinal_position": "m",
    "lateral_displacement": "m",
    "vertical_displacement": "m",
    "roll_angle": "rad",
    "yaw_angle": "rad",
    "longitudinal_velocity": "m/s",
    "lateral_velocity": "m/s",
    "vertical_velocity": "m/s",
    "roll_rate": "rad/s",
    "yaw_rate": "rad/s",
    "pitch_rate": "rad/s",
}
"""Motion of a wheelset: outputs of a vehicle, inputs of a track."""
FORCES: Mapping[str, str] = {
    "contact.longitudinal_force": "N",
    "contact.lateral_force": "N",
    "contact.vertical_force": "N",
    "contact.roll_moment": "N.m",
    "contact.pitch_moment": "N.m",
    "contact.yaw_moment": "N.m",
}
"""Contact force on a wheelset: outputs of a track, inputs of a vehicle."""
RAIL_HEAD: Mapping[str, str] = {
    f"{side}.{name}": unit
    for side in ("left", "right")
    for name, unit in (("vertical_force", "N"), ("lateral_force", "N"), ("roll_moment", "N.m"))
}
OUTPUTS: Mapping[Role, Mapping[str, str]] = {
    "vehicle": {
        "axle_box[i].left.vertical_acceleration": "m/s2",
        "axle_box[i].right.vertical_acceleration": "m/s2",
        "bogie[j].vertical_acceleration": "m/s2",
        "bogie[j].lateral_acceleration": "m/s2",
        "car_body.vertical_acceleration": "m/s2",
        "car_body.lateral_acceleration": "m/s2",
    },
    "track": {
        f"wheelset[i].{side}.{name}": unit
        for side in ("left", "right")
        for name, unit in (
            ("normal_force", "N"),
            ("longitudinal_creep_force", "N"),
            ("lateral_creep_force", "N"),
            ("guiding_force", "N"),
            ("vertical_wheel_force", "N"),
            ("penetration", "m"),
            ("contact_angle", "rad"),
            ("rail_vertical_displacement", "m"),
            ("rail_lateral_displacement", "m"),
            ("rail_roll_angle", "rad"),
        )
    },
}
"""Outputs that summary, report and evaluation read where an FMU has them, with their units; ``[i]``
stands for the wheelset, ``[j]`` for the bogie."""
COUNT = "wheelset_count"
SPACING, PER_SLAB = "fastener.spacing", "fastener.count_per_slab"
_NO_PITCH = "no evaluation by slab length (--until-steady, fastener-passing amplitudes)"
_TERMINAL = re.compile(r"wheelset\[(\d+)\]\.(.+)$")


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Finding:
    """Something the check has to say.

    Attributes
    ----------
    level
        ``fault``: the contract or FMI is violated. ``note``: optional and absent.
    subject
        The variable or part it is about.
    text
        What is wrong, or what its absence means.
    """

    level: Level
    subject: str
    text: str


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Expected:
    """A variable as the contract wants it; ``without`` says what its absence means."""

    name: str
    causality: tuple[str, ...]
    unit: str = ""
    kind: Kind = "real"
    without: str = ""


def role_of(variables: Mapping[str, Variable]) -> Role | None:
    """Return what an FMU is by its terminals, ``None`` if it has none.

    Each member of a terminal that it has speaks for one of the two; a vehicle
    gives motions out and takes forces in, a track the other way round.
    """
    votes = {"vehicle": 0, "track": 0}
    for variable in variables.values():
        match = _TERMINAL.match(variable.name)
        if match is None:
            continue
        is_input = variable.causality == "input"
        if not is_input and variable.causality != "output":
            continue
        if match[2] in MOTION:
            votes["track" if is_input else "vehicle"] += 1
        elif match[2] in FORCES:
            votes["vehicle" if is_input else "track"] += 1
    if votes["vehicle"] == votes["track"]:
        return None
    return "vehicle" if votes["vehicle"] > votes["track"] else "track"


def terminal_numbers(variables: Iterable[str]) -> list[int]:
    """Return the numbers of the terminals that have a member of the contract, sorted."""
    members = MOTION.keys() | FORCES.keys()
    matches = (_TERMINAL.match(name) for name in variables)
    return sorted({int(m[1]) for m in matches if m and m[2] in members})


def expected(role: Role, numbers: Iterable[int]) -> list[Expected]:
    """Return what an FMU of this role must have, and what it may have."""
    own, other = ("output", "input") if role == "vehicle" else ("input", "output")
    wanted: list[Expected] = []
    for i in numbers:
        for members, causality in ((MOTION, own), (FORCES, other)):
            for name, unit in members.items():
                full = f"wheelset[{i}].{name}"
                wanted.append(Expected(name=full, causality=(causality,), unit=unit))
    return wanted + (_vehicle_extras if role == "vehicle" else _track_extras)(list(numbers))


def _vehicle_extras(numbers: list[int]) -> list[Expected]:
    parameter = ("parameter",)
    heights = "the run starts with the small transient of wheelsets between two fasteners"
    return [
        Expected(
            name="static_wheel_load",
            causality=("calculatedParameter", "parameter", "output"),
            unit="N",
            without="the track keeps its own static_wheel_load: set it to the vehicle's",
        ),
        Expected(
            name="speed", causality=parameter, unit="m/s", without="--speed cannot set the speed"
        ),
        Expected(
            name="speed_setpoint",
            causality=("input",),
            unit="m/s",
            without="the speed cannot be driven during the run (--final-speed)",
        ),
        Expected(
            name="initial_position",
            causality=parameter,
            unit="m",
            without="the run starts where the vehicle says",
        ),
        Expected(
            name="wheelset.radius",
            causality=("parameter", "calculatedParameter"),
            unit="m",
            without="the track keeps its own contact.wheel_radius: set it to the vehicle's",
        ),
        _input_time(),
        *(
            Expected(
                name=f"wheelset[{i}].initial_vertical_displacement",
                causality=parameter,
                unit="m",
                without=heights,
            )
            for i in numbers
        ),
    ]


def _track_extras(numbers: list[int]) -> list[Expected]:
    alone = "the track cannot be used with a contact model of the tool's own"
    return [
        Expected(
            name="static_wheel_load",
            causality=("parameter",),
            unit="N",
            without="the vehicle's load is not passed on; the track must start at rest without it",
        ),
        Expected(
            name="contact.wheel_radius",
            causality=("parameter",),
            unit="m",
            without="the vehicle's radius is not passed on",
        ),
        _input_time(),
        Expected(name="interface", causality=("parameter",), kind="string", without=alone),
        Expected(name=SPACING, causality=("parameter",), unit="m", without=_NO_PITCH),
        Expected(name=PER_SLAB, causality=("parameter",), kind="integer", without=_NO_PITCH),
        *(
            Expected(
                name=f"wheelset[{i}].static_vertical_displacement",
                causality=("output", "calculatedParameter"),
                unit="m",
                without="the vehicle does not learn where its wheelsets rest: a small transient",
            )
            for i in numbers
        ),
        *(
            Expected(name=f"rail_head[{i}].{name}", causality=("input",), unit=unit, without=alone)
            for i in numbers
            for name, unit in RAIL_HEAD.items()
        ),
    ]


def _input_time() -> Expected:
    return Expected(
        name="coupling.input_time",
        causality=("parameter",),
        kind="string",
        without="it cannot be told which end of a step its inputs stand for: use jacobi, or expect "
        "first order",
    )


def known_units() -> dict[str, str]:
    """Return the unit of every name of the contract, ``""`` for none."""
    numbers = range(1, WHEELSET_LIMIT + 1)
    units = {COUNT: ""}
    for role in ("vehicle", "track"):
        units |= {wanted.name: wanted.unit for wanted in expected(role, numbers)}
        for pattern, unit in OUTPUTS[role].items():
            for i in numbers:
                name = pattern.replace("[i]", f"[{i}]").replace("[j]", f"[{(i + 1) // 2}]")
                units[name] = unit
    return units


def contract_findings(variables: Mapping[str, Variable]) -> tuple[Role | None, list[Finding]]:
    """Compare an FMU's variables with the contract; return what it is and what is to be said."""
    role = role_of(variables)
    if role is None:
        text = (
            "no wheelset motions on one side and contact forces on the other, so this is neither "
            "a vehicle nor a track"
        )
        return None, [Finding(level="fault", subject="wheelset[i].*", text=text)]
    numbers = terminal_numbers(variables)
    found = _terminals(role, variables, numbers)
    valid = [i for i in numbers if 1 <= i <= WHEELSET_LIMIT]
    for wanted in expected(role, valid):
        found += _compare(wanted, variables)
    return role, found


def _terminals(role: Role, variables: Mapping[str, Variable], numbers: list[int]) -> list[Finding]:
    found: list[Finding] = []
    if numbers != list(range(1, len(numbers) + 1)) or len(numbers) > WHEELSET_LIMIT:
        text = f"terminals {numbers}; they count from 1 without a gap, up to {WHEELSET_LIMIT}"
        found.append(Finding(level="fault", subject="wheelset[i]", text=text))
    count = variables.get(COUNT)
    if count is None:
        if role == "track":
            text = "missing; an integer parameter says how many of the terminals are in use"
            found.append(Finding(level="fault", subject=COUNT, text=text))
        return found
    if (count.kind, count.causality) != ("integer", "parameter"):
        text = f"is {_words(count)}; must be a parameter of kind integer"
        found.append(Finding(level="fault", subject=COUNT, text=text))
    elif not isinstance(count.start, int) or not 1 <= count.start <= len(numbers):
        text = f"starts with {count.start}, but there are {len(numbers)} terminals"
        found.append(Finding(level="fault", subject=COUNT, text=text))
    return found


def _compare(wanted: Expected, variables: Mapping[str, Variable]) -> list[Finding]:
    variable = variables.get(wanted.name)
    if variable is None:
        if wanted.without:
            return [Finding(level="note", subject=wanted.name, text=f"absent: {wanted.without}")]
        unit = f" in {wanted.unit}" if wanted.unit else ""
        text = f"missing; must be an {wanted.causality[0]}{unit}"
        return [Finding(level="fault", subject=wanted.name, text=text)]
    wrong: list[str] = []
    if variable.kind != wanted.kind or variable.causality not in wanted.causality:
        words = " or ".join(wanted.causality)
        wrong.append(f"is {_words(variable)}; must be {words} of kind {wanted.kind}")
    elif wanted.kind == "real" and variable.unit != wanted.unit:
        given = f"is in {variable.unit}" if variable.unit else "declares no unit"
        wrong.append(f"{given}; must be in {wanted.unit}")
    return [Finding(level="fault", subject=wanted.name, text=text) for text in wrong]


def _words(variable: Variable) -> str:
    return f"{variable.causality} of kind {variable.kind}"
