"""The whole track over a communication step: vertical, lateral, contact, in that order."""

from typing import NamedTuple

import numba
import numpy as np

from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.tables import ContactTables
from slab_track.contact.wheelset import FORCED, LOCATED
from slab_track.lateral import (
    LateralOperator,
    close_rail,
    free_rail,
    motion_at_wheels,
    wheel_compliance,
)
from slab_track.vertical import (
    StepOperator,
    close_class_step,
    free_class_step,
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
    half_distance
        Of the rolling circles, m.
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
    half_distance: float
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


@numba.njit(cache=True)
def wheel_shapes(wave_number, positions):
    """Return the waves' shapes at every wheel, shape (wheels, N), by recurrence in k.

    The first wave number is 0 on a ring, which has cosines and sines in turn.
    """
    shapes = np.empty((positions.size, wave_number.size))
    if wave_number[0] == 0.0:
        for wheel in range(positions.size):
            theta = wave_number[1] * positions[wheel]
            cosine, sine = np.cos(theta), np.sin(theta)
            c, s = 1.0, 0.0
            shapes[wheel, 0] = 1.0
            for row in range(1, wave_number.size, 2):
                c, s = c * cosine - s * sine, s * cosine + c * sine
                shapes[wheel, row], shapes[wheel, row + 1] = c, s
        return shapes
    for wheel in range(positions.size):
        theta = wave_number[0] * positions[wheel]
        twice = 2.0 * np.cos(theta)
        previous, current = 0.0, np.sin(theta)
        for k in range(wave_number.size):
            shapes[wheel, k] = current
            previous, current = current, twice * current - previous
    return shapes


@numba.njit(cache=True)
def _vertical_contact(operator, path, offsets, same, cross, free, wheels):
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
                - free[wheel, side, 1]
            )
    start = wheels.normal[:, :, 0].copy()
    force, penetration = contact_forces(approach, same, cross, start, operator.hertz_constant)
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
def _profile_contact(operator, path, offsets, same, cross, mobility, lateral, free, wheels):
    """Contact on real profiles: sweeps over all wheels."""
    count = path.shape[0]
    row, own = np.empty(11), np.empty(6)
    offset, wheelset = np.empty(2), np.empty(6)
    compliance, rate = np.zeros((3, 3)), np.zeros((3, 3))
    grid = fastsim_grid(operator.contact.columns, operator.contact.strips)
    for _ in range(_SWEEPS):
        worst = 0.0
        wheels.wheelset[:] = 0.0
        good = True
        # All wheels see the others' forces of the last sweep: no order, so mirror symmetry.
        others = wheels.rail_force[:, :, 1].copy()
        for wheel in range(count):
            row[:] = path[wheel]
            for side in range(2):
                own[:] = free[wheel, side]
                for other in range(count):
                    if other != wheel:
                        own[1] += same[wheel, other] * others[other, side]
                    own[1] += cross[wheel, other] * others[other, 1 - side]
                _wheel_matrices(
                    same[wheel, wheel], mobility[wheel, wheel], lateral[wheel],
                    operator.lateral.residual, operator.step, operator.lateral_motion,
                    compliance, rate,
                )  # fmt: skip
                offset[0], offset[1] = offsets[wheel, side, 1], offsets[wheel, side, 0]
                good &= solve_wheel(
                    operator.contact, grid, 2.0 * side - 1.0, row, own, compliance, rate, offset,
                    wheels.rail_force[wheel, side], wheels.normal[wheel, side],
                    wheels.creep[wheel, side], wheelset, wheels.rail[wheel, side],
                    wheels.located[wheel, side], wheels.forces[wheel, side],
                )  # fmt: skip
                wheels.wheelset[wheel] += wheelset
                worst = max(worst, abs(wheels.rail_force[wheel, side, 1] - others[wheel, side]))
        if not good or worst * np.max(np.abs(cross)) < _SWEEP_TOLERANCE:
            break
    return good


@numba.njit(cache=True)
def _wheel_matrices(vertical, vertical_rate, lateral, residual, step, moving, compliance, rate):
    """Fill compliance and mobility of the rail's axis under a wheel, (3, 3): y, z, roll."""
    compliance[1, 1], rate[1, 1] = vertical, vertical_rate
    if not moving:
        return
    to_rate = 2.0 / step
    compliance[0, 0], compliance[2, 2] = lateral[0] + residual[0], lateral[2] + residual[1]
    compliance[0, 2] = compliance[2, 0] = lateral[1]
    rate[0, 0], rate[2, 2] = to_rate * lateral[0], to_rate * lateral[2]
    rate[0, 2] = rate[2, 0] = to_rate * lateral[1]


