"""Lateral bending and torsion of a rail over an internal step (see :mod:`slab_track.lateral`)."""

import math
from typing import NamedTuple

from rail_native import Matrix, Vector, fast_kernel, kernel

from slab_track.core import core
from slab_track.kernels.arrays import dot
from slab_track.kernels.waves import add_force, step_torsion, step_waves, sum_aliases
from slab_track.lateral import PHASES


class LateralConstants(NamedTuple):
    """Constants of a rail for one internal step size h.

    Attributes
    ----------
    softening, amplitude, drive
        alpha omega^2, displacement per unit coordinate phi, and alpha phi of the three branches
        (bending, shear, torsion), (3, N).
    response
        Displacement amplitude per unit wave force: lateral, roll; h^2/4 beta, (2, N).
    solve, weight
        Inverse of the fasteners' 2 x 2 problems, (4, 2h), and the sum of the squares of their
        shapes, (2h,), in the order of the aliases.
    gain, stiffness, damping
        k + 2c/h, k and c of a fastener: lateral and against roll, (2,).
    residual
        Static compliance of the truncated modes under a wheel, lateral and in roll, (2,).
    compliance
        Modal compliance under a wheel over the place between two fasteners, (PHASES + 3, 3).
    foot
        Height of the axis above the rail base h_f, m.
    spacing
        Distance of the fasteners, m.
    """

    softening: Matrix
    amplitude: Matrix
    drive: Matrix
    response: Matrix
    solve: Matrix
    weight: Vector
    gain: Vector
    stiffness: Vector
    damping: Vector
    residual: Vector
    compliance: Matrix
    foot: float
    spacing: float


class LateralWork(NamedTuple):
    """What a step of both rails computes on its way.

    Attributes
    ----------
    fastener_left, fastener_right
        Wave force and moment of the fasteners without wheel forces, sums of aliases, (2, 2h).
    fastener_load
        The same by wheel forces, (2, 2h).
    motion_left, motion_right
        Displacement, roll and their rates under the wheels without wheel forces, (w, 4).
    waves
        Displacement, roll and their rates of the waves, (4, N).
    force
        Wave force and moment, (2, N).
    flexible
        Compliance under a wheel (y/F, y/M, roll/M), (3,).
    """

    fastener_left: Matrix
    fastener_right: Matrix
    fastener_load: Matrix
    motion_left: Matrix
    motion_right: Matrix
    waves: Matrix
    force: Matrix
    flexible: Vector


@kernel
def free_rail(constants, aliasing, old, shapes, step, work, new, fastener, motion):
    """Step a rail with fasteners but without wheel forces.

    Parameters
    ----------
    constants, aliasing, work
        See there.
    old, new
        Coordinates at the start, and written: those at the end, free of new forces, (3, 3, N).
    shapes
        Of the waves under the wheels, (w, N).
    step
        h, s.
    fastener
        Written: wave force and moment of the fasteners, sums of aliases, (2, 2h).
    motion
        Written: displacement, roll and their rates under the wheels, (w, 4).
    """
    waves, held, response = work.waves, work.force, constants.response
    softening, amplitude = constants.softening, constants.amplitude
    alias, alias_sign = aliasing.alias, aliasing.alias_sign
    step_waves(old, softening, amplitude, step, new, waves[0], waves[2])
    step_torsion(old, softening, amplitude, step, new, waves[1], waves[3])
    _hold_foot(constants.foot, constants.stiffness, constants.damping, waves, held)
    solve_fasteners(
        constants.solve, constants.weight, constants.foot, aliasing.members,
        aliasing.member_sign, held, fastener,
    )  # fmt: skip
    for direction in range(2):
        _subtract_reaction(
            response[direction], alias, alias_sign, fastener[direction], 2.0 / step,
            waves[direction], waves[2 + direction],
        )  # fmt: skip
    for wheel in range(shapes.shape[0]):
        for i in range(4):
            motion[wheel, i] = dot(shapes[wheel], waves[i])


@fast_kernel
def _hold_foot(foot, stiffness, damping, waves, force):
    """Force and moment per wave of fasteners that are held: k x + c dx/dt at the rail's foot."""
    for k in range(force.shape[1]):
        base = waves[0, k] - foot * waves[1, k]
        base_rate = waves[2, k] - foot * waves[3, k]
        force[0, k] = stiffness[0] * base + damping[0] * base_rate
        force[1, k] = stiffness[1] * waves[1, k] + damping[1] * waves[3, k]


