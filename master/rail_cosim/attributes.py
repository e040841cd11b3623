"""Attributes of a run's Dataset: everything needed to know what it was and to repeat it."""

from __future__ import annotations

import datetime
import json
import math
import platform
from collections.abc import Mapping
from typing import Any

from rail_cosim import version
from rail_cosim.algorithms import Algorithm
from rail_cosim.description import FmuDescription
from rail_cosim.energy import GOOD
from rail_cosim.fmu import FmuSlave
from rail_cosim.simulation import Outcome
from rail_cosim.slave import Slave, Value
from rail_cosim.steady import SteadyReport


def parameter_attributes(slave: Slave) -> dict[str, Any]:
    """Return all parameters of a slave as it holds them, named ``slave.parameter``."""
    names = [
        v.name
        for v in slave.variables.values()
        if v.causality in ("parameter", "calculatedParameter")
    ]
    return {f"{slave.name}.{name}": value for name, value in slave.get(names).items()}


def fmu_attributes(slave: FmuSlave) -> dict[str, Any]:
    """Return which FMU this was, and which of its variables had which names of their own."""
    about = slave.description
    renamed = {
        name: {"name": r.own, "factor": r.factor, "offset": r.offset}
        for name, variable in about.variables.items()
        if (r := variable.renaming) is not None
    }
    return {
        **({f"{slave.name}_names": json.dumps(renamed)} if renamed else {}),
        f"{slave.name}_fmu": about.path.name,
        f"{slave.name}_model": about.model_name,
        f"{slave.name}_guid": about.guid,
        f"{slave.name}_version": about.version,
        f"{slave.name}_generation_tool": about.generation_tool,
    }


REMARKS = "remarks"
"""Attribute with what was warned of at the start and during the run, one remark a line."""
CHANGED = "changed_parameters"
"""Attribute with the parameters that are not as the parameter set has them, as JSON."""


def changed_attribute(
    descriptions: Mapping[str, FmuDescription],
    usual: Mapping[str, Mapping[str, Value]],
    given: Mapping[str, Mapping[str, Value]],
) -> dict[str, str]:
    """Return which of the given values are others than without options.

    Parameters
    ----------
    descriptions
        By slave; the variables' start values are what holds without a parameter set.
    usual, given
        Values of the parameter sets, and all that were set, by slave and name.

    Returns
    -------
    dict
        :data:`CHANGED` and a JSON object ``{slave.parameter: value of the parameter set}``.
    """
    changed = {}
    for slave, values in given.items():
        for name, value in values.items():
            before = usual.get(slave, {}).get(name, descriptions[slave].variables[name].start)
            if not _same(value, before):
                changed[f"{slave}.{name}"] = before
    return {CHANGED: json.dumps(changed)}


def _same(one: Value, other: Value | None) -> bool:
    """Whether two values are equal but for rounding: 300 km/h are not exact in m/s."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-12)
    return one == other


def run_attributes(outcome: Outcome, algorithm: Algorithm, command: str) -> dict[str, Any]:
    """Return how the run went, and with what it was made."""
    return {
        "title": "Co-simulation of a railway vehicle on slab track",
        "source": f"rail-cosim {version()}",
        "python_version": platform.python_version(),
        "command": command,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "complete": outcome.complete,
        "ended_by": ended_by(outcome),
        "macro_step": outcome.step_size,
        "steps": outcome.steps,
        "steps_planned": outcome.planned,
        "algorithm": algorithm.name,
        **{f"algorithm_{name}": value for name, value in algorithm.report().items()},
        "simulated_seconds": outcome.simulated,
        "wall_clock_seconds": outcome.wall,
        "cpu_seconds": outcome.cpu,
        "real_time_factor": outcome.real_time_factor,
        "interface_energy_residual": outcome.energy.residual,
        "interface_energy_absolute_residual": outcome.energy.absolute_residual,
        "interface_energy_exchanged": outcome.energy.exchanged,
        "interface_energy_residual_share": outcome.energy.share,
        "interface_energy_residual_limit": GOOD,
        **steady_attributes(outcome.steady),
    }


def steady_attributes(report: SteadyReport | None) -> dict[str, Any]:
    """Return whether the run had become steady; nothing where this was not asked for."""
    if report is None:
        return {}
    return {
        "steady": report.steady,
        "steady_change": report.change,
        "steady_tolerance": report.tolerance,
    }


def ended_by(outcome: Outcome) -> str:
    """Return why the run ended early, empty if it did not."""
    if outcome.error is None:
        return ""
    if isinstance(outcome.error, KeyboardInterrupt):
        return f"stopped by the user after {outcome.steps} of {outcome.planned} steps"
    return str(outcome.error)
