"""The whole track over a communication step: vertical, lateral, contact, in that order."""

from typing import NamedTuple

import numba
import numpy as np
from numba.experimental import structref

from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.tables import ContactTables
from slab_track.contact.wheelset import (
    ANGLE,
    FORCED,
    LATERAL_FORCE,
    LOCATED,
    LONGITUDINAL_FORCE,
    NORMAL_FORCE,
    PENETRATION,
)
from slab_track.irregularity.kernels import IrregularityData, evaluate_into
from slab_track.lateral import LateralOperator, close_rail, free_rail, wheel_compliance
from slab_track.vertical import (
    FieldState,
    StepOperator,
    close_class_step,
    free_class_step,
    wheel_coupling,
)
from slab_track.wheels import contact_forces, rail_motion, solve_wheel

_SQRT_HALF = np.sqrt(0.5)
_SWEEPS = 20
_SWEEP_TOLERANCE = 1e-10
"""Change of a deflection under one wheel by the others, m, that needs no further sweep."""

APPLIED, VERTICAL, PROFILES = 0, 1, 2
"""What acts between wheels and rails: given forces, eq. (1) on a level tread, real profiles."""


class TrackOperator(NamedTuple):
    """All constants of a track for one internal step size.

    Attributes
    ----------
    symmetric, antisymmetric
        Vertical motion of both classes.
    lateral
        Lateral motion and torsion of either rail.
    contact
        Tables of the contact.
    interface
        APPLIED, VERTICAL or PROFILES.
    lateral_motion
        False if the rails are held laterally and in roll.
    hertz_constant
        Of eq. (1) for VERTICAL, m/N^(2/3).
    irregularity
        What :func:`slab_track.irregularity.kernels.evaluate_into` takes.
    half_distance
        Of the rolling circles, m.
    axis_depth
        Of the rails' axes below their heads, m.
    step
        Internal step, s.
    """

    symmetric: StepOperator
    antisymmetric: StepOperator
    lateral: LateralOperator
    contact: ContactTables
    interface: int
    lateral_motion: bool
    hertz_constant: float
    irregularity: IrregularityData
    half_distance: float
    axis_depth: float
    step: float


class WheelState(NamedTuple):
    """What happens at the wheels; left first.

    Attributes
    ----------
    rail_force
        Force on the rail's axis: lateral, vertical, roll moment, (wheels, 2, 3).
    normal, creep
        Normal and lateral creep force of the patches (tread, flange), (wheels, 2, 2), N.
    rail
        Motion of the rail's axis: y, z, roll and rates, (wheels, 2, 6).
    wheelset
        Contact force and moment on each wheelset, (wheels, 6).
    located, forces
        Patches, columns as in :mod:`slab_track.contact.wheelset`.
    """

    rail_force: np.ndarray
    normal: np.ndarray
    creep: np.ndarray
    rail: np.ndarray
    wheelset: np.ndarray
    located: np.ndarray
    forces: np.ndarray

    @classmethod
    def empty(cls, wheels: int) -> "WheelState":
        """Return wheels without any force."""
        return cls(
            rail_force=np.zeros((wheels, 2, 3)),
            normal=np.zeros((wheels, 2, 2)),
            creep=np.zeros((wheels, 2, 2)),
            rail=np.zeros((wheels, 2, 6)),
            wheelset=np.zeros((wheels, 6)),
            located=np.zeros((wheels, 2, 2, LOCATED)),
            forces=np.zeros((wheels, 2, 2, FORCED)),
        )


@structref.register
class _BoxType(numba.types.StructRef):
    """Numba's type of :class:`OperatorBox`."""


class OperatorBox(structref.StructRefProxy):
    """A :class:`TrackOperator` that compiled code takes as one reference.

    A call with a named tuple reads all of its arrays anew, some 10 us for these.
    """

    def __new__(cls, operator: TrackOperator) -> "OperatorBox":
        """Put an operator into a box."""
        return structref.StructRefProxy.__new__(cls, operator)


