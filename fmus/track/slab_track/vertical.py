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
depend on the new motion. The modes left out of the series follow the forces without
inertia: at fasteners and wheels they add :math:`r = R_w F - R p` with their static compliance.
Their rate in the fasteners' dampers follows the same rule,
:math:`\dot r' = \tfrac2h(r' - r) - \dot r`. With the free step (g' = 0) known, the fasteners
obey a constant linear system, inverted once per step size:

.. math:: p' = S\,(u + A_w F'),\quad S = (\nu^{-1} + A)^{-1},\quad
          A = \tfrac{h^2}{4}Y + R,\quad \nu = k + \tfrac{2c}{h}

with Y the admittance at the fasteners, :math:`A_w` the same between fasteners and wheels, and
:math:`u = \nu^{-1}(\tilde p - c(\tfrac2h r + \dot r))` from the fastener forces
:math:`\tilde p` of the free step. What remains per wheel is one scalar equation of Hertz's law with
the compliance

.. math:: C = A_{ww} - A_w^T S A_w.
"""

from typing import NamedTuple

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.compiled import kernel
from slab_track.folding import Folding, make_folding
from slab_track.halves import apply, join, split, split_matrix
from slab_track.kernel import between, kernel_table, to_fasteners
from slab_track.oscillators import (
    add_force,
    add_scaled,
    copy,
    dot,
    fold,
    step_damped,
    step_waves,
    unfold,
)


class RailOperator(NamedTuple):
    """Constants of the rails and fasteners for one internal step size h, of both classes.

    In halves (2, h) are only what waves and residual do at the P fasteners
    (:mod:`slab_track.halves`): the fasteners' damping is not alike at both ends of the window.

    Attributes
    ----------
    softening, participation, drive
        alpha omega^2, deflection per unit coordinate phi, and alpha phi of both branches,
        one after the other, shape (2N,).
    wave_number
        Of the waves, shape (N,).
    folding
        Sums of waves that look alike at the fasteners.
    response_kernel, residual_kernel
        Tables of h^2/4 beta and of the residual (see :mod:`slab_track.kernel`).
    stiffness, damping
        k of all fasteners, N/m, and c of each, N.s/m, (P,).
    flexibility
        1/nu of each fastener, m/N, (P,).
    rate
        2 / h, 1/s.
    spacing
        Distance of the fasteners, m.
    ring
        True if the track closes on itself.
    """

    softening: np.ndarray
    participation: np.ndarray
    drive: np.ndarray
    wave_number: np.ndarray
    folding: Folding
    response_kernel: np.ndarray
    residual_kernel: np.ndarray
    stiffness: float
    damping: np.ndarray
    flexibility: np.ndarray
    rate: float
    spacing: float
    ring: bool


class ClassOperator(NamedTuple):
    """Constants of one symmetry class for one internal step size.

    Attributes
    ----------
    slab_softening, slab_drag, slab_weight
        alpha omega^2, alpha c and alpha of the modes of all slabs, shape (S n,).
    seats, from_seats
        Shapes at the seats, (n, C), and transposed.
    solve
        S, symmetric, fastener force per unit compression within a step, shape (P, P), N/m.
    residual
        R, static compliance of the modes left out at the fasteners, in halves, (2, h, h), m/N.
    """

    slab_softening: np.ndarray
    slab_drag: np.ndarray
    slab_weight: np.ndarray
    seats: np.ndarray
    from_seats: np.ndarray
    solve: np.ndarray
    residual: np.ndarray


def rail_operator(track: LinearTrack, step: float) -> RailOperator:
    """Return the constants that both classes share, for an internal step in s."""
    quarter, count, ring = 0.25 * step**2, track.fastener_count, track.ring
    weight = 1.0 / (1.0 + quarter * track.rail.omega_squared)
    beta = np.sum(track.participation**2 * weight, axis=0)
    dampers = track.damping + track.end_damping
    return RailOperator(
        softening=(weight * track.rail.omega_squared).ravel(),
        participation=track.participation.ravel(),
        drive=(weight * track.participation).ravel(),
        wave_number=track.rail.wave_number,
        folding=make_folding(track.fold_index, track.fold_sign, track.fastener_sines),
        response_kernel=kernel_table(quarter * beta, count, ring=ring),
        residual_kernel=kernel_table(track.residual_flexibility, count, ring=ring),
        stiffness=track.stiffness,
        damping=dampers,
        flexibility=1.0 / (track.stiffness + 2.0 / step * dampers),
        rate=2.0 / step,
        spacing=track.length / count,
        ring=ring,
    )


def class_operator(track: LinearTrack, step: float, symmetry: int) -> ClassOperator:
    """Return the constants of one symmetry class for an internal step in s."""
    rail, slab = track.rail, track.slabs[symmetry]
    quarter = 0.25 * step**2
    rail_weight = 1.0 / (1.0 + quarter * rail.omega_squared)
    slab_weight = 1.0 / (1.0 + 0.5 * step * slab.damping + quarter * slab.omega_squared)
    admittance = track.fastener_admittance(rail_weight, slab_weight, symmetry)
    residual = track.fastener_residual(symmetry)
    dampers = track.damping + track.end_damping
    nu = track.stiffness + 2.0 * dampers / step
    solve = np.linalg.inv(np.diag(1.0 / nu) + quarter * admittance + residual)
    return ClassOperator(
        slab_softening=np.tile(slab_weight * slab.omega_squared, track.slab_count),
        slab_drag=np.tile(slab_weight * slab.damping, track.slab_count),
        slab_weight=np.tile(slab_weight, track.slab_count),
        seats=slab.seats,
        from_seats=np.ascontiguousarray(slab.seats.T),
        solve=0.5 * (solve + solve.T),
        residual=split_matrix(residual),
    )


class WheelCoupling(NamedTuple):
    """How the wheels, the fasteners and the wheels among themselves are coupled by the rails.

    Attributes
    ----------
    by_modes, by_all, residual
        Deflection at the fasteners per unit wheel force, by the modes, by all of them and by those
        left out, shape (w, P), m/N.
    modal, total
        Deflection under the wheels per unit force under another one: by the modes and by
        all of them, shape (w, w), m/N.
    """

    by_modes: np.ndarray
    by_all: np.ndarray
    residual: np.ndarray
    modal: np.ndarray
    total: np.ndarray

    @classmethod
    def empty(cls, wheels: int, fasteners: int) -> "WheelCoupling":
        """Return room for as many wheels and fasteners."""
        shape, among = (wheels, fasteners), (wheels, wheels)
        return cls(
            np.empty(shape), np.empty(shape), np.empty(shape), np.empty(among), np.empty(among)
        )


@kernel
def wheel_coupling(rail, places, out):
    """Fill a :class:`WheelCoupling` for wheels at ``places`` (w,), m in the window."""
    by_modes, by_all, residual = out.by_modes, out.by_all, out.residual
    modal, total = out.modal, out.total
    for wheel in range(places.size):
        here = places[wheel] / rail.spacing
        to_fasteners(rail.response_kernel, here, by_modes[wheel])
        to_fasteners(rail.residual_kernel, here, residual[wheel])
        for i in range(by_all.shape[1]):
            by_all[wheel, i] = by_modes[wheel, i] + residual[wheel, i]
        for other in range(wheel + 1):
            there = places[other] / rail.spacing
            moving = between(rail.response_kernel, here, there, rail.ring)
            static = between(rail.residual_kernel, here, there, rail.ring)
            modal[wheel, other] = modal[other, wheel] = moving
            total[wheel, other] = total[other, wheel] = moving + static


class FreeStep(NamedTuple):
    """A step of one symmetry class without wheel forces, and what a wheel force adds.

    Attributes
    ----------
    fastener
        Fastener forces without wheel forces, and per unit force of each wheel, (1 + w, P), N.
    deflection, rate
        Of the rail under the wheels, (w,), m and m/s.
    compliance
        Deflection under the wheels per unit wheel force, (w, w).
    mobility
        Rate of deflection under a wheel per unit force of its own, (w,).
    """

    fastener: np.ndarray
    deflection: np.ndarray
    rate: np.ndarray
    compliance: np.ndarray
    mobility: np.ndarray

    @classmethod
    def empty(cls, wheels: int, fasteners: int) -> "FreeStep":
        """Return room for as many wheels and fasteners."""
        return cls(
            fastener=np.empty((1 + wheels, fasteners)),
            deflection=np.empty(wheels),
            rate=np.empty(wheels),
            compliance=np.empty((wheels, wheels)),
            mobility=np.empty(wheels),
        )


@kernel
def _held_forces(rail, seats, waves, slab, residual, out):
    """Fill ``out`` (P,) with u: what held fasteners are compressed by after the free step.

    ``waves`` (2, N) and ``slab`` (3, S n) after that step, ``residual`` (2, P) before it.
    """
    folding, count = rail.folding, out.size
    half = folding.to_fasteners.shape[1]
    sums, moved, at_fasteners = np.empty((2, half)), np.empty((2, half)), np.empty((2, count))
    under = np.dot(slab[:2].reshape((-1, seats.shape[0])), seats).ravel()
    for derivative in range(2):
        fold(folding.place, folding.sign, waves[derivative], sums.ravel())
        apply(folding.to_fasteners, sums, moved)
        join(moved, at_fasteners[derivative])
    for i in range(count):
        elastic = rail.stiffness * (at_fasteners[0, i] - under[i])
        squeeze = rail.rate * residual[0, i] + residual[1, i]
        viscous = rail.damping[i] * (at_fasteners[1, i] - under[count + i] - squeeze)
        out[i] = rail.flexibility[i] * (elastic + viscous)


@kernel
def free_class_step(rail, own, fields, coupling, shapes, step, out):
    """Step one symmetry class with fasteners but without wheel forces.

    ``rail`` and ``own`` are the operators, ``fields`` a :class:`ClassFields`, ``shapes`` (w, N)
    those of the waves under the wheels. Fills the :class:`FreeStep` ``out``.
    """
    wheels, count = coupling.by_all.shape
    waves, held = np.empty((2, shapes.shape[1])), np.empty((1 + wheels, count))
    step_waves(
        fields.old_rail, rail.softening, rail.participation, step, fields.new_rail,
        waves[0], waves[1],
    )  # fmt: skip
    step_damped(fields.old_slab, own.slab_softening, own.slab_drag, step, fields.new_slab)
    _held_forces(rail, own.seats, waves, fields.new_slab, fields.old_residual, held[0])
    for wheel in range(wheels):
        copy(coupling.by_all[wheel], held[1 + wheel])
    np.dot(held, own.solve, out.fastener)
    _under_wheels(coupling, waves, shapes, 2.0 / step, out)


@kernel
def _under_wheels(coupling, waves, shapes, to_rate, out):
    """Take what the fasteners hold from the free motion under the wheels."""
    fastener, compliance = out.fastener, out.compliance
    for wheel in range(shapes.shape[0]):
        by_modes, by_all = coupling.by_modes[wheel], coupling.by_all[wheel]
        out.deflection[wheel] = dot(shapes[wheel], waves[0]) - dot(by_all, fastener[0])
        out.rate[wheel] = dot(shapes[wheel], waves[1]) - to_rate * dot(by_modes, fastener[0])
        own = coupling.modal[wheel, wheel] - dot(by_modes, fastener[1 + wheel])
        out.mobility[wheel] = to_rate * own
        for other in range(wheel + 1):
            answer = coupling.total[wheel, other] - dot(by_all, fastener[1 + other])
            compliance[wheel, other] = compliance[other, wheel] = answer


class ClassFields(NamedTuple):
    """Coordinates of one class at the start of a step, and room for those at its end.

    Attributes
    ----------
    old_rail, old_slab, new_rail, new_slab
        As in :mod:`slab_track.oscillators`, (3, 2N) and (3, S n).
    old_residual, new_residual
        Compression of the fasteners by the modes left out and its rate, (2, P).
    fastener
        Receives the fastener forces, (P,), N.
    """

    old_rail: np.ndarray
    old_slab: np.ndarray
    old_residual: np.ndarray
    new_rail: np.ndarray
    new_slab: np.ndarray
    new_residual: np.ndarray
    fastener: np.ndarray


@kernel
def close_class_step(rail, own, fields, coupling, free, shapes, forces, step):
    """Add fastener forces and wheel forces (w,) to a free step, in place."""
    wheels, count = coupling.by_all.shape
    half = rail.folding.to_waves.shape[1]
    fastener, pushed = fields.fastener, np.empty(count)
    halves, given = np.empty((2, half)), np.empty((2, half))
    copy(free.fastener[0], fastener)
    for wheel in range(wheels):
        add_scaled(forces[wheel], free.fastener[1 + wheel], fastener)
    split(fastener, halves)
    _close_rail(rail, halves, given, fields.new_rail, shapes, forces, step)
    seats = own.from_seats
    on_slabs = np.dot(fastener.reshape((-1, seats.shape[0])), seats).ravel()
    add_force(fields.new_slab, 0, own.slab_weight, on_slabs, step)
    apply(own.residual, halves, given)
    join(given, pushed)
    _follow(rail.rate, coupling.residual, forces, pushed, fields.old_residual, fields.new_residual)


@kernel
def _close_rail(rail, halves, sums, new, shapes, forces, step):
    """Add the forces of wheels and fasteners, these in halves, to the rail's waves."""
    count, folding = shapes.shape[1], rail.folding
    wave = np.empty(count)
    apply(folding.to_waves, halves, sums)
    unfold(folding.home, folding.home_sign, sums.ravel(), wave)
    for k in range(count):
        wave[k] = -wave[k]
    for wheel in range(shapes.shape[0]):
        add_scaled(forces[wheel], shapes[wheel], wave)
    add_force(new, 0, rail.drive, wave, step)
    add_force(new, 1, rail.drive, wave, step)


@kernel
def _follow(rate, by_wheels, forces, by_fasteners, old, new):
    """Compression by the modes left out: r = R_w F - R p, its rate by the trapezoidal rule."""
    for i in range(by_fasteners.size):
        new[0, i] = -by_fasteners[i]
    for wheel in range(forces.size):
        add_scaled(forces[wheel], by_wheels[wheel], new[0])
    for i in range(by_fasteners.size):
        new[1, i] = rate * (new[0, i] - old[0, i]) - old[1, i]
