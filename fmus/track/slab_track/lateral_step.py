"""One internal step of a rail's lateral bending and torsion (see :mod:`slab_track.lateral`)."""

import math
from typing import NamedTuple

import numpy as np

from slab_track.compiled import entry, kernel, stream
from slab_track.folding import sum_order
from slab_track.halves import half_size
from slab_track.lateral import PHASES, LateralTrack, lateral_operator
from slab_track.oscillators import add_force, add_scaled, dot, fold, step_last, step_waves
from slab_track.waves import fastener_shapes


class LateralConstants(NamedTuple):
    """What a step of a rail takes.

    Attributes
    ----------
    softening, amplitude, drive
        alpha omega^2, displacement per unit coordinate phi, and alpha phi of the three branches
        (bending, shear, torsion), one after the other, (3N,).
    response
        Displacement amplitude per unit wave force: lateral, roll; h^2/4 beta, (2, N).
    solve, weight
        Inverse of the fasteners' 2 x 2 problems, (4, 2h), and the sum of the squares of their
        shapes, (2h,), in the order of :class:`slab_track.folding.Folding`.
    gain, stiffness, damping
        k + 2c/h, k and c of a fastener: lateral and against roll, (2,).
    foot
        Height of the axis above the rail base h_f, m.
    residual
        Static compliance of the modes left out, under a wheel, lateral and in roll, (2,).
    compliance
        Modal part under a wheel over the place between two fasteners, (PHASES + 3, 3).
    spacing
        Distance of the fasteners, m.
    """

    softening: np.ndarray
    amplitude: np.ndarray
    drive: np.ndarray
    response: np.ndarray
    solve: np.ndarray
    weight: np.ndarray
    gain: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    foot: float
    residual: np.ndarray
    compliance: np.ndarray
    spacing: float


def lateral_constants(track: LateralTrack, step: float) -> LateralConstants:
    """Return the constants of an internal step in s."""
    operator, count = lateral_operator(track, step), track.class_weight.size
    order = sum_order(fastener_shapes(count, ring=track.bending.waves.ring))
    solve, weight = np.zeros((4, 2 * half_size(count))), np.zeros(2 * half_size(count))
    solve[:, order], weight[order] = operator.solve.reshape(4, count), track.class_weight
    return LateralConstants(
        softening=operator.softening,
        amplitude=operator.amplitude.ravel(),
        drive=operator.drive.ravel(),
        response=operator.response,
        solve=solve,
        weight=weight,
        gain=operator.gain,
        stiffness=operator.stiffness,
        damping=operator.damping,
        foot=operator.foot,
        residual=operator.residual,
        compliance=operator.compliance,
        spacing=operator.spacing,
    )


@kernel
def free_rail(constants, folding, old, shapes, step, new, taken, motion, room):
    """Step a rail with fasteners but without wheel forces.

    Parameters
    ----------
    constants, folding
        :class:`LateralConstants` and :class:`slab_track.folding.Folding`.
    old, new
        Coordinates at the start, and room for those at the end, free of all forces yet, (3, 3N).
    shapes
        Of the waves under the wheels, (w, N).
    step
        s.
    taken
        Receives wave force and moment that the fasteners take from the rail, folded, (2, 2h).
    motion
        Receives displacement, roll and their rates under the wheels, (w, 4).
    room
        :class:`slab_track.room.Room`.
    """
    waves, extension = room.waves, room.more_waves
    step_waves(old, constants.softening, constants.amplitude, step, new, waves[0], waves[2])
    step_last(old, constants.softening, constants.amplitude, step, new, waves[1], waves[3])
    _extend(
        constants.stiffness, constants.damping, constants.foot, waves[0], waves[1], waves[2],
        waves[3], extension[0], extension[1],
    )  # fmt: skip
    _take(constants, folding, extension, taken)
    for direction in range(2):
        _hold(
            constants.response[direction], folding.home, folding.home_sign, taken[direction],
            2.0 / step, waves[direction], waves[2 + direction],
        )  # fmt: skip
    for wheel in range(shapes.shape[0]):
        for i in range(4):
            motion[wheel, i] = dot(shapes[wheel], waves[i])


@stream
def _extend(stiffness, damping, foot, y, roll, y_rate, roll_rate, lateral, moment):
    """Force and moment of held fasteners per wave, from the motion of the axis."""
    k_y, k_m, c_y, c_m = stiffness[0], stiffness[1], damping[0], damping[1]
    for k in range(y.size):
        lateral[k] = k_y * (y[k] - foot * roll[k]) + c_y * (y_rate[k] - foot * roll_rate[k])
    for k in range(y.size):
        moment[k] = k_m * roll[k] + c_m * roll_rate[k]


@kernel
def _take(constants, folding, extension, taken):
    """Fill ``taken`` (2, 2h) for fasteners whose held forces per wave are (2, N)."""
    size, foot = constants.weight.size, constants.foot
    for direction in range(2):
        fold(folding.place, folding.sign, extension[direction], taken[direction])
    solve = constants.solve
    for i in range(size):
        a, b = taken[0, i], taken[1, i]
        force = solve[0, i] * a + solve[1, i] * b
        moment = solve[2, i] * a + solve[3, i] * b
        taken[0, i] = constants.weight[i] * force
        taken[1, i] = constants.weight[i] * (moment - foot * force)


@stream
def _hold(response, home, sign, taken, to_rate, displacement, rate):
    """Take the answer to what the fasteners take, (2h,), from the waves (N,), in place."""
    for k in range(displacement.size):
        change = response[k] * sign[k] * taken[home[k]]
        displacement[k] -= change
        rate[k] -= to_rate * change


@kernel
def close_rail(constants, folding, free, shapes, forces, step, room, new):
    """Add wheel forces and moments (2, w) and fastener forces to a free step, in place.

    ``free`` (2, 2h) is what the fasteners take without wheel forces.
    """
    foot, load, extension, taken = constants.foot, room.waves, room.more_waves, room.taken
    for direction in range(2):
        _push(forces[direction], shapes, load[direction])
    _load_extension(constants.gain, foot, constants.response, load, extension[0], extension[1])
    _take(constants, folding, extension, taken)
    for direction in range(2):
        add_scaled(1.0, free[direction], taken[direction])
        _let_go(folding.home, folding.home_sign, taken[direction], load[direction])
    add_force(new, 0, constants.drive, load[0], step)
    add_force(new, 1, constants.drive, load[0], step)
    add_force(new, 2, constants.drive, load[1], step)


@stream
def _push(force, shapes, out):
    """Wave force (N,) of forces (w,) at places whose shapes are (w, N)."""
    for k in range(out.size):
        out[k] = 0.0
    for wheel in range(force.size):
        for k in range(out.size):
            out[k] += force[wheel] * shapes[wheel, k]


@stream
def _load_extension(gain, foot, response, load, lateral, moment):
    for k in range(lateral.size):
        roll = response[1, k] * load[1, k]
        lateral[k] = gain[0] * (response[0, k] * load[0, k] - foot * roll)
        moment[k] = gain[1] * roll


@stream
def _let_go(home, sign, taken, load):
    """Take what the fasteners take, (2h,), from the waves' load (N,)."""
    for k in range(load.size):
        load[k] -= sign[k] * taken[home[k]]


@entry
def wheel_compliance(table, spacing, position, out):
    """Modal compliance (y/F, y/M, roll/M) under a wheel at ``position``, m, into ``out`` (3,).

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
