r"""Vertical motion of one symmetry class: one internal step by the trapezoidal rule.

Every modal coordinate is a scalar oscillator
:math:`\ddot q + c\dot q + \omega^2 q = g`. The trapezoidal rule (Newmark,
beta = 1/4, gamma = 1/2; :mod:`slab_track.oscillators`) is unconditionally stable, of second
order, exact in statics and conserves the energy of a linear undamped system:

.. math:: \tilde q = q + h\dot q + \tfrac{h^2}{4}\ddot q,\quad
          \tilde{\dot q} = \dot q + \tfrac h2\ddot q,\quad
          \ddot q' = \alpha(g' - c\tilde{\dot q} - \omega^2\tilde q),\quad
          \alpha = 1/(1 + \tfrac h2 c + \tfrac{h^2}{4}\omega^2)

The modal forces g' hold the fastener forces p' and the wheel forces F', which
depend on the new motion. With the free step (g' = 0) known, the fasteners obey
a constant linear system, solved once per step size:

.. math:: p' = D\,(\tilde p + \mu Y_w F'),\quad
          D = (I + \mu Y)^{-1},\quad
          \mu = k\tfrac{h^2}{4} + c\tfrac h2

with Y the admittance at the fasteners, :math:`Y_w` that between fasteners and
wheels, and :math:`\tilde p` the fastener forces of the free step.

The modes left out of the series follow the forces without inertia: at fasteners
and wheels they add :math:`r = R_w F - R p` with their static compliance. Their rate in the
fasteners' dampers follows the same rule, :math:`\dot r' = \tfrac2h(r' - r) - \dot r`, so with
:math:`\nu = k + \tfrac{2c}{h}`

.. math:: p' = D\left(\tilde p - c(\tfrac2h r + \dot r)
          + (\mu Y_w + \nu R_w) F'\right),\quad D = (I + \mu Y + \nu R)^{-1}.

What remains per wheel is one scalar equation of Hertz's law with the compliance

.. math:: C = \tfrac{h^2}{4} Z_w^T\beta Z_w + R_{ww}
          - \left(\tfrac{h^2}{4} Y_w + R_w\right)^T D\,(\mu Y_w + \nu R_w).
"""

from typing import NamedTuple

import numba
import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.kernel import between, kernel_table, to_fasteners
from slab_track.oscillators import (
    add_acceleration,
    add_force,
    fold,
    step_damped,
    step_undamped,
    unfold,
    wave_amplitudes,
)


class FieldState(NamedTuple):
    """Coordinates of one symmetry class: displacement, velocity, acceleration.

    Attributes
    ----------
    rail
        Shape (3, 2, N): derivative, branch, wave number.
    slab
        Shape (3, S, n): derivative, slab, mode.
    residual
        Compression of the fasteners by the modes left out, m, and its rate, m/s, shape (2, P).
    """

    rail: np.ndarray
    slab: np.ndarray
    residual: np.ndarray


class StepOperator(NamedTuple):
    """Constants of one symmetry class for one internal step size h.

    Attributes
    ----------
    rail_softening, rail_participation, rail_drive
        alpha omega^2, deflection per unit coordinate phi, and alpha phi of both branches,
        one after the other, shape (2N,).
    wave_number
        Of the waves, shape (N,).
    slab_softening, slab_drag
        alpha omega^2 and alpha c of the modes of all slabs, shape (S n,).
    slab_weight
        alpha of the modes of a slab, shape (n,).
    seats
        Shapes at the seats, (n, C).
    sines, fold_index, fold_sign
        As in :class:`slab_track.assembly.LinearTrack`.
    solve
        D, shape (P, P).
    residual
        R, static compliance of the modes left out at the fasteners, shape (P, P), m/N.
    response_kernel, residual_kernel
        Tables of h^2/4 beta and of the residual (see :mod:`slab_track.kernel`).
    stiffness, damping
        k of all fasteners, N/m, and c of each, N.s/m, (P,).
    modal_gain, residual_gain
        mu / (h^2/4) and nu of each fastener, N/m, (P,).
    rate
        2 / h, 1/s.
    spacing
        Distance of the fasteners, m.
    ring
        True if the track closes on itself.
    """

    rail_softening: np.ndarray
    rail_participation: np.ndarray
    rail_drive: np.ndarray
    wave_number: np.ndarray
    slab_softening: np.ndarray
    slab_drag: np.ndarray
    slab_weight: np.ndarray
    seats: np.ndarray
    sines: np.ndarray
    fold_index: np.ndarray
    fold_sign: np.ndarray
    solve: np.ndarray
    residual: np.ndarray
    response_kernel: np.ndarray
    residual_kernel: np.ndarray
    stiffness: float
    damping: np.ndarray
    modal_gain: np.ndarray
    residual_gain: np.ndarray
    rate: float
    spacing: float
    ring: bool


