"""What a tool has to set so that the pair starts in its static equilibrium."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from rail_cosim.algorithms import Jacobi
from rail_cosim.description import read_description
from rail_cosim.fmu import FmuSlave
from rail_cosim.initialisation import PASSED, initialise
from rail_cosim.parameters import checked
from rail_cosim.presets import read_preset
from rail_cosim.slave import Slave, Value, Variable
from rail_cosim.system import SystemStructure

_HEIGHT = ".initial_vertical_displacement"


def values_at_rest(
    fmus: Mapping[str, Path], presets: Mapping[str, str]
) -> dict[str, dict[str, Value]]:
    """Initialise ``vehicle`` and ``track``; return what one told the other, by FMU and variable.

    A master that knows the pair passes the vehicle's wheel load and radius to
    the track, and the wheelsets' resting heights back, while it initialises
    them. Most tools pass on inputs only: they need these values as parameters. All real
    inputs are among the values too, so that both start with what the other says at rest,
    and a tool has a value for those that nothing is connected with.

    Raises
    ------
    RailCosimError
        If the pair cannot be initialised.
    """
    descriptions = {name: read_description(fmu) for name, fmu in fmus.items()}
    parameters = {
        name: checked(name, description.variables, read_preset(fmus[name], presets[name], name))
        for name, description in descriptions.items()
    }
    for target in PASSED.values():
        parameters["track"].pop(target, None)
    with contextlib.ExitStack() as stack:
        slaves = {
            name: stack.enter_context(FmuSlave(fmus[name], name, description=descriptions[name]))
            for name in ("track", "vehicle")
        }
        system = SystemStructure(list(slaves.values()))
        times = Jacobi().input_times(list(slaves))
        initialise(system, parameters=parameters, input_times=times, stop_time=1.0)
        heights = [name for name in slaves["vehicle"].variables if name.endswith(_HEIGHT)]
        told = {"track": list(PASSED.values()), "vehicle": heights}
        for name, description in descriptions.items():
            told[name] += [v.name for v in description.variables.values() if _is_signal(v)]
        return {name: _values(slaves[name], names) for name, names in told.items()}


def _is_signal(variable: Variable) -> bool:
    return variable.causality == "input" and variable.kind == "real"


def _values(slave: Slave, names: list[str]) -> dict[str, Value]:
    return dict(slave.get([name for name in names if name in slave.variables]))
