"""The option ``--irregularity``: a name or a file as parameters of the track FMU.

The names are the FMU's own: the words that its parameter ``irregularity.spectrum`` takes,
and ``rail_joint`` where it has one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.initialisation import POSITION
from rail_cosim.parameters import number_of
from rail_cosim.slave import Value, Variable

OPTION = "--irregularity"
SPECTRUM, FILE = "irregularity.spectrum", "irregularity.file.path"
JOINT_SIDE, JOINT_POSITION = "irregularity.rail_joint.side", "irregularity.rail_joint.position"
JOINT_LENGTH = "irregularity.rail_joint.long_wavelength"
_RAMP = "irregularity.ramp_length"
SPACING = "fastener.spacing"
RAIL_JOINT = "rail_joint"
OFF = "none"
_TRACK = "track.irregularity."
LEAD = 12.0
"""A rail joint lies at mid-span of the first fastener bay that is at least so far ahead of the
leading wheelset at the start, m: at the middle of a slab of the line HD."""


def irregularity_names(variables: Mapping[str, Variable]) -> list[str]:
    """Return the names that ``--irregularity`` knows for a track with these variables."""
    names = list(variables[SPECTRUM].choices) if SPECTRUM in variables else []
    return names + ([RAIL_JOINT] if JOINT_SIDE in variables else [])


def irregularity_parameters(
    text: str, variables: Mapping[str, Variable], *, start: float, spacing: float
) -> dict[str, object]:
    """Return the track's parameters that stand for one name or file.

    Parameters
    ----------
    text
        A spectrum, ``rail_joint``, or the path of an existing file. A name comes before a
        file of the same name; write ``./name`` for the file.
    variables
        The track's variables.
    start
        Position of the leading wheelset at the start, m.
    spacing
        Of the track's fasteners, m, 0 if not known: they are half a bay away from its whole
        multiples, so a rail joint there is at mid-span.

    Raises
    ------
    UnknownNameError
        If it is neither a name nor a file; gives the names.
    ParameterError
        If the track FMU has no such irregularities.
    """
    names = irregularity_names(variables)
    if text == RAIL_JOINT and JOINT_SIDE in variables:
        joint: dict[str, object] = {JOINT_SIDE: "both"}
        if JOINT_POSITION in variables:
            joint[JOINT_POSITION] = joint_position(start, spacing)
        return joint
    if text in names:
        return {SPECTRUM: text}
    path = Path(text).expanduser()
    if path.is_file():
        if FILE not in variables:
            limit = "the track FMU takes no irregularity from a file"
            raise ParameterError(OPTION, text, limit, f"it has no parameter {FILE}")
        return {FILE: str(path.resolve())}
    if not names:
        limit = "the track FMU has no irregularities"
        raise ParameterError(OPTION, text, limit, f"it has no parameter {SPECTRUM}")
    raise UnknownNameError(
        OPTION, text, names, "irregularity and no file", wanted=text, listed=True
    )


def joint_position(start: float, spacing: float) -> float:
    """Return the position (m) of a rail joint for which none was given (see :data:`LEAD`)."""
    if spacing <= 0.0:
        return start + LEAD
    return math.ceil((start + LEAD) / spacing - 1e-9) * spacing


def check_joint(
    variables: Mapping[str, Variable],
    values: Mapping[str, Value],
    *,
    start: float,
    distance: float,
) -> None:
    """Refuse a rail joint that the leading wheelset does not pass wholly.

    Parameters
    ----------
    variables
        The track's variables.
    values
        What of them is set.
    start, distance
        Position of the leading wheelset at the start, and distance travelled, m.

    Raises
    ------
    ParameterError
        If the run ends before.
    """
    if values.get(JOINT_SIDE, OFF) == OFF or JOINT_POSITION not in variables:
        return
    position = number_of(JOINT_POSITION, values, variables)
    length = number_of(JOINT_LENGTH, values, variables)
    needed = position + 0.5 * length - start
    if distance < needed:
        raise ParameterError(
            "--distance",
            distance,
            f"the run ends before the rail joint, {position - start:.6g} m ahead of the leading "
            f"wheelset at the start (track.{JOINT_POSITION} = {position:.6g} m)",
            f"take at least {needed:.6g} m, and 3 m more for what follows the impact",
        )


def irregularity_words(about: Mapping[str, Any]) -> str:
    """Return which irregularity a run had, and over what distance it was faded in.

    Parameters
    ----------
    about
        Attributes of a run's Dataset; empty text if they name no irregularity.
    """
    given = {k.removeprefix(_TRACK): v for k, v in about.items() if k.startswith(_TRACK)}
    origin = float(about.get(f"vehicle.{POSITION}", 0.0))
    parts = []
    if given.get("spectrum", OFF) != OFF:
        parts.append(f"{given['spectrum']}, realisation {given.get('seed', '')}".strip())
    if given.get("file.path"):
        parts.append(Path(str(given["file.path"])).name)
    length = float(given.get("ramp_length", 0.0))
    if parts and length > 0.0:
        start = float(given.get("start", 0.0)) - origin
        ramp = f"{start:g} to {start + length:g} m"
        parts.append(f"faded in from {ramp} distance travelled (track.{_RAMP})")
    for group, meaning in (("rail_joint", "rail joint"), ("cosine", "cosine")):
        if given.get(f"{group}.side", OFF) != OFF:
            position = float(given.get(f"{group}.position", math.nan)) - origin
            parts.append(f"{meaning} at {position:.6g} m distance travelled")
    return "; ".join(parts)
