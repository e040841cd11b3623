"""The option ``--irregularity``: a name or a file as parameters of the track FMU.

The names are the FMU's own: the words that its parameter ``irregularity.spectrum`` takes,
and ``rail_joint`` where it has one.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.slave import Variable

OPTION = "--irregularity"
SPECTRUM, FILE = "irregularity.spectrum", "irregularity.file.path"
JOINT_SIDE, JOINT_POSITION = "irregularity.rail_joint.side", "irregularity.rail_joint.position"
RAIL_JOINT = "rail_joint"
OFF = "none"


def irregularity_names(variables: Mapping[str, Variable]) -> list[str]:
    """Return the names that ``--irregularity`` knows for a track with these variables."""
    names = list(variables[SPECTRUM].choices) if SPECTRUM in variables else []
    return names + ([RAIL_JOINT] if JOINT_SIDE in variables else [])


def irregularity_parameters(
    text: str, variables: Mapping[str, Variable], *, start: float, distance: float
) -> dict[str, object]:
    """Return the track's parameters that stand for one name or file.

    Parameters
    ----------
    text
        A spectrum, ``rail_joint``, or the path of an existing file. A name comes before a
        file of the same name; write ``./name`` for the file.
    variables
        The track's variables.
    start, distance
        Where the leading wheelset starts and how far it runs, m: a rail joint lies half way.

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
            joint[JOINT_POSITION] = start + 0.5 * distance
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