structref.define_proxy(OperatorBox, _BoxType, ["operator"])


@numba.njit(cache=True)
def box(operator):
    """Return the :class:`OperatorBox` of a :class:`TrackOperator`."""
    return OperatorBox(operator)


_LANES = 8


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def wheel_shapes(wave_number, positions):
    """Return the waves' shapes at every wheel, shape (wheels, N), by recurrence in k.

    The first wave number is 0 on a ring, which has cosines and sines in turn. Eight rows
    ahead the angle has grown by a constant, so f(k+8) = 2 cos f(k) - f(k-8).
    """
    count = wave_number.size
    shapes = np.empty((positions.size, count))
    first = 1 if wave_number[0] == 0.0 else 0
    start = min(2 * _LANES + first, count)
    for wheel in range(positions.size):
        row, angle = shapes[wheel], wave_number[first] * positions[wheel]
        cosine, sine = np.cos(angle), np.sin(angle)
        c, s, twice = cosine, sine, 0.0
        if first == 1:
            row[0] = 1.0
        for k in range(first, start):
            if first == 0:
                row[k] = s
                turn = True
            else:
                row[k] = c if k % 2 == 1 else s
                turn = k % 2 == 0
            if k - first == _LANES - 1:
                twice = 2.0 * c
            if turn:
                c, s = c * cosine - s * sine, s * cosine + c * sine
        for k in range(start, count):
            row[k] = twice * row[k - _LANES] - row[k - 2 * _LANES]
    return shapes


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

    free: np.ndarray
    same: np.ndarray
    cross: np.ndarray
    compliance: np.ndarray
    mobility: np.ndarray


@numba.njit(cache=True)
def _interaction(operator, positions, free_s, free_a, motions, moving):
    """Put both classes and the lateral motions (2, w, 4) together: an :class:`Interaction`."""
    count = positions.size
    free = np.zeros((count, 2, 6))
    same = 0.5 * (free_s.compliance + free_a.compliance)
    cross = 0.5 * (free_s.compliance - free_a.compliance)
    compliance, mobility = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    lateral, to_rate = np.empty(3), 2.0 / operator.step
    for wheel in range(count):
        for side in range(2):
            sign = 2.0 * side - 1.0
            free[wheel, side, 1] = _SQRT_HALF * (
                free_s.deflection[wheel] + sign * free_a.deflection[wheel]
            )
            free[wheel, side, 4] = _SQRT_HALF * (free_s.rate[wheel] + sign * free_a.rate[wheel])
        own, rate = compliance[wheel], mobility[wheel]
        own[1, 1] = same[wheel, wheel]
        rate[1, 1] = 0.5 * (free_s.mobility[wheel, wheel] + free_a.mobility[wheel, wheel])
        if not moving:
            continue
        for side in range(2):
            free[wheel, side, 0], free[wheel, side, 2] = motions[side, wheel, 0:2]
            free[wheel, side, 3], free[wheel, side, 5] = motions[side, wheel, 2:4]
        wheel_compliance(operator.lateral, positions[wheel], lateral)
        residual = operator.lateral.residual
        own[0, 0], own[2, 2] = lateral[0] + residual[0], lateral[2] + residual[1]
        own[0, 2] = own[2, 0] = lateral[1]
        rate[0, 0], rate[2, 2] = to_rate * lateral[0], to_rate * lateral[2]
        rate[0, 2] = rate[2, 0] = to_rate * lateral[1]
    return Interaction(free, same, cross, compliance, mobility)


@numba.njit(cache=True)
def _add_others(at, wheel, side, force, out):
    """Fill ``out`` (6,) with the axis's motion under the forces (w, 2, 3) of all other wheels."""
    out[:] = at.free[wheel, side]
    for other in range(force.shape[0]):
        if other != wheel:
            out[1] += at.same[wheel, other] * force[other, side, 1]
        out[1] += at.cross[wheel, other] * force[other, 1 - side, 1]