@kernel
def solve_fasteners(solve, weight, foot, members, member_sign, held, fastener):
    """Write wave force and moment of the fasteners (2, 2h) from held forces per wave (2, N)."""
    for direction in range(2):
        sum_aliases(members, member_sign, held[direction], fastener[direction])
    _solve_aliases(solve, weight, foot, fastener)


@fast_kernel
def _solve_aliases(solve, weight, foot, fastener):
    for i in range(weight.size):
        a, b = fastener[0, i], fastener[1, i]
        force = solve[0, i] * a + solve[1, i] * b
        moment = solve[2, i] * a + solve[3, i] * b
        fastener[0, i] = weight[i] * force
        fastener[1, i] = weight[i] * (moment - foot * force)


@fast_kernel
def _subtract_reaction(response, alias, alias_sign, fastener, to_rate, displacement, rate):
    """Subtract the response to the fasteners' sums (2h,) from the waves' motion (N,)."""
    for k in range(displacement.size):
        change = response[k] * alias_sign[k] * fastener[alias[k]]
        displacement[k] -= change
        rate[k] -= to_rate * change


@kernel
def close_rail(constants, aliasing, fastener, shapes, rail_force, side, step, work, new):
    """Add what wheel forces and fasteners do within the step.

    ``fastener`` (2, 2h) is that of the free step; ``rail_force`` (w, 2, 3): lateral, vertical force
    and roll moment on each rail's axis.
    """
    force, load, loaded, drive = work.force, work.waves, work.fastener_load, constants.drive
    alias, alias_sign = aliasing.alias, aliasing.alias_sign
    _load_waves(rail_force, side, shapes, force)
    _hold_loaded(constants.foot, constants.response, constants.gain, force, load)
    solve_fasteners(
        constants.solve, constants.weight, constants.foot, aliasing.members,
        aliasing.member_sign, load, loaded,
    )  # fmt: skip
    for direction in range(2):
        _take_fasteners(alias, alias_sign, fastener[direction], loaded[direction], force[direction])
    add_force(new, 0, drive, force[0], step)
    add_force(new, 1, drive, force[0], step)
    add_force(new, 2, drive, force[1], step)


@fast_kernel
def _load_waves(rail_force, side, shapes, force):
    """Write wave force and moment (2, N) of the wheels on a rail."""
    for direction in range(2):
        for k in range(force.shape[1]):
            force[direction, k] = 0.0
        for wheel in range(shapes.shape[0]):
            of_wheel = rail_force[wheel, side, 2 * direction]
            for k in range(force.shape[1]):
                force[direction, k] += of_wheel * shapes[wheel, k]


@fast_kernel
def _hold_loaded(foot, response, gain, force, held):
    """Force and moment per wave of held fasteners, for what wave forces (2, N) do in the step."""
    for k in range(force.shape[1]):
        roll = response[1, k] * force[1, k]
        held[0, k] = gain[0] * (response[0, k] * force[0, k] - foot * roll)
        held[1, k] = gain[1] * roll


@fast_kernel
def _take_fasteners(alias, alias_sign, free, loaded, force):
    """Subtract the fasteners' sums (2h,) from the waves' force (N,)."""
    for k in range(force.size):
        home = alias[k]
        force[k] -= alias_sign[k] * (free[home] + loaded[home])


@core.entry
def wheel_compliance(table: Matrix, spacing: float, position: float, out: Vector) -> None:
    """Write the modal compliance (y/F, y/M, roll/M) under a wheel at ``position``, m, (3,).

    ``table`` is that of :class:`LateralConstants`, ``spacing`` the fasteners' distance, m.
    """
    bays = position / spacing + 0.5
    phase = (bays - math.floor(bays)) * PHASES
    row = int(phase)
    f = phase - row
    for i in range(3):
        p0, p1, p2 = table[row, i], table[row + 1, i], table[row + 2, i]
        p3 = table[min(row + 3, PHASES + 2), i]
        out[i] = p1 + 0.5 * f * (
            p2 - p0 + f * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + f * (3.0 * (p1 - p2) + p3 - p0))
        )
