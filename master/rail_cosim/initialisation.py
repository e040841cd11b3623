"""Bring a vehicle and a track to their common static equilibrium.

The order of calls is part of the contract between the two FMUs:

 1. parameters of both; ``coupling.input_time`` as the algorithm needs it;
 2. both learn the span of time;
 3. the vehicle enters initialization mode: its wheelset motions are known;
 4. wheelset motions -> track inputs; the vehicle's ``static_wheel_load`` and
    ``wheelset.radius`` -> the track's ``static_wheel_load`` and
    ``contact.wheel_radius``, unless the user has set those;
 5. the track enters initialization mode: it finds its own static deflection;
 6. the track's ``wheelset[i].static_vertical_displacement`` -> the vehicle's
    ``wheelset[i].initial_vertical_displacement``;
 7. wheelset motions -> track once more, contact forces -> vehicle;
 8. both leave initialization mode.

A variable that one of the two does not have is left out, so foreign FMUs with
the terminals ``wheelset[i]`` alone run too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rail_cosim.slave import Slave, Value
from rail_cosim.system import SystemStructure

Parameters = Mapping[str, Mapping[str, Value]]

INPUT_TIME = "coupling.input_time"
WHEEL_RADIUS, CONTACT_RADIUS = "wheelset.radius", "contact.wheel_radius"
SPEED, SPEED_SETPOINT = "speed", "speed_setpoint"
POSITION = "initial_position"

PASSED = {"static_wheel_load": "static_wheel_load", WHEEL_RADIUS: CONTACT_RADIUS}
"""What the vehicle tells the track before that finds its equilibrium: its name in either."""


def initialise(
    system: SystemStructure,
    *,
    parameters: Parameters,
    input_times: Mapping[str, str],
    stop_time: float,
) -> list[str]:
    """Initialise the slaves ``vehicle`` and ``track`` of a system.

    Parameters
    ----------
    system
        A system with slaves of these two names.
    parameters
        Checked values by slave and name (see :func:`rail_cosim.parameters.checked`).
    input_times
        For each slave what instant its inputs stand for, from the algorithm.
    stop_time
        Planned end of the run in s.

    Returns
    -------
    list[str]
        What the user should know: values that contradict each other.

    Raises
    ------
    SlaveError
        If an FMU refuses its parameters or cannot find its equilibrium.
    """
    vehicle, track = system["vehicle"], system["track"]
    for slave in system.slaves:
        _set_parameters(slave, parameters.get(slave.name, {}), input_times)
        slave.setup(0.0, stop_time)
    vehicle.enter_initialization()
    _pass_motions(system)
    for source, target in PASSED.items():
        if target not in parameters.get("track", {}):
            _copy(vehicle, source, track, target)
    track.enter_initialization()
    given = parameters.get("vehicle", {})
    for name in vehicle.variables:
        if name.endswith(".initial_vertical_displacement") and name not in given:
            _copy(track, name.replace(".initial_", ".static_"), vehicle, name)
    _pass_motions(system)
    _pass_forces(system)
    for slave in system.slaves:
        slave.exit_initialization()
    for port in system.ports:
        port.read_all()
    return _contradictions(vehicle, parameters.get("track", {}))


def _contradictions(vehicle: Slave, given: Mapping[str, Value]) -> list[str]:
    """Return a warning if the user gave the track's contact other wheels than the vehicle has."""
    if CONTACT_RADIUS not in given or WHEEL_RADIUS not in vehicle.variables:
        return []
    contact, own = float(given[CONTACT_RADIUS]), float(vehicle.get([WHEEL_RADIUS])[WHEEL_RADIUS])
    if math.isclose(contact, own, rel_tol=1e-9):
        return []
    return [
        f"track.{CONTACT_RADIUS} = {contact:g} m, but vehicle.{WHEEL_RADIUS} = {own:g} m: the "
        "wheels start with the spin of one radius and roll on another; set only the vehicle's"
    ]


def _set_parameters(slave: Slave, given: Mapping[str, Value], times: Mapping[str, str]) -> None:
    values = dict(given)
    if INPUT_TIME in slave.variables and slave.name in times:
        values.setdefault(INPUT_TIME, times[slave.name])
    follows = SPEED_SETPOINT in slave.variables and SPEED_SETPOINT not in values
    if follows and SPEED in values:
        values[SPEED_SETPOINT] = values[SPEED]  # the vehicle is to hold the speed it starts with
    slave.set(values)


def _pass_motions(system: SystemStructure) -> None:
    system.port("vehicle").outputs.read()
    system.port("track").set_inputs()


def _pass_forces(system: SystemStructure) -> None:
    system.port("track").outputs.read()
    system.port("vehicle").set_inputs()


def _copy(source: Slave, source_name: str, target: Slave, target_name: str) -> None:
    if source_name in source.variables and target_name in target.variables:
        target.set({target_name: source.get([source_name])[source_name]})
