"""Find the connections of a set of slaves by equal name, and check them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from rail_cosim.errors import StructureError
from rail_cosim.slave import Variable

Variables = Mapping[str, Variable]


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Connection:
    """An output of one slave that is the input of the same name of another."""

    name: str
    source: str
    target: str
    unit: str


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Unconnected:
    """An input that nothing feeds: it keeps its start value."""

    slave: str
    name: str
    reason: str


def connect(
    slaves: Mapping[str, Variables],
) -> tuple[list[Connection], list[Unconnected]]:
    """Return the connections between slaves, and the inputs left without one.

    Parameters
    ----------
    slaves
        Each slave's variables by its name.

    Raises
    ------
    StructureError
        If two outputs feed one input, units differ, an input's counterpart is
        declared ``local``, or two slaves have nothing in common.
    """
    connections: list[Connection] = []
    unconnected: list[Unconnected] = []
    for target, variables in slaves.items():
        for variable in variables.values():
            if variable.causality != "input":
                continue
            found, reason = _find(target, variable, slaves)
            if found is None:
                unconnected.append(Unconnected(slave=target, name=variable.name, reason=reason))
            else:
                connections.append(found)
    _check_all_take_part(slaves, connections)
    return connections, unconnected


def _find(
    target: str, variable: Variable, slaves: Mapping[str, Variables]
) -> tuple[Connection | None, str]:
    others = {
        name: variables[variable.name]
        for name, variables in slaves.items()
        if name != target and variable.name in variables
    }
    full = f"{target}.{variable.name}"
    hidden = [name for name, other in others.items() if other.causality == "local"]
    if hidden:
        raise StructureError(
            f"{full} is an input, but {hidden[0]}.{variable.name} is declared a local variable; "
            "declare it an output to connect the two"
        )
    outputs = {name: other for name, other in others.items() if other.causality == "output"}
    if not outputs:
        return None, "no other FMU has an output of this name"
    if len(outputs) > 1:
        raise StructureError(
            f"{full} is an input that {' and '.join(outputs)} both have an output for; "
            "only one can feed it"
        )
    source, output = next(iter(outputs.items()))
    if "real" not in (output.kind, variable.kind) or output.kind != variable.kind:
        return None, f"the output is {output.kind}, the input {variable.kind}; only reals connect"
    _check_unit(f"{source}.{variable.name}", output.unit, full, variable.unit)
    unit = variable.unit or output.unit
    return Connection(name=variable.name, source=source, target=target, unit=unit), ""


def _check_unit(source: str, given: str, target: str, expected: str) -> None:
    if given and expected and given != expected:
        raise StructureError(
            f"the output {source} is in {given}, but the input {target} is in {expected}; "
            "values are not converted, so declare the same unit on both sides"
        )


def _check_all_take_part(
    slaves: Mapping[str, Variables], connections: Sequence[Connection]
) -> None:
    if len(slaves) < 2:
        return
    for name, variables in slaves.items():
        if not any(name in (c.source, c.target) for c in connections):
            outputs = [v.name for v in variables.values() if v.causality == "output"][:3]
            inputs = [v.name for v in variables.values() if v.causality == "input"][:3]
            raise StructureError(
                f"{name}: none of its inputs ({', '.join(inputs) or 'it has none'}, ...) and "
                f"outputs ({', '.join(outputs) or 'it has none'}, ...) has the name of an output "
                "or input of another FMU, so there is nothing to connect; "
                "are these a vehicle and a track of the same contract?"
            )
