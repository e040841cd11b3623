"""The compiled step as Python calls it: constants behind one reference, results in arrays."""

from typing import Any

import numba
import numpy as np
from numba.experimental import structref
from numpy.typing import NDArray
from rail_quantities.uncounted import borrowed

from rail_vehicle.compiled import entry
from rail_vehicle.kernel import GOOD, advance, write_outputs

Array = NDArray[np.float64]


@structref.register
class _ConstantsType(numba.types.StructRef):
    """Numba's type of :class:`StepConstants`."""


class StepConstants(structref.StructRefProxy):
    """What a step takes besides state and forces, as one reference for compiled code.

    Made by :func:`pack`.
    """


structref.define_proxy(
    StepConstants,
    _ConstantsType,
    [
        "known",
        "internal",
        "signals",
        "feedback",
        "constants",
        "law",
        "limits",
        "offsets",
        "values",
        "columns",
        "row_starts",
    ],
)


@entry
def pack(
    known: Array,
    internal: Array,
    signals: Array,
    feedback: Array,
    constants: Array,
    law: Array,
    limits: Array,
    offsets: Array,
    values: Array,
    columns: NDArray[np.int32],
    row_starts: NDArray[np.int32],
) -> Any:
    """Return a :class:`StepConstants`, which refers to the arrays but does not keep them.

    The first seven are described at :func:`advance`, the others at :func:`write_outputs`.
    """
    return StepConstants(
        borrowed(known),
        borrowed(internal),
        borrowed(signals),
        borrowed(feedback),
        borrowed(constants),
        borrowed(law),
        borrowed(limits),
        borrowed(offsets),
        borrowed(values),
        borrowed(columns),
        borrowed(row_starts),
    )


@entry
def step_into(
    made: Any,
    vector: Array,
    forces: Array,
    acceleration: float,
    step: float,
    count: int,
    result: Array,
    outputs: Array,
) -> int:
    """Advance as :func:`advance` with the :class:`StepConstants` ``made``; write the outputs.

    These stay as they are if it fails.
    """
    result, outputs = borrowed(result), borrowed(outputs)
    found = advance(
        borrowed(vector),
        borrowed(forces),
        acceleration,
        step,
        count,
        made.known,
        made.internal,
        made.signals,
        made.feedback,
        made.constants,
        made.law,
        made.limits,
        result,
    )
    if found == GOOD:
        write_outputs(made.offsets, made.values, made.columns, made.row_starts, result, outputs)
    return found
