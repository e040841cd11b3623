"""All outputs of an FMU in one text, for the compiled steps of the master.

An FMU made with pythonfmu hands over single values as Python objects, at 40 ns and more each. Ours
offer all outputs as one text besides: float64 numbers in hexadecimal digits, which costs a quarter
of that. An FMU that has no such variable is read value by value.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from rail_cosim.exchange import Port
from rail_cosim.fmu import FmuSlave
from rail_cosim.kept_code import compiled

NAME = "outputs.packed"
"""String variable: all real outputs, then all integer ones, in the order of the description."""


def _make_words(typing: Any, address: Any) -> Any:
    """Take an address (int64) for one of 64-bit words."""
    pointer = types.CPointer(types.uint64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(pointer))

    return pointer(types.int64), generate


_words: Any = intrinsic(_make_words)


@compiled
def _number(digits: Any) -> Any:
    """Return the four bytes of eight hexadecimal digits that are the bytes of a word."""
    ones, low = np.uint64(0x0101010101010101), np.uint64(0x0F0F0F0F0F0F0F0F)
    nibbles = (digits & low) + np.uint64(9) * ((digits >> np.uint64(6)) & ones)
    pairs = (nibbles << np.uint64(4)) | (nibbles >> np.uint64(8))
    pairs &= np.uint64(0x00FF00FF00FF00FF)
    fours = (pairs | (pairs >> np.uint64(8))) & np.uint64(0x0000FFFF0000FFFF)
    return (fours | (fours >> np.uint64(16))) & np.uint64(0x00000000FFFFFFFF)


@compiled
def unpack(address: int, values: Any) -> bool:
    """Fill ``values`` (uint64, the bits of the numbers) from a text; False if it is too short.

    ``address`` is that of the text in memory. Each number is two words of digits.
    """
    words = carray(_words(address), (2 * values.size,))
    digit = np.uint64(0x2020202020202020)  # a bit that digits have and the end of a text has not
    for place in range(values.size):
        first, second = words[2 * place], words[2 * place + 1]
        if (first & second & digit) != digit:
            return False
        values[place] = _number(first) | (_number(second) << np.uint64(32))
    return True


def targets(port: Port, first: int, first_counter: int) -> NDArray[np.int64]:
    """Return where the packed outputs of a port go.

    Parameters
    ----------
    port
        Of an FMU.
    first, first_counter
        Places of its first real and integer output among those of all ports.

    Returns
    -------
    ndarray
        For each number its place among the real outputs; for integer ones -1 less their place.
        Empty if the FMU offers no packed outputs, or others than it gives singly.
    """
    slave = port.slave
    variables = slave.variables
    none = np.zeros(0, dtype=np.int64)
    if not isinstance(slave, FmuSlave) or NAME not in variables or variables[NAME].kind != "string":
        return none
    outputs = [v for v in variables.values() if v.causality == "output"]
    reals = [v.name for v in outputs if v.kind == "real"]
    integers = [v.name for v in outputs if v.kind == "integer"]
    names, counters = port.outputs.names, port.counters.names
    if set(reals) != set(names) or set(integers) != set(counters):
        return none
    if not _is_right(slave, reals, integers):
        return none
    places = [first + names.index(name) for name in reals]
    places += [-1 - first_counter - counters.index(name) for name in integers]
    return np.array(places, dtype=np.int64)


def _is_right(slave: FmuSlave, reals: Sequence[str], integers: Sequence[str]) -> bool:
    """Whether the text gives what the single variables give."""
    try:
        given = np.frombuffer(bytes.fromhex(str(slave.get([NAME])[NAME])), dtype="<f8")
    except ValueError:
        return False
    names = [*reals, *integers]
    single = slave.get(names)
    return np.array_equal(given, [float(single[name]) for name in names])
