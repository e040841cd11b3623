r"""Deflection of the rail per unit force as a function of distance, from tables.

The tables and why they suffice: :mod:`slab_track.kernel`.
"""

import math

from rail_native import Matrix, Vector, fast_kernel, kernel

from slab_track.core import core
from slab_track.kernel import PHASES


@kernel
def _weights(fraction, factor):
    """Cubic Lagrange weights at -1, 0, 1, 2 for a fraction in [0, 1), times a factor."""
    f = fraction
    return (
        factor * (-f * (f - 1.0) * (f - 2.0) / 6.0),
        factor * ((f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0),
        factor * (-(f + 1.0) * f * (f - 2.0) / 2.0),
        factor * ((f + 1.0) * f * (f - 1.0) / 6.0),
    )


@fast_kernel
def _add_line(table, row, weights, column, first, last, out):
    """Add the kernel between four rows to ``out[first:last]``, from ``column`` on."""
    w0, w1, w2, w3 = weights
    for i in range(first, last):
        c = column + i - first
        out[i] += (
            w0 * table[row, c] + w1 * table[row + 1, c]
            + w2 * table[row + 2, c] + w3 * table[row + 3, c]
        )  # fmt: skip


@core.entry
def to_fasteners(table: Matrix, position: float, out: Vector) -> None:
    """Write the response at all fasteners (P,) to a force at ``position``.

    ``position`` is in fastener bays from the window's start.
    """
    count, period = out.size, table.shape[1]
    place = position + 0.5
    bay = math.floor(place)
    phase = (place - bay) * PHASES
    row = int(phase)
    weights = _weights(phase - row, 1.0)
    if bay == 0 and period == count:
        bay = count
    for i in range(count):
        out[i] = 0.0
    # Fastener i is fraction - (i + 1 - bay) bays back.
    behind = min(max(bay - 1, 0), count)
    _add_line(table, row, weights, period - behind, 0, behind, out)
    _add_line(table, row, weights, behind + 1 - bay, behind, count, out)
    if period > count:  # K is even: K(fraction + bay + i) = K(1 - fraction - (bay + i + 1)).
        phase = PHASES - phase
        row = int(phase)
        weights = _weights(phase - row, -1.0)
        before = min(period - bay - 1, count)
        _add_line(table, row, weights, bay + 1, 0, before, out)
        _add_line(table, row, weights, 0, before, count, out)


@core.entry
def between(table: Matrix, first: float, second: float, ring: bool) -> float:
    """Response at ``second`` to a force at ``first``, both in bays from the window's start."""
    direct = _kernel(table, abs(first - second))
    if ring:
        return direct
    return direct - _kernel(table, first + second)


@kernel
def _kernel(table, distance):
    bay = math.floor(distance)
    phase = (distance - bay) * PHASES
    row = int(phase)
    w0, w1, w2, w3 = _weights(phase - row, 1.0)
    column = (-bay) % table.shape[1]
    return (
        w0 * table[row, column]
        + w1 * table[row + 1, column]
        + w2 * table[row + 2, column]
        + w3 * table[row + 3, column]
    )
