"""Rails and wheels together at the end of an internal step."""

import math
from typing import NamedTuple

import numpy as np
from rail_native import Array3, Array4, Matrix, kernel

from slab_track.contact.solve import contact_forces, rail_motion, solve_wheel
from slab_track.contact.wheelset import (
    ANGLE,
    LATERAL_FORCE,
    LONGITUDINAL_FORCE,
    NORMAL_FORCE,
    PENETRATION,
)
from slab_track.core import core
from slab_track.kernels.arrays import copy, set_zero
from slab_track.kernels.lateral import wheel_compliance

_SQRT_HALF = math.sqrt(0.5)
_SWEEPS = 20
_SWEEP_TOLERANCE = 3e-10
"""Change of a deflection under one wheel by the others, m, that needs no further sweep: at
the stiffness of contact and rail together 0.2 N."""

APPLIED, VERTICAL, PROFILES = 0, 1, 2
"""What acts between wheels and rails: given forces, eq. (1) on a level tread, real profiles."""


class Wheels(NamedTuple):
    """Forces and motions at the wheels, as in :class:`slab_track.state.WheelState`."""

    rail_force: Array3
    earlier_force: Array3
    normal: Array3
    creep: Array3
    rail: Array3
    wheelset: Matrix
    located: Array4
    forces: Array4


class Interaction(NamedTuple):
    """What the rails under the wheels do without wheel forces, and what these add.

    Attributes
    ----------
    free
        Motion of the axes without wheel forces: y, z, roll and rates, (w, 2, 6).
    same, cross
        Vertical deflection under a wheel per unit force under another one on the same rail
        and on the other rail, (w, w), m/N.
    compliance, mobility
        Displacement and rate of the axis under a wheel per unit force (y, z, roll)
        there, (w, 3, 3).
    """

    free: Array3
    same: Matrix
    cross: Matrix
    compliance: Array3
    mobility: Array3

    @classmethod
    def of(cls, wheels: int) -> "Interaction":
        """Return it for a number of wheelsets."""
        return cls(
            free=np.zeros((wheels, 2, 6)),
            same=np.zeros((wheels, wheels)),
            cross=np.zeros((wheels, wheels)),
            compliance=np.zeros((wheels, 3, 3)),
            mobility=np.zeros((wheels, 3, 3)),
        )


@kernel
def combine_symmetry_classes(vertical, at):
    """Write the vertical part of an :class:`Interaction` from what both classes do.

    ``vertical`` is :class:`slab_track.kernels.vertical.VerticalWork`.
    """
    z, rate, of_class = vertical.deflection, vertical.rate, vertical.compliance
    free, same, cross = at.free, at.same, at.cross
    compliance, mobility, by_class = at.compliance, at.mobility, vertical.mobility
    for wheel in range(same.shape[0]):
        for side in range(2):
            sign = 2.0 * side - 1.0
            free[wheel, side, 1] = _SQRT_HALF * (z[0, wheel] + sign * z[1, wheel])
            free[wheel, side, 4] = _SQRT_HALF * (rate[0, wheel] + sign * rate[1, wheel])
        for other in range(same.shape[0]):
            of_s, of_a = of_class[0, wheel, other], of_class[1, wheel, other]
            same[wheel, other], cross[wheel, other] = 0.5 * (of_s + of_a), 0.5 * (of_s - of_a)
        compliance[wheel, 1, 1] = same[wheel, wheel]
        mobility[wheel, 1, 1] = 0.5 * (by_class[0, wheel] + by_class[1, wheel])


@kernel
def add_lateral(constants, positions, step, work, at):
    """Add the lateral motion of both rails to an :class:`Interaction`.

    ``constants`` and ``work`` are those of :mod:`slab_track.kernels.lateral`.
    """
    flexible, to_rate, residual = work.flexible, 2.0 / step, constants.residual
    table, spacing, free = constants.compliance, constants.spacing, at.free
    left, right = work.motion_left, work.motion_right
    for wheel in range(positions.size):
        for side in range(2):
            motion, of = left[wheel] if side == 0 else right[wheel], free[wheel, side]
            of[0], of[2], of[3], of[5] = motion[0], motion[1], motion[2], motion[3]
        wheel_compliance(table, spacing, positions[wheel], flexible)
        own, rate = at.compliance[wheel], at.mobility[wheel]
        own[0, 0], own[2, 2] = flexible[0] + residual[0], flexible[2] + residual[1]
        own[0, 2] = own[2, 0] = flexible[1]
        rate[0, 0], rate[2, 2] = to_rate * flexible[0], to_rate * flexible[2]
        rate[0, 2] = rate[2, 0] = to_rate * flexible[1]


@kernel
def _add_others(free, same, cross, wheel, side, force, out):
    """Write the axis's motion (6,) under the forces (w, 2, 3) of all other wheels."""
    for i in range(6):
        out[i] = free[wheel, side, i]
    for other in range(force.shape[0]):
        if other != wheel:
            out[1] += same[wheel, other] * force[other, side, 1]
        out[1] += cross[wheel, other] * force[other, 1 - side, 1]


@kernel
def _extrapolate_forces(force, earlier, out):
    """Continue the forces (w, 2, 3) of the last two steps by straight lines."""
    for i in range(out.size):
        out.flat[i] = 2.0 * force.flat[i] - earlier.flat[i]


@kernel
def _moved_by_others(same, cross, force, before):
    """Largest change of a deflection by a change of the other wheels' forces, (w, 2, 3), m."""
    worst = 0.0
    for wheel in range(force.shape[0]):
        for side in range(2):
            moved = 0.0
            for other in range(force.shape[0]):
                if other != wheel:
                    change = force[other, side, 1] - before[other, side, 1]
                    moved += same[wheel, other] * change
                change = force[other, 1 - side, 1] - before[other, 1 - side, 1]
                moved += cross[wheel, other] * change
            worst = max(worst, abs(moved))
    return worst


