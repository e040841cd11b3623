"""All outputs of an FMU in one text, for the steps in C.

An FMU made with pythonfmu hands over single values as Python objects, at 40 ns and more each. Ours
offer all outputs as one text besides: float64 numbers in hexadecimal digits, which costs a quarter
of that. An FMU that has no such variable is read value by value.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rail_cosim.exchange import Port
from rail_cosim.fmu import FmuSlave

NAME = "outputs.packed"
"""String variable: all real outputs, then all integer ones, in the order of the description."""


def names(port: Port) -> list[str]:
    """Return what the packed outputs of a port are, in their order.

    Empty if the FMU offers no packed outputs, or others than it gives singly.
    """
    slave = port.slave
    variables = slave.variables
    if not isinstance(slave, FmuSlave) or NAME not in variables or variables[NAME].kind != "string":
        return []
    outputs = [v for v in variables.values() if v.causality == "output"]
    reals = [v.name for v in outputs if v.kind == "real"]
    integers = [v.name for v in outputs if v.kind == "integer"]
    if set(reals) != set(port.outputs.names) or set(integers) != set(port.counters.names):
        return []
    return [*reals, *integers] if _is_right(slave, reals, integers) else []


def _is_right(slave: FmuSlave, reals: Sequence[str], integers: Sequence[str]) -> bool:
    """Whether the text gives what the single variables give."""
    try:
        given = np.frombuffer(bytes.fromhex(str(slave.get([NAME])[NAME])), dtype="<f8")
    except ValueError:
        return False
    names = [*reals, *integers]
    single = slave.get(names)
    return np.array_equal(given, [float(single[name]) for name in names])
