"""How many wheelsets a pair has: the track learns it from the vehicle."""

from __future__ import annotations

from collections.abc import Mapping

from rail_cosim.contract import COUNT, MOTION, terminal_numbers
from rail_cosim.errors import ParameterError, StructureError
from rail_cosim.slave import Value, Variable

Variables = Mapping[str, Variable]


def wheelset_parameters(
    vehicle: Variables,
    track: Variables,
    given: Mapping[str, Mapping[str, Value]],
) -> dict[str, Value]:
    """Return the track's ``wheelset_count`` as the vehicle's terminals want it.

    A terminal of the track that nothing feeds would be a wheelset that stands on the rails.

    Parameters
    ----------
    vehicle, track
        Their variables by name.
    given
        Checked values that were set, by ``vehicle`` and ``track`` and name.

    Returns
    -------
    dict
        Empty where the track's start value is right, or where it was set and is right.

    Raises
    ------
    StructureError
        If the vehicle's terminals have a gap, or the track has not as many.
    ParameterError
        If ``wheelset_count`` was set to another number than the vehicle has.
    """
    numbers, places = _terminals(vehicle, "output"), _terminals(track, "input")
    if not numbers or not places:
        return {}  # nothing of the contract to connect
    if numbers != list(range(1, len(numbers) + 1)):
        raise StructureError(
            f"the vehicle FMU has the terminals {_listed(numbers)}; they must count from 1 without "
            "a gap, from the leading end: rename its outputs and inputs"
        )
    count = len(numbers)
    if COUNT in vehicle:
        count = int(given["vehicle"].get(COUNT, vehicle[COUNT].start or count))
    if count > len(places):
        raise StructureError(
            f"the vehicle FMU has {count} wheelsets, but the track FMU has terminals for "
            f"{len(places)} only"
        )
    if COUNT not in track:
        if count != len(places):
            raise StructureError(
                f"the vehicle FMU has {_counted(count)}, but the track FMU has terminals for "
                f"{len(places)} and no parameter {COUNT}: one of the two does not fit"
            )
        return {}
    chosen = given["track"].get(COUNT)
    if chosen is not None and int(chosen) != count:
        raise ParameterError(
            f"track.{COUNT}",
            chosen,
            f"the vehicle FMU has {_counted(count)}",
            "omit it: it follows the vehicle",
        )
    return {} if (track[COUNT].start if chosen is None else chosen) == count else {COUNT: count}


def _terminals(variables: Variables, causality: str) -> list[int]:
    """Return the numbers of the terminals that give or take a wheelset's motion."""
    suffixes = tuple(f"].{name}" for name in MOTION)
    return terminal_numbers(
        name
        for name, variable in variables.items()
        if variable.causality == causality and name.endswith(suffixes)
    )


def _listed(numbers: list[int]) -> str:
    return ", ".join(f"wheelset[{number}]" for number in numbers)


def _counted(count: int) -> str:
    return f"{count} wheelset" + ("" if count == 1 else "s")
