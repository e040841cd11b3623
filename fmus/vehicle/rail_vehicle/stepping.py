"""The compiled step as Python calls it: constants behind one reference, results in arrays."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rail_vehicle.compiled import entry
from rail_vehicle.kernel import GOOD, advance, write_outputs

Array = NDArray[np.float64]


class StepConstants(NamedTuple):
    """What a step takes besides state and forces.

    The first seven are described at :func:`advance`, the others at :func:`write_outputs`.
    """

    known: Array
    internal: Array
    signals: Array
    feedback: Array
    constants: Array
    law: Array
    limits: Array
    offsets: Array
    values: Array
    columns: NDArray[np.int32]
    row_starts: NDArray[np.int32]


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
    """Advance as :func:`advance` and write the outputs; these stay as they are if it fails.

    ``made`` is a reference to :class:`StepConstants`.
    """
    found = advance(
        vector,
        forces,
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
