"""Bring a vehicle and a track to their common static equilibrium.

The order of calls is part of the contract between the two FMUs:

 1. parameters of both; ``coupling.input_time`` as the algorithm needs it;
 2. both learn the span of time;
 3. the vehicle enters initialization mode: its wheelset motions are known;
 4. wheelset motions -> track inputs; the vehicle's ``static_wheel_load`` -> the
    track's parameter of the same name, unless the user has set that;
 5. the track enters initialization mode: it finds its own static deflection;
 6. the track's ``wheelset[i].static_vertical_displacement`` -> the vehicle's
    ``wheelset[i].initial_vertical_displacement``;
 7. wheelset motions -> track once more, contact forces -> vehicle;
 8. both leave initialization mode.

A variable that one of the two does not have is left out, so foreign FMUs with
the terminals ``wheelset[i]`` alone run too.
"""

from __future__ import annotations

from collections.abc import Mapping

from rail_cosim.slave import Slave, Value
from rail_cosim.system import SystemStructure

Parameters = Mapping[str, Mapping[str, Value]]

INPUT_TIME = "coupling.input_time"
WHEEL_LOAD = "static_wheel_load"
SPEED, SPEED_SETPOINT = "speed", "speed_setpoint"


def initialise(
    system: SystemStructure,
    *,
    parameters: Parameters,
    input_times: Mapping[str, str],
    stop_time: float,
) -> None:
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
    if WHEEL_LOAD not in parameters.get("track", {}):
        _copy(vehicle, WHEEL_LOAD, track, WHEEL_LOAD)
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
