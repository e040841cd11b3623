"""Rails and wheels together at the end of an internal step."""

import math
from typing import NamedTuple

import numpy as np
from rail_quantities.uncounted import flat, on_stack

from slab_track.compiled import entry, kernel, stream
from slab_track.contact.wheelset import (
    ANGLE,
    LATERAL_FORCE,
    LONGITUDINAL_FORCE,
    NORMAL_FORCE,
    PENETRATION,
    clear,
)
from slab_track.lateral_step import wheel_compliance
from slab_track.oscillators import copy
from slab_track.wheels import contact_forces, rail_motion, solve_wheel

_SQRT_HALF = math.sqrt(0.5)
_SWEEPS = 20
_SWEEP_TOLERANCE = 3e-10
"""Change of a deflection under one wheel by the others, m, that needs no further sweep: at
the stiffness of contact and rail together 0.2 N."""

APPLIED, VERTICAL, PROFILES = 0, 1, 2
"""What acts between wheels and rails: given forces, eq. (1) on a level tread, real profiles."""


class Wheels(NamedTuple):
    """Forces and motions at the wheels, as in :class:`slab_track.state.WheelState`."""

    rail_force: np.ndarray
    earlier_force: np.ndarray
    normal: np.ndarray
    creep: np.ndarray
    rail: np.ndarray
    wheelset: np.ndarray
    located: np.ndarray
    forces: np.ndarray


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
    others
        Room for the forces of the other wheels that a sweep counts with, (w, 2, 3).
    """

    free: np.ndarray
    same: np.ndarray
    cross: np.ndarray
    compliance: np.ndarray
    mobility: np.ndarray
    others: np.ndarray

    @classmethod
    def empty(cls, wheels: int) -> "Interaction":
        """Return room for ``wheels``."""
        return cls(
            free=np.zeros((wheels, 2, 6)),
            same=np.zeros((wheels, wheels)),
            cross=np.zeros((wheels, wheels)),
            compliance=np.zeros((wheels, 3, 3)),
            mobility=np.zeros((wheels, 3, 3)),
            others=np.zeros((wheels, 2, 3)),
        )


@kernel
def put_together(free_s, free_a, at):
    """Fill the vertical part of an :class:`Interaction` from both classes."""
    free, same, cross = at.free, at.same, at.cross
    compliance, mobility = at.compliance, at.mobility
    count = free_s.deflection.size
    for wheel in range(count):
        for side in range(2):
            sign = 2.0 * side - 1.0
            free[wheel, side, 1] = _SQRT_HALF * (
                free_s.deflection[wheel] + sign * free_a.deflection[wheel]
            )
            free[wheel, side, 4] = _SQRT_HALF * (free_s.rate[wheel] + sign * free_a.rate[wheel])
        for other in range(count):
            of_s, of_a = free_s.compliance[wheel, other], free_a.compliance[wheel, other]
            same[wheel, other], cross[wheel, other] = 0.5 * (of_s + of_a), 0.5 * (of_s - of_a)
        compliance[wheel, 1, 1] = same[wheel, wheel]
        mobility[wheel, 1, 1] = 0.5 * (free_s.mobility[wheel] + free_a.mobility[wheel])


@kernel
def add_lateral(lateral, places, step, motions, at):
    """Add the lateral motion of both rails, (2, w, 4), to an :class:`Interaction`."""
    flexible, to_rate = on_stack(3), 2.0 / step
    for wheel in range(places.size):
        for side in range(2):
            motion, free = motions[side, wheel], at.free[wheel, side]
            free[0], free[2], free[3], free[5] = motion[0], motion[1], motion[2], motion[3]
        wheel_compliance(lateral.compliance, lateral.spacing, places[wheel], flexible)
        own, rate = at.compliance[wheel], at.mobility[wheel]
        own[0, 0] = flexible[0] + lateral.residual[0]
        own[2, 2] = flexible[2] + lateral.residual[1]
        own[0, 2] = own[2, 0] = flexible[1]
        rate[0, 0], rate[2, 2] = to_rate * flexible[0], to_rate * flexible[2]
        rate[0, 2] = rate[2, 0] = to_rate * flexible[1]


@kernel
def _add_others(at, wheel, side, force, out):
    """Fill ``out`` (6,) with the axis's motion under the forces (w, 2, 3) of all other wheels."""
    for i in range(6):
        out[i] = at.free[wheel, side, i]
    for other in range(force.shape[0]):
        if other != wheel:
            out[1] += at.same[wheel, other] * force[other, side, 1]
        out[1] += at.cross[wheel, other] * force[other, 1 - side, 1]


@stream
def _expect(force, earlier, out):
    """Continue forces (n,) of the last two steps by straight lines."""
    for i in range(out.size):
        out[i] = 2.0 * force[i] - earlier[i]