@numba.njit(cache=True)
def _vertical_contact(operator, path, offsets, at, wheels):
    """Eq. (1) on a level tread: normal forces of all wheels."""
    b = operator.half_distance
    approach = np.empty((path.shape[0], 2))
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            approach[wheel, side] = (
                path[wheel, 2]
                + lever * path[wheel, 3]
                - offsets[wheel, side, 0]
                - at.free[wheel, side, 1]
            )
    start = wheels.normal[:, :, 0].copy()
    force, penetration = contact_forces(approach, at.same, at.cross, start, operator.hertz_constant)
    wheels.normal[:, :, 0] = force
    wheels.wheelset[:] = 0.0
    for wheel in range(path.shape[0]):
        for side in range(2):
            lever = b if side == 1 else -b
            wheels.rail_force[wheel, side, 1] = force[wheel, side]
            wheels.located[wheel, side, 0, 0] = penetration[wheel, side]
            wheels.forces[wheel, side, 0, 0] = force[wheel, side]
            wheels.wheelset[wheel, 2] -= force[wheel, side]
            wheels.wheelset[wheel, 3] -= lever * force[wheel, side]
    return True


@numba.njit(cache=True)
def _profile_contact(operator, path, offsets, at, wheels):
    """Contact on real profiles: sweeps over all wheels."""
    own, offset, wheelset = np.empty(6), np.empty(2), np.empty(6)
    grid = fastsim_grid(operator.contact.columns, operator.contact.strips)
    coupled = np.max(np.abs(at.cross))
    for wheel in range(path.shape[0]):
        for other in range(wheel):
            coupled = max(coupled, abs(at.same[wheel, other]))
    good = True
    for _ in range(_SWEEPS):
        worst = 0.0
        wheels.wheelset[:] = 0.0
        # All wheels see the others' forces of the last sweep: no order, so mirror symmetry.
        others = wheels.rail_force.copy()
        for wheel in range(path.shape[0]):
            for side in range(2):
                _add_others(at, wheel, side, others, own)
                offset[0], offset[1] = offsets[wheel, side, 1], offsets[wheel, side, 0]
                good &= solve_wheel(
                    operator.contact, grid, 2.0 * side - 1.0, path[wheel], own,
                    at.compliance[wheel], at.mobility[wheel], offset,
                    wheels.rail_force[wheel, side], wheels.normal[wheel, side],
                    wheels.creep[wheel, side], wheelset, wheels.rail[wheel, side],
                    wheels.located[wheel, side], wheels.forces[wheel, side],
                )  # fmt: skip
                for i in range(6):
                    wheels.wheelset[wheel, i] += wheelset[i]
                change = wheels.rail_force[wheel, side, 1] - others[wheel, side, 1]
                worst = max(worst, abs(change))
        if not good or worst * coupled < _SWEEP_TOLERANCE:
            break
    return good


@numba.njit(cache=True)
def _interact(operator, path, offsets, applied, at, wheels):
    """Find the forces on the rails under all wheels; False where there is no solution."""
    if operator.interface == VERTICAL:
        return _vertical_contact(operator, path, offsets, at, wheels)
    if operator.interface == PROFILES:
        return _profile_contact(operator, path, offsets, at, wheels)
    wheels.rail_force[:] = applied
    return True


@numba.njit(cache=True)
def _report_rails(at, wheels):
    """Motion of the rails under the wheels, all forces of this step included."""
    own = np.empty(6)
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


