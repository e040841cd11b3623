r"""The shift of the window, eqs. (8) to (11), by two fast transforms.

At the middle of M > N equal segments the shapes are orthogonal, so the least-squares solution of
(10) is :math:`Q = \tfrac2M\Phi^T D`; where the shift is a whole number of segments, D is the old
field's own samples (docs/theory_window.md). :func:`slab_track.window_shift.shift_state` says the
same with matrices.
"""

import math
from typing import NamedTuple

from rail_native import Array4, Matrix, Vector, fast_kernel, kernel

from slab_track.core import core
from slab_track.kernels.state import SHIFT_COUNT, SHIFT_RESIDUAL, WINDOW_START
from slab_track.kernels.transforms import Transform, samples_to_waves, waves_to_samples
from slab_track.kernels.vertical import VerticalFields

_SQRT_HALF = math.sqrt(0.5)


class Branches(NamedTuple):
    """Weights between a rail's coordinates and its waves (see :mod:`slab_track.branches`).

    Attributes
    ----------
    deflection, rotation
        Amplitude per unit coordinate, (2, N).
    from_deflection, from_rotation
        Coordinate per unit amplitude, (2, N).
    """

    deflection: Matrix
    rotation: Matrix
    from_deflection: Matrix
    from_rotation: Matrix


class ShiftConstants(NamedTuple):
    """Constants of a shift.

    Attributes
    ----------
    vertical, lateral
        Branches of the vertical and the lateral bending.
    participation
        Deflection per unit vertical coordinate as forces feel it, (2, N).
    kept
        Part of the old field that stays at the M - m sample points it covers, over 2 M.
    deflection, rotation
        Transforms of the length M of 18 and 12 rows.
    field
        Transform of 8 rows to the points ``bay`` of which lie in a fastener bay.
    deflection_rows, rotation_rows, field_rows
        Memory for them, (18, M), (12, M), (8, bay P).
    shift
        Distance, m.
    segments
        Of the M that the window moves by, m.
    slabs, fasteners, points, bay
        Slabs, fasteners and points of ``field`` that it moves by; points in a bay, odd.
    """

    vertical: Branches
    lateral: Branches
    participation: Matrix
    kept: Vector
    deflection: Transform
    rotation: Transform
    field: Transform
    deflection_rows: Matrix
    rotation_rows: Matrix
    field_rows: Matrix
    shift: float
    segments: int
    slabs: int
    fasteners: int
    points: int
    bay: int


@core.entry
def shift_window(
    constants: ShiftConstants,
    old: VerticalFields,
    old_lateral: Array4,
    head: Vector,
    new: VerticalFields,
    new_lateral: Array4,
) -> None:
    """Write the fields after a shift of the window, and tell of it in the new head."""
    shift_fields(constants, old, old_lateral, head, new, new_lateral)


@kernel
def shift_fields(constants, old, old_lateral, head, new, new_lateral):
    """Write the fields after a shift of the window, and tell of it in the head.

    Displacement, velocity and acceleration of the rails move alike; slabs and fasteners move by
    whole rows, and so does what the truncated modes add to the fasteners' compression.
    """
    slabs, fasteners = constants.slabs, constants.fasteners
    _move_rails(constants, old.rail, old_lateral, new.rail, new_lateral)
    slab, new_slab = old.slab, new.slab
    compression, new_compression = old.compression, new.compression
    force, new_force = old.fastener_force, new.fastener_force
    for symmetry in range(2):
        for row in range(3):
            _move_rows(slab[symmetry, row], slabs, new_slab[symmetry, row])
        for row in range(2):
            _move(compression[symmetry, row], fasteners, new_compression[symmetry, row])
        _move(force[symmetry], fasteners, new_force[symmetry])
    head[SHIFT_RESIDUAL] = _settle_compression(
        constants.participation, constants.field, constants.field_rows, constants.points,
        constants.bay, old.rail, new.rail, new_compression,
    )  # fmt: skip
    head[WINDOW_START] += constants.shift
    head[SHIFT_COUNT] += 1.0


@kernel
def _move_rails(constants, old, old_lateral, new, new_lateral):
    """Move deflection (sines), twist (sines) and rotation (cosines) of both rails."""
    z, psi = constants.deflection_rows, constants.rotation_rows
    kept, segments = constants.kept, constants.segments
    sines, cosines = constants.deflection, constants.rotation
    _gather(constants.vertical, constants.lateral, old, old_lateral, z, psi)
    waves_to_samples(sines, False, z)
    _keep(kept, segments, z)
    samples_to_waves(sines, False, z)
    waves_to_samples(cosines, True, psi)
    _keep(kept, segments, psi)
    samples_to_waves(cosines, True, psi)
    _scatter(constants.vertical, constants.lateral, z, psi, new, new_lateral)