@kernel
def _moved_by_others(at, force, before):
    """Largest change of a deflection by a change of the other wheels' forces, (w, 2, 3), m."""
    worst = 0.0
    for wheel in range(force.shape[0]):
        for side in range(2):
            moved = 0.0
            for other in range(force.shape[0]):
                if other != wheel:
                    change = force[other, side, 1] - before[other, side, 1]
                    moved += at.same[wheel, other] * change
                change = force[other, 1 - side, 1] - before[other, 1 - side, 1]
                moved += at.cross[wheel, other] * change
            worst = max(worst, abs(moved))
    return worst


@kernel
def _vertical_contact(settings, path, offsets, at, wheels):
    """Eq. (1) on a level tread: normal forces of all wheels."""
    b = settings.half_distance
    approach = at.others
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            approach[wheel, side, 0] = (
                path[wheel, 2]
                + lever * path[wheel, 3]
                - offsets[wheel, side, 0]
                - at.free[wheel, side, 1]
            )
    contact_forces(approach, at.same, at.cross, settings.hertz_constant, wheels)
    clear(wheels.wheelset)
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            force = wheels.normal[wheel, side, 0]
            wheels.rail_force[wheel, side, 1] = wheels.forces[wheel, side, 0, 0] = force
            wheels.wheelset[wheel, 2] -= force
            wheels.wheelset[wheel, 3] -= lever * force
    return True


@kernel
def _profile_contact(contact, grid, path, offsets, at, wheels):
    """Contact on real profiles: sweeps over all wheels."""
    own, offset, wheelset = on_stack(6), on_stack(2), on_stack(6)
    good, others = True, at.others
    _expect(flat(wheels.rail_force), flat(wheels.earlier_force), flat(others))
    copy(flat(wheels.rail_force), flat(wheels.earlier_force))
    for sweep in range(_SWEEPS):
        clear(wheels.wheelset)
        # All wheels see the others' forces of the last sweep: no order, so mirror symmetry.
        if sweep > 0:
            copy(flat(wheels.rail_force), flat(others))
        for wheel in range(path.shape[0]):
            for side in range(2):
                _add_others(at, wheel, side, others, own)
                offset[0], offset[1] = offsets[wheel, side, 1], offsets[wheel, side, 0]
                good &= solve_wheel(
                    contact, grid, 2.0 * side - 1.0, path[wheel], own,
                    at.compliance[wheel], at.mobility[wheel], offset,
                    wheels.rail_force[wheel, side], wheels.normal[wheel, side],
                    wheels.creep[wheel, side], wheelset, wheels.rail[wheel, side],
                    wheels.located[wheel, side], wheels.forces[wheel, side],
                )  # fmt: skip
                for i in range(6):
                    wheels.wheelset[wheel, i] += wheelset[i]
        if not good or _moved_by_others(at, wheels.rail_force, others) < _SWEEP_TOLERANCE:
            break
    return good


@kernel
def interact(contact, grid, settings, path, offsets, applied, at, wheels):
    """Find the forces on the rails under all wheels; False where there is no solution.

    ``path`` (w, 11) is the wheelsets' motion, heights from first touch; ``offsets`` (w, 2, 2) the
    irregularity: side, direction (vertical, lateral), m; ``applied`` (w, 2, 3) the given forces.
    """
    if settings.interface == VERTICAL:
        return _vertical_contact(settings, path, offsets, at, wheels)
    if settings.interface == PROFILES:
        return _profile_contact(contact, grid, path, offsets, at, wheels)
    copy(flat(applied), flat(wheels.rail_force))
    return True


@kernel
def report_rails(at, wheels):
    """Motion of the rails under the wheels, all forces of this step included."""
    own = on_stack(6)
    for wheel in range(wheels.rail.shape[0]):
        for side in range(2):
            _add_others(at, wheel, side, wheels.rail_force, own)
            rail_motion(
                own,
                at.compliance[wheel],
                at.mobility[wheel],
                wheels.rail_force[wheel, side],
                wheels.rail[wheel, side],
            )


@entry
def answer(wheels, axis_depth, out):
    """Fill ``out`` (ANSWERS, wheels, 2) with what happens at the wheels.

    Rows as in :attr:`slab_track.state.TrackState.answers`.
    """
    for wheel in range(out.shape[1]):
        for side in range(2):
            force, rail = wheels.forces[wheel, side], wheels.rail[wheel, side]
            main = 1 if force[1, NORMAL_FORCE] > force[0, NORMAL_FORCE] else 0
            out[0, wheel, side] = force[0, NORMAL_FORCE] + force[1, NORMAL_FORCE]
            out[1, wheel, side] = force[0, LONGITUDINAL_FORCE] + force[1, LONGITUDINAL_FORCE]
            out[2, wheel, side] = force[0, LATERAL_FORCE] + force[1, LATERAL_FORCE]
            out[3, wheel, side] = wheels.located[wheel, side, main, PENETRATION]
            out[4, wheel, side] = wheels.located[wheel, side, main, ANGLE]
            out[5, wheel, side] = rail[1]
            out[6, wheel, side] = rail[0] + axis_depth * rail[2]
            out[7, wheel, side] = rail[2]
            out[8, wheel, side] = wheels.rail_force[wheel, side, 0]
            out[9, wheel, side] = wheels.rail_force[wheel, side, 1]