@kernel
def _vertical_contact(half_distance, hertz_constant, approach, path, offsets, at, wheels):
    """Eq. (1) on a level tread: normal forces of all wheels."""
    b, free, normal = half_distance, at.free, wheels.normal
    rail_force, forces, wheelset = wheels.rail_force, wheels.forces, wheels.wheelset
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            approach[wheel, side, 0] = (
                path[wheel, 2]
                + lever * path[wheel, 3]
                - offsets[wheel, side, 0]
                - free[wheel, side, 1]
            )
    contact_forces(approach, at.same, at.cross, hertz_constant, normal, wheels.located)
    set_zero(wheelset)
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            force = normal[wheel, side, 0]
            rail_force[wheel, side, 1] = forces[wheel, side, 0, 0] = force
            wheelset[wheel, 2] -= force
            wheelset[wheel, 3] -= lever * force
    return True


@kernel
def _profile_contact(contact, grid, work, path, offsets, at, wheels):
    """Contact on real profiles: sweeps over all wheels."""
    free, offset, wheelset = work.rail_free, work.offset, work.wheelset
    good, others = True, work.other_force
    all_free, same, cross = at.free, at.same, at.cross
    compliance, mobility = at.compliance, at.mobility
    rail_force, total, rails = wheels.rail_force, wheels.wheelset, wheels.rail
    normal, creep = wheels.normal, wheels.creep
    located, forces = wheels.located, wheels.forces
    _extrapolate_forces(rail_force, wheels.earlier_force, others)
    copy(rail_force, wheels.earlier_force)
    for sweep in range(_SWEEPS):
        set_zero(total)
        # All wheels see the others' forces of the last sweep: no order, so mirror symmetry.
        if sweep > 0:
            copy(rail_force, others)
        for wheel in range(path.shape[0]):
            for side in range(2):
                _add_others(all_free, same, cross, wheel, side, others, free)
                offset[0], offset[1] = offsets[wheel, side, 1], offsets[wheel, side, 0]
                found = solve_wheel(
                    contact, grid, work, 2.0 * side - 1.0, path[wheel], free, compliance[wheel],
                    mobility[wheel], offset, rail_force[wheel, side], normal[wheel, side],
                    creep[wheel, side], wheelset, rails[wheel, side], located[wheel, side],
                    forces[wheel, side],
                )  # fmt: skip
                good = good and found
                for i in range(6):
                    total[wheel, i] += wheelset[i]
        if not good or _moved_by_others(same, cross, rail_force, others) < _SWEEP_TOLERANCE:
            break
    return good


@kernel
def interact(
    contact,
    grid,
    work,
    interface,
    half_distance,
    hertz_constant,
    path,
    offsets,
    applied,
    at,
    wheels,
):
    """Find the forces on the rails under all wheels; False where there is no solution.

    ``path`` (w, 11) is the wheelsets' motion, heights from first touch; ``offsets`` (w, 2, 2) the
    irregularity: side, direction (vertical, lateral), m; ``applied`` (w, 2, 3) the given forces.
    """
    if interface == VERTICAL:
        return _vertical_contact(
            half_distance, hertz_constant, work.other_force, path, offsets, at, wheels
        )
    if interface == PROFILES:
        return _profile_contact(contact, grid, work, path, offsets, at, wheels)
    copy(applied, wheels.rail_force)
    return True


@kernel
def report_rails(at, free, wheels):
    """Write the motion of the rails under the wheels, all forces of this step included.

    ``free`` (6,) is memory.
    """
    force, rails = wheels.rail_force, wheels.rail
    all_free, same, cross = at.free, at.same, at.cross
    compliance, mobility = at.compliance, at.mobility
    for wheel in range(rails.shape[0]):
        for side in range(2):
            _add_others(all_free, same, cross, wheel, side, force, free)
            rail_motion(
                free, compliance[wheel], mobility[wheel], force[wheel, side], rails[wheel, side]
            )


@core.entry
def wheel_outputs(wheels: Wheels, axis_depth: float, out: Array3) -> None:
    """Write what happens at the wheels, (WHEEL_OUTPUTS, wheels, 2).

    Rows as in :attr:`slab_track.state.TrackState.wheel_outputs`.
    """
    forces, rails, located = wheels.forces, wheels.rail, wheels.located
    rail_force = wheels.rail_force
    for wheel in range(out.shape[1]):
        for side in range(2):
            tread, flange, rail = forces[wheel, side, 0], forces[wheel, side, 1], rails[wheel, side]
            main = 1 if flange[NORMAL_FORCE] > tread[NORMAL_FORCE] else 0
            out[0, wheel, side] = tread[NORMAL_FORCE] + flange[NORMAL_FORCE]
            out[1, wheel, side] = tread[LONGITUDINAL_FORCE] + flange[LONGITUDINAL_FORCE]
            out[2, wheel, side] = tread[LATERAL_FORCE] + flange[LATERAL_FORCE]
            out[3, wheel, side] = located[wheel, side, main, PENETRATION]
            out[4, wheel, side] = located[wheel, side, main, ANGLE]
            out[5, wheel, side] = rail[1]
            out[6, wheel, side] = rail[0] + axis_depth * rail[2]
            out[7, wheel, side] = rail[2]
            out[8, wheel, side] = rail_force[wheel, side, 0]
            out[9, wheel, side] = rail_force[wheel, side, 1]