@kernel
def _gather(vertical, lateral, rails, aside, z, psi):
    """Write deflections, twists (18, M) and rotations (12, M) of all rails."""
    for index in range(2):
        for row in range(3):
            here, there, twist = 3 * index + row, 6 + 3 * index + row, 12 + 3 * index + row
            _to_waves(vertical.deflection, rails[index, row], 0, z[here])
            _to_waves(vertical.rotation, rails[index, row], 1, psi[here])
            _to_waves(lateral.deflection, aside[index, row], 0, z[there])
            _to_waves(lateral.rotation, aside[index, row], 1, psi[there])
            for k in range(z.shape[1]):
                z[twist, k] = aside[index, row, 2, k] if k < aside.shape[3] else 0.0


@kernel
def _scatter(vertical, lateral, z, psi, rails, aside):
    """Write the coordinates of all rails from their waves, as in :func:`_gather`."""
    for index in range(2):
        for row in range(3):
            here, there, twist = 3 * index + row, 6 + 3 * index + row, 12 + 3 * index + row
            _from_waves(vertical, z[here], psi[here], rails[index, row])
            _from_waves(lateral, z[there], psi[there], aside[index, row])
            for k in range(aside.shape[3]):
                aside[index, row, 2, k] = z[twist, k]


@fast_kernel
def _to_waves(weight, coordinates, first, waves):
    """Write amplitudes of waves from ``first`` on, the rest zero; two branches (2 or more, N)."""
    count = weight.shape[1]
    for k in range(first):
        waves[k] = 0.0
    for k in range(count):
        waves[first + k] = weight[0, k] * coordinates[0, k] + weight[1, k] * coordinates[1, k]
    for k in range(first + count, waves.size):
        waves[k] = 0.0


@fast_kernel
def _from_waves(branches, deflection, rotation, coordinates):
    """Write the coordinates (2 or more, N) of waves; rotations begin with the constant."""
    to_z, to_psi = branches.from_deflection, branches.from_rotation
    for branch in range(2):
        for k in range(to_z.shape[1]):
            coordinates[branch, k] = (
                to_z[branch, k] * deflection[k] + to_psi[branch, k] * rotation[k + 1]
            )


@fast_kernel
def _keep(kept, segments, rows):
    """Move samples (k, M) back by ``segments``, in place; then comes track at rest, eq. (9)."""
    for row in range(rows.shape[0]):
        for i in range(kept.size):
            rows[row, i] = kept[i] * rows[row, i + segments]
        for i in range(kept.size, rows.shape[1]):
            rows[row, i] = 0.0


@kernel
def _move(old, count, new):
    """Move a vector (n,) back by ``count``; what is new is at rest."""
    for i in range(new.size):
        new[i] = old[i + count] if i + count < old.size else 0.0


@kernel
def _move_rows(old, count, new):
    """Move rows (n, ...) back by ``count``; what is new is at rest."""
    for i in range(new.shape[0]):
        for k in range(new.shape[1]):
            new[i, k] = old[i + count, k] if i + count < old.shape[0] else 0.0


@kernel
def _settle_compression(
    participation, transform, field, points, bay, old_rail, new_rail, compression
):
    """Add what the shift changes at the fasteners to their compression; return its residual, m."""
    for symmetry in range(2):
        for row in range(2):
            before, after = 2 * symmetry + row, 4 + 2 * symmetry + row
            _to_waves(participation, old_rail[symmetry, row], 0, field[before])
            _to_waves(participation, new_rail[symmetry, row], 0, field[after])
    waves_to_samples(transform, False, field)  # twice displacement and velocity
    count = field.shape[1]
    for symmetry in range(2):
        for row in range(2):
            for fastener in range(compression.shape[2]):
                here = fastener * bay + bay // 2
                change = field[4 + 2 * symmetry + row, here]
                if here + points < count:
                    change -= field[2 * symmetry + row, here + points]
                compression[symmetry, row, fastener] += 0.5 * change
    largest = 0.0
    for i in range(count - points):
        even, odd = field[4, i] - field[0, i + points], field[6, i] - field[2, i + points]
        largest = max(largest, abs(even - odd), abs(even + odd))
    return 0.5 * _SQRT_HALF * largest