@numba.njit(cache=True)
def _interact(operator, path, offsets, applied, positions, free_s, free_a, free, wheels):
    """Find the forces on the rails under all wheels; False where there is no solution."""
    same = 0.5 * (free_s.compliance + free_a.compliance)
    cross = 0.5 * (free_s.compliance - free_a.compliance)
    mobility = 0.5 * (free_s.mobility + free_a.mobility)
    free[:, 0, 1] = _SQRT_HALF * (free_s.deflection - free_a.deflection)
    free[:, 1, 1] = _SQRT_HALF * (free_s.deflection + free_a.deflection)
    free[:, 0, 4] = _SQRT_HALF * (free_s.rate - free_a.rate)
    free[:, 1, 4] = _SQRT_HALF * (free_s.rate + free_a.rate)
    if operator.interface == VERTICAL:
        return _vertical_contact(operator, path, offsets, same, cross, free, wheels)
    lateral = np.zeros((positions.size, 3))
    for wheel in range(positions.size):
        wheel_compliance(operator.lateral, positions[wheel], lateral[wheel])
    if operator.interface == PROFILES:
        return _profile_contact(
            operator, path, offsets, same, cross, mobility, lateral, free, wheels
        )
    wheels.rail_force[:] = applied
    return True


@numba.njit(cache=True)
def _report_rails(operator, positions, free_s, free_a, free, wheels):
    """Motion of the rails under the wheels, all forces of this step included."""
    same = 0.5 * (free_s.compliance + free_a.compliance)
    cross = 0.5 * (free_s.compliance - free_a.compliance)
    mobility = 0.5 * (free_s.mobility + free_a.mobility)
    compliance, rate, lateral = np.zeros((3, 3)), np.zeros((3, 3)), np.empty(3)
    own = np.empty(6)
    for wheel in range(positions.size):
        wheel_compliance(operator.lateral, positions[wheel], lateral)
        _wheel_matrices(
            same[wheel, wheel], mobility[wheel, wheel], lateral, operator.lateral.residual,
            operator.step, operator.lateral_motion, compliance, rate,
        )  # fmt: skip
        for side in range(2):
            own[:] = free[wheel, side]
            for other in range(positions.size):
                if other != wheel:
                    own[1] += same[wheel, other] * wheels.rail_force[other, side, 1]
                own[1] += cross[wheel, other] * wheels.rail_force[other, 1 - side, 1]
            rail_motion(
                own, compliance, rate, wheels.rail_force[wheel, side], wheels.rail[wheel, side]
            )


@numba.njit(cache=True)
def advance(operator, state_s, state_a, rails, positions, path, offsets, applied, wheels):
    """Advance the track through several internal steps, in place.

    Parameters
    ----------
    operator
        :class:`TrackOperator`.
    state_s, state_a
        Vertical states of both classes (:class:`slab_track.vertical.FieldState`).
    rails
        Lateral and torsional coordinates of both rails, (2, 3, 3, N).
    positions
        Wheelsets in the window at the end of each internal step, (steps, wheels), m.
    path
        Motion rows there, (steps, wheels, 11); heights as the contact counts them.
    offsets
        Irregularity there: side, direction (vertical, lateral), (steps, wheels, 2, 2), m.
    applied
        Prescribed forces on the rails' axes for APPLIED, (wheels, 2, 3).
    wheels
        :class:`WheelState`, start values in, results out.

    Returns
    -------
    tuple
        Number of steps made (less than asked if one failed), and vertical and lateral
        fastener forces of the last one: (P, 2) symmetric and antisymmetric.
    """
    step = operator.step
    count = positions.shape[1]
    fasteners = np.zeros((operator.symmetric.sines.shape[0], 2))
    free = np.zeros((count, 2, 6))
    moving = operator.lateral_motion and operator.interface != VERTICAL
    for n in range(positions.shape[0]):
        x = positions[n]
        shapes = wheel_shapes(operator.symmetric.wave_number, x)
        free_s = free_class_step(operator.symmetric, state_s, shapes, x, step)
        free_a = free_class_step(operator.antisymmetric, state_a, shapes, x, step)
        extensions = np.zeros((2, 2, fasteners.shape[0]))
        if moving:
            for side in range(2):
                extensions[side] = free_rail(operator.lateral, rails[side], step)
                motion = motion_at_wheels(
                    operator.lateral, rails[side], extensions[side], shapes, step
                )
                free[:, side, 0], free[:, side, 2] = motion[:, 0], motion[:, 1]
                free[:, side, 3], free[:, side, 5] = motion[:, 2], motion[:, 3]
        good = _interact(operator, path[n], offsets[n], applied, x, free_s, free_a, free, wheels)
        if not good:
            return n, fasteners
        force_s = _SQRT_HALF * (wheels.rail_force[:, 0, 1] + wheels.rail_force[:, 1, 1])
        force_a = _SQRT_HALF * (wheels.rail_force[:, 1, 1] - wheels.rail_force[:, 0, 1])
        fasteners[:, 0] = free_s.fastener + force_s @ free_s.per_wheel
        fasteners[:, 1] = free_a.fastener + force_a @ free_a.per_wheel
        close_class_step(
            operator.symmetric, state_s, shapes, x, step, fasteners[:, 0].copy(), force_s
        )
        close_class_step(
            operator.antisymmetric, state_a, shapes, x, step, fasteners[:, 1].copy(), force_a
        )
        if moving:
            load = np.empty((count, 2))
            for side in range(2):
                load[:, 0], load[:, 1] = (
                    wheels.rail_force[:, side, 0], wheels.rail_force[:, side, 2],
                )  # fmt: skip
                close_rail(operator.lateral, rails[side], extensions[side], shapes, load, step)
        _report_rails(operator, x, free_s, free_a, free, wheels)
    return positions.shape[0], fasteners
