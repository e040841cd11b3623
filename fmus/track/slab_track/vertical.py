r"""Vertical motion of one symmetry class: one internal step by the trapezoidal rule.

Every modal coordinate is a scalar oscillator
:math:`\ddot q + c\dot q + \omega^2 q = g`. The trapezoidal rule (Newmark,
beta = 1/4, gamma = 1/2) is unconditionally stable, of second order, exact in
statics and conserves the energy of a linear undamped system:

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
and wheels they add :math:`r = R_w F - R p` with their static compliance. Their
rate in the fasteners' dampers is the backward difference of second order (BDF2),
:math:`(\tfrac32 r' - 2r + \tfrac12 r_{-1})/h`, so with :math:`\nu = k + \tfrac{3c}{2h}`

.. math:: p' = D\left(\tilde p - \tfrac{c}{h}(2r - \tfrac12 r_{-1})
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


class FieldState(NamedTuple):
    """Coordinates of one symmetry class: displacement, velocity, acceleration.

    Attributes
    ----------
    rail
        Shape (3, 2, N): derivative, branch, wave number.
    slab
        Shape (3, S, n): derivative, slab, mode.
    residual
        Compression of the fasteners by the modes left out, now and one internal step
        before, shape (2, P), m.
    """

    rail: np.ndarray
    slab: np.ndarray
    residual: np.ndarray


class StepOperator(NamedTuple):
    """Constants of one symmetry class for one internal step size h.

    Attributes
    ----------
    rail_weight, slab_weight
        alpha of each coordinate, shapes (2, N) and (n,).
    beta
        Deflection amplitude per unit modal wave force, shape (N,).
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
    lag
        c / h of each fastener, N/m, (P,).
    spacing
        Distance of the fasteners, m.
    ring
        True if the track closes on itself.
    """

    rail_omega_squared: np.ndarray
    rail_deflection: np.ndarray
    rail_weight: np.ndarray
    beta: np.ndarray
    wave_number: np.ndarray
    slab_omega_squared: np.ndarray
    slab_damping: np.ndarray
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
    lag: np.ndarray
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
    nu = track.stiffness + 1.5 * dampers / step
    return StepOperator(
        rail_omega_squared=rail.omega_squared,
        rail_deflection=track.participation,
        rail_weight=rail_weight,
        beta=beta,
        wave_number=rail.wave_number,
        slab_omega_squared=slab.omega_squared,
        slab_damping=slab.damping,
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
        lag=dampers / step,
        spacing=track.length / count,
        ring=track.ring,
    )


@numba.njit(cache=True)
def _free_step(state, omega_squared, damping, weight, step):
    """Advance all coordinates without any force, in place; broadcast over the first axis."""
    q, v, a = state[0], state[1], state[2]
    for i in range(q.shape[0]):
        for j in range(q.shape[1]):
            row = i if omega_squared.shape[0] > 1 else 0
            q_free = q[i, j] + step * v[i, j] + 0.25 * step * step * a[i, j]
            v_free = v[i, j] + 0.5 * step * a[i, j]
            a_free = -weight[row, j] * (damping[row, j] * v_free + omega_squared[row, j] * q_free)
            q[i, j] = q_free + 0.25 * step * step * a_free
            v[i, j] = v_free + 0.5 * step * a_free
            a[i, j] = a_free


@numba.njit(cache=True)
def _fastener_extension(operator, rail, slab):
    """Force the fasteners would have: stiffness and damping on rail minus slab, shape (P,)."""
    folded = np.zeros((2, operator.sines.shape[0]))
    deflection = operator.rail_deflection
    for k in range(operator.beta.size):
        row, sign = operator.fold_index[k], operator.fold_sign[k]
        for derivative in range(2):
            folded[derivative, row] += sign * (
                deflection[0, k] * rail[derivative, 0, k]
                + deflection[1, k] * rail[derivative, 1, k]
            )
    motion = folded @ operator.sines
    motion[0] -= (slab[0] @ operator.seats).ravel()
    motion[1] -= (slab[1] @ operator.seats).ravel()
    return operator.stiffness * motion[0] + operator.damping * motion[1]


@numba.njit(cache=True)
def _unfolded(operator, fastener_force):
    """Wave forces of the fasteners on the rail with positive sign, shape (N,)."""
    folded = operator.sines @ fastener_force
    wave = np.empty(operator.beta.size)
    for k in range(wave.size):
        wave[k] = operator.fold_sign[k] * folded[operator.fold_index[k]]
    return wave


class FreeStep(NamedTuple):
    """A step of one symmetry class without wheel forces, and what a wheel force adds.

    Attributes
    ----------
    fastener
        Fastener forces, (P,), N.
    per_wheel
        Fastener forces per unit wheel force, (w, P).
    deflection, rate
        Of the rail under the wheels, (w,), m and m/s.
    compliance, mobility
        Deflection and rate under the wheels per unit wheel force, (w, w).
    """

    fastener: np.ndarray
    per_wheel: np.ndarray
    deflection: np.ndarray
    rate: np.ndarray
    compliance: np.ndarray
    mobility: np.ndarray


@numba.njit(cache=True)
def _wheel_coupling(operator, positions):
    """Coupling of the wheels at ``positions`` (w,) with fasteners and with each other.

    Returns the deflection at the fasteners per unit wheel force by the modes and by the
    residual, (w, P) each, and that under the other wheels, (w, w) each.
    """
    wheels, fasteners = positions.size, operator.sines.shape[0]
    modal, residual = np.empty((wheels, fasteners)), np.empty((wheels, fasteners))
    direct, stiff = np.empty((wheels, wheels)), np.empty((wheels, wheels))
    bays = positions / operator.spacing
    for wheel in range(wheels):
        to_fasteners(operator.response_kernel, bays[wheel], modal[wheel])
        to_fasteners(operator.residual_kernel, bays[wheel], residual[wheel])
        for other in range(wheels):
            here, there = bays[wheel], bays[other]
            direct[wheel, other] = between(operator.response_kernel, here, there, operator.ring)
            stiff[wheel, other] = between(operator.residual_kernel, here, there, operator.ring)
    return modal, residual, direct, stiff


@numba.njit(cache=True)
def free_class_step(operator, field, shapes, positions, step):
    """Step one symmetry class with fasteners but without wheel forces.

    Advances the coordinates (free of all forces yet) in place; returns a
    :class:`FreeStep`.
    """
    rail, slab = field.rail, field.slab
    no_damping = np.zeros_like(operator.rail_omega_squared)
    _free_step(rail, operator.rail_omega_squared, no_damping, operator.rail_weight, step)
    _free_step(
        slab,
        operator.slab_omega_squared.reshape(1, -1),
        operator.slab_damping.reshape(1, -1),
        operator.slab_weight.reshape(1, -1),
        step,
    )
    modal, residual, direct, stiff = _wheel_coupling(operator, positions)
    extension = _fastener_extension(operator, rail, slab) - operator.lag * (
        2.0 * field.residual[0] - 0.5 * field.residual[1]
    )
    fastener = operator.solve @ extension
    clamped = operator.modal_gain * modal + operator.residual_gain * residual
    per_wheel = clamped @ operator.solve.T
    both = modal + residual
    shape = operator.rail_deflection
    deflection = shapes @ (shape[0] * rail[0, 0] + shape[1] * rail[0, 1]) - both @ fastener
    to_rate = 2.0 / step
    rate = shapes @ (shape[0] * rail[1, 0] + shape[1] * rail[1, 1]) - to_rate * (modal @ fastener)
    return FreeStep(
        fastener,
        per_wheel,
        deflection,
        rate,
        direct + stiff - both @ per_wheel.T,
        to_rate * (direct - modal @ per_wheel.T),
    )


@numba.njit(cache=True)
def close_class_step(operator, field, shapes, positions, step, fastener, forces):
    """Add the fastener forces (P,) and wheel forces (w,) to a free step, in place."""
    rail, slab = field.rail, field.slab
    quarter, half = 0.25 * step * step, 0.5 * step
    wave = forces @ shapes - _unfolded(operator, fastener)
    for branch in range(2):
        for k in range(wave.size):
            a = operator.rail_weight[branch, k] * operator.rail_deflection[branch, k] * wave[k]
            rail[0, branch, k] += quarter * a
            rail[1, branch, k] += half * a
            rail[2, branch, k] += a
    slab_a = (fastener.reshape(slab.shape[1], -1) @ operator.seats.T) * operator.slab_weight
    slab[0] += quarter * slab_a
    slab[1] += half * slab_a
    slab[2] += slab_a
    field.residual[1] = field.residual[0]
    field.residual[0] = -(operator.residual @ fastener)
    at_fasteners = np.empty(fastener.size)
    for wheel in range(forces.size):
        to_fasteners(operator.residual_kernel, positions[wheel] / operator.spacing, at_fasteners)
        field.residual[0] += forces[wheel] * at_fasteners