@numba.njit(cache=True)
def _internal_step(
    operator, old, new, positions, path, offsets, applied, wheels, report, fasteners
):
    """One internal step of :func:`advance`; False if it failed."""
    step, count = operator.step, positions.size
    moving = operator.lateral_motion and operator.interface != VERTICAL
    shapes = wheel_shapes(operator.symmetric.wave_number, positions)
    coupling = wheel_coupling(operator.symmetric, positions)
    free_s = free_class_step(
        operator.symmetric, old.symmetric, shapes, coupling, step, new.symmetric
    )
    free_a = free_class_step(
        operator.antisymmetric, old.antisymmetric, shapes, coupling, step, new.antisymmetric
    )
    motions = np.empty((2, count, 4))
    if moving:
        left = free_rail(operator.lateral, old.rails[0], shapes, step, new.rails[0])
        right = free_rail(operator.lateral, old.rails[1], shapes, step, new.rails[1])
        motions[0], motions[1] = left.motion, right.motion
    at = _interaction(operator, positions, free_s, free_a, motions, moving)
    if not _interact(operator, path, offsets, applied, at, wheels):
        return False
    if report:
        _report_rails(at, wheels)
    force = wheels.rail_force
    force_s = _SQRT_HALF * (force[:, 0, 1] + force[:, 1, 1])
    force_a = _SQRT_HALF * (force[:, 1, 1] - force[:, 0, 1])
    fasteners[0] = close_class_step(
        operator.symmetric, old.symmetric, free_s, shapes, coupling, force_s, step, new.symmetric
    )
    fasteners[1] = close_class_step(
        operator.antisymmetric, old.antisymmetric, free_a, shapes, coupling, force_a, step,
        new.antisymmetric,
    )  # fmt: skip
    if moving:
        load = np.empty((count, 2))
        load[:, 0], load[:, 1] = force[:, 0, 0], force[:, 0, 2]
        close_rail(operator.lateral, left, shapes, load, step, new.rails[0])
        load[:, 0], load[:, 1] = force[:, 1, 0], force[:, 1, 2]
        close_rail(operator.lateral, right, shapes, load, step, new.rails[1])
    else:
        new.rails[:] = old.rails
    return True


class Fields(NamedTuple):
    """Coordinates of the whole track.

    Attributes
    ----------
    symmetric, antisymmetric
        Vertical coordinates of both classes.
    rails
        Lateral and torsional coordinates of both rails, (2, 3, 3, N).
    """

    symmetric: FieldState
    antisymmetric: FieldState
    rails: np.ndarray


@numba.njit(cache=True)
def advance(box, old, new, positions, datum, path, applied, wheels, fasteners, answers):
    """Advance the track through several internal steps.

    Parameters
    ----------
    box
        :class:`OperatorBox`.
    old, new
        :class:`Fields` at the start, and those that receive the end.
    positions
        Wheelsets in the window at the end of each internal step, (steps, wheels), m.
    datum
        Height of the wheelsets above first touch at zero vertical displacement, m.
    path
        Wheelset motion at the end of each internal step, (steps, wheels, 11).
    applied
        Prescribed forces on the rails' axes for APPLIED, (wheels, 2, 3).
    wheels
        :class:`WheelState`, start values in, results out.
    fasteners
        Receives the vertical fastener forces: symmetric and antisymmetric class, (2, P).
    answers
        Receives what :func:`answer` gives.

    Returns
    -------
    int
        Number of steps made, less than asked if one failed.
    """
    operator = box.operator
    steps, count = path.shape[0], path.shape[1]
    offsets, slopes = np.empty((count, 2, 2)), np.empty((count, 2, 2))
    for n in range(steps):
        row, x = path[n].copy(), path[n, :, 0].copy()
        evaluate_into(x, operator.irregularity, offsets, slopes)
        row[:, 2] += datum
        good = _internal_step(
            operator, old, new, positions[n], row, offsets, applied, wheels,
            n == steps - 1, fasteners,
        )  # fmt: skip
        if not good:
            return n
        old = new
    answer(wheels, operator.axis_depth, answers)
    return steps


ANSWERS = 8
"""Rows of what :func:`answer` gives."""


@numba.njit(cache=True)
def answer(wheels, axis_depth, out):
    """Fill ``out`` (ANSWERS, wheels, 2) with what happens at the wheels.

    Rows: normal, longitudinal and lateral creep force, N; penetration, m, and contact
    angle, rad, of the patch that carries most; vertical and lateral displacement of the
    rail's axis and of its head, m; roll, rad.
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