def step_operator(track: LinearTrack, step: float, symmetry: int) -> StepOperator:
    """Return the operator for an internal step in s."""
    rail, slab = track.rail, track.slabs[symmetry]
    quarter = 0.25 * step**2
    rail_weight = 1.0 / (1.0 + quarter * rail.omega_squared)
    slab_weight = 1.0 / (1.0 + 0.5 * step * slab.damping + quarter * slab.omega_squared)
    beta = np.sum(track.participation**2 * rail_weight, axis=0)
    admittance = track.fastener_admittance(rail_weight, slab_weight, symmetry)
    residual = track.fastener_residual(symmetry)
    count = track.fastener_count
    dampers = track.damping + track.end_damping
    mu = quarter * track.stiffness + 0.5 * step * dampers
    nu = track.stiffness + 2.0 * dampers / step
    return StepOperator(
        rail_softening=(rail_weight * rail.omega_squared).ravel(),
        rail_participation=track.participation.ravel(),
        rail_drive=(rail_weight * track.participation).ravel(),
        wave_number=rail.wave_number,
        slab_softening=np.tile(slab_weight * slab.omega_squared, track.slab_count),
        slab_drag=np.tile(slab_weight * slab.damping, track.slab_count),
        slab_weight=slab_weight,
        seats=slab.seats,
        sines=track.fastener_sines,
        fold_index=track.fold_index,
        fold_sign=track.fold_sign,
        solve=np.linalg.inv(np.eye(count) + mu[:, None] * admittance + nu[:, None] * residual),
        residual=residual,
        response_kernel=kernel_table(quarter * beta, count, ring=track.ring),
        residual_kernel=kernel_table(track.residual_flexibility, count, ring=track.ring),
        stiffness=track.stiffness,
        damping=dampers,
        modal_gain=mu / quarter,
        residual_gain=nu,
        rate=2.0 / step,
        spacing=track.length / count,
        ring=track.ring,
    )


class WheelCoupling(NamedTuple):
    """How the wheels, the fasteners and the wheels among themselves are coupled by the rails.

    It is the same in both classes.

    Attributes
    ----------
    at_fasteners
        Deflection at the fasteners per unit wheel force: by the modes Y_w (times h^2/4), by all
        of them (with the residual R_w), and the residual alone, shape (3, w, P), m/N.
    clamped
        Force of held fasteners per unit wheel force, mu Y_w + nu R_w, shape (w, P).
    modal, total
        Deflection under the wheels per unit force under another one: by the modes and by
        all of them, shape (w, w), m/N.
    """

    at_fasteners: np.ndarray
    clamped: np.ndarray
    modal: np.ndarray
    total: np.ndarray


@numba.njit(cache=True)
def wheel_coupling(operator, positions):
    """Return the :class:`WheelCoupling` of wheels at ``positions`` (w,), m in the window."""
    wheels, fasteners = positions.size, operator.sines.shape[0]
    at_fasteners = np.empty((3, wheels, fasteners))
    clamped = np.empty((wheels, fasteners))
    modal, total = np.empty((wheels, wheels)), np.empty((wheels, wheels))
    ring = operator.ring
    for wheel in range(wheels):
        here = positions[wheel] / operator.spacing
        by_modes, by_all, residual = at_fasteners[0], at_fasteners[1], at_fasteners[2]
        to_fasteners(operator.response_kernel, here, by_modes[wheel])
        to_fasteners(operator.residual_kernel, here, residual[wheel])
        for i in range(fasteners):
            moving, static = by_modes[wheel, i], residual[wheel, i]
            by_all[wheel, i] = moving + static
            clamped[wheel, i] = operator.modal_gain[i] * moving + operator.residual_gain[i] * static
        for other in range(wheel + 1):
            there = positions[other] / operator.spacing
            moving = between(operator.response_kernel, here, there, ring)
            static = between(operator.residual_kernel, here, there, ring)
            modal[wheel, other] = modal[other, wheel] = moving
            total[wheel, other] = total[other, wheel] = moving + static
    return WheelCoupling(at_fasteners, clamped, modal, total)


class FreeStep(NamedTuple):
    """A step of one symmetry class without wheel forces, and what a wheel force adds.

    Attributes
    ----------
    fastener
        Fastener forces without wheel forces, and per unit force of each wheel, (1 + w, P), N.
    deflection, rate
        Of the rail under the wheels, (w,), m and m/s.
    compliance, mobility
        Deflection and rate under the wheels per unit wheel force, (w, w).
    """

    fastener: np.ndarray
    deflection: np.ndarray
    rate: np.ndarray
    compliance: np.ndarray
    mobility: np.ndarray


@numba.njit(cache=True)
def _held_forces(operator, waves, slab, residual):
    """Force of held fasteners after the free step of modes and residual, (P,)."""
    count = operator.sines.shape[0]
    folded = np.empty((2, count))
    for derivative in range(2):
        fold(operator.fold_index, operator.fold_sign, waves[derivative], folded[derivative])
    rail = folded @ operator.sines
    seats = (slab[:2].reshape(-1, slab.shape[2]) @ operator.seats).reshape(2, count)
    force = np.empty(count)
    for i in range(count):
        force[i] = operator.stiffness * (rail[0, i] - seats[0, i]) + operator.damping[i] * (
            rail[1, i] - seats[1, i] - operator.rate * residual[0, i] - residual[1, i]
        )
    return force


@numba.njit(cache=True)
def free_class_step(operator, old, shapes, coupling, step, new):
    """Step one symmetry class with fasteners but without wheel forces.

    Writes the coordinates, free of all forces yet, to ``new``, which may be ``old``
    (:class:`FieldState` both); returns a :class:`FreeStep`.
    """
    wheels, count = coupling.clamped.shape
    step_undamped(old.rail.reshape(3, -1), operator.rail_softening, step, new.rail.reshape(3, -1))
    step_damped(
        old.slab.reshape(3, -1),
        operator.slab_softening,
        operator.slab_drag,
        step,
        new.slab.reshape(3, -1),
    )
    waves = np.empty((2, shapes.shape[1]))
    for derivative in range(2):
        wave_amplitudes(
            operator.rail_participation, new.rail[derivative].ravel(), waves[derivative]
        )
    held = np.empty((1 + wheels, count))
    held[0] = _held_forces(operator, waves, new.slab, old.residual)
    held[1:] = coupling.clamped
    fastener = held @ operator.solve.T
    # Rows: modal part under each wheel, then all of it; columns: free, then per wheel force.
    taken = coupling.at_fasteners[:2].reshape(-1, count) @ fastener.T
    free = shapes @ waves.T
    to_rate = 2.0 / step
    return FreeStep(
        fastener,
        free[:, 0] - taken[wheels:, 0],
        free[:, 1] - to_rate * taken[:wheels, 0],
        coupling.total - taken[wheels:, 1:],
        to_rate * (coupling.modal - taken[:wheels, 1:]),
    )


@numba.njit(cache=True)
def close_class_step(operator, old, free, shapes, coupling, forces, step, new):
    """Add fastener forces and wheel forces (w,) to a free step, in place.

    Returns the fastener forces, (P,).
    """
    wheels, count = coupling.clamped.shape
    fastener = free.fastener[0].copy()
    residual = np.zeros(count)
    for wheel in range(wheels):
        share, own = free.fastener[1 + wheel], coupling.at_fasteners[2, wheel]
        for i in range(count):
            fastener[i] += forces[wheel] * share[i]
            residual[i] += forces[wheel] * own[i]
    residual -= operator.residual @ fastener
    wave = np.empty(shapes.shape[1])
    unfold(operator.fold_index, operator.fold_sign, operator.sines @ fastener, wave)
    wave = forces @ shapes - wave
    rail = new.rail.reshape(3, -1)
    add_force(rail, 0, operator.rail_drive[: wave.size], wave, step)
    add_force(rail, wave.size, operator.rail_drive[wave.size :], wave, step)
    on_slabs = fastener.reshape(new.slab.shape[1], -1) @ operator.seats.T
    add_acceleration(new.slab.reshape(3, -1), (on_slabs * operator.slab_weight).ravel(), step)
    for i in range(count):
        change = residual[i] - old.residual[0, i]
        new.residual[1, i] = operator.rate * change - old.residual[1, i]
        new.residual[0, i] = residual[i]
    return fastener
