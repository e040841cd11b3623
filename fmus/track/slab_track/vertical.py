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
inertia: at fasteners and wheels they add their static compliance R. The compression e of a
fastener, modes and residual together, is linear in the coordinates and so obeys the same rule,
:math:`\dot e' = \tfrac2h(e' - e) - \dot e`. Its law :math:`p = ke + c\dot e` becomes

.. math:: p' = \nu e' - d,\quad \nu = k + \tfrac{2c}{h},\quad d = c(\tfrac2h e + \dot e)

With the compression z by the modes in the free step (g' = 0), :math:`e' = z + A_w F' - A p'`, and
the fasteners obey a constant linear system, inverted once per step size:

.. math:: p' = S\,(z - d/\nu + A_w F'),\quad S = (\nu^{-1} + A)^{-1},\quad
          A = \tfrac{h^2}{4}Y + R

with Y the admittance at the fasteners and :math:`A_w` the compliance between fasteners and wheels.
S falls into an even and an odd half (:mod:`slab_track.halves`). What remains per wheel is one
scalar equation of Hertz's law with the compliance

.. math:: C = A_{ww} - A_w^T S A_w.
"""

from typing import NamedTuple

import numpy as np
from rail_quantities.uncounted import shaped

from slab_track.assembly import LinearTrack
from slab_track.compiled import kernel, stream
from slab_track.folding import Folding, make_folding
from slab_track.halves import apply, join, split, split_matrix
from slab_track.kernel import between, kernel_table, to_fasteners
from slab_track.oscillators import (
    add_force,
    add_scaled,
    copy,
    fold,
    product,
    step_damped,
    step_waves,
    take_force,
    unfold,
)


class RailOperator(NamedTuple):
    """Constants of the rails and fasteners for one internal step size h, of both classes.

    Attributes
    ----------
    softening, participation, drive
        alpha omega^2, deflection per unit coordinate phi, and alpha phi of both branches,
        one after the other, shape (2N,).
    wave_number
        Of the waves, shape (N,).
    folding
        Sums of waves that look alike at the fasteners.
    modal_kernel, whole_kernel
        Tables of h^2/4 beta, and of it and the residual (see :mod:`slab_track.kernel`).
    damping
        c of each fastener, N.s/m, (P,).
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
    modal_kernel: np.ndarray
    whole_kernel: np.ndarray
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
        S, symmetric, fastener force per unit compression within a step, in halves, (2, h, h), N/m.
    """

    slab_softening: np.ndarray
    slab_drag: np.ndarray
    slab_weight: np.ndarray
    seats: np.ndarray
    from_seats: np.ndarray
    solve: np.ndarray


def rail_operator(track: LinearTrack, step: float) -> RailOperator:
    """Return the constants that both classes share, for an internal step in s."""
    quarter, count, ring = 0.25 * step**2, track.fastener_count, track.ring
    weight = 1.0 / (1.0 + quarter * track.rail.omega_squared)
    beta = np.sum(track.participation**2 * weight, axis=0)
    dampers = track.damping + track.end_damping
    modal = kernel_table(quarter * beta, count, ring=ring)
    residual = kernel_table(track.residual_flexibility, count, ring=ring)
    return RailOperator(
        softening=(weight * track.rail.omega_squared).ravel(),
        participation=track.participation.ravel(),
        drive=(weight * track.participation).ravel(),
        wave_number=track.rail.wave_number,
        folding=make_folding(track.fold_index, track.fold_sign, track.fastener_sines),
        modal_kernel=modal,
        whole_kernel=modal + residual,
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
        solve=split_matrix(0.5 * (solve + solve.T)),
    )


class WheelCoupling(NamedTuple):
    """How the wheels, the fasteners and the wheels among themselves are coupled by the rails.

    Attributes
    ----------
    by_modes
        Deflection at the fasteners per unit wheel force, by the modes, in halves, (2, w, h), m/N.
    held
        Row 1 + w: the same by all modes. Row 0 has room for a class's compression without wheel
        forces. In halves, (2, 1 + w, h), m/N and m.
    modal
        Deflection under a wheel per unit force of its own, by the modes, (w,), m/N.
    total
        Deflection under the wheels per unit force under another one, by all modes, (w, w), m/N.
    """

    by_modes: np.ndarray
    held: np.ndarray
    modal: np.ndarray
    total: np.ndarray

    @classmethod
    def empty(cls, wheels: int, half: int) -> "WheelCoupling":
        """Return room for as many wheels, and halves of ``half`` fasteners."""
        return cls(
            by_modes=np.empty((2, wheels, half)),
            held=np.empty((2, 1 + wheels, half)),
            modal=np.empty(wheels),
            total=np.empty((wheels, wheels)),
        )


@kernel
def wheel_coupling(rail, places, at_fasteners, out):
    """Fill a :class:`WheelCoupling` for wheels at ``places`` (w,), m in the window.

    ``at_fasteners`` (P,) is room.
    """
    modal, total, ring = out.modal, out.total, rail.ring
    for wheel in range(places.size):
        here = places[wheel] / rail.spacing
        to_fasteners(rail.modal_kernel, here, at_fasteners)
        split(at_fasteners, out.by_modes[0, wheel], out.by_modes[1, wheel])
        to_fasteners(rail.whole_kernel, here, at_fasteners)
        split(at_fasteners, out.held[0, 1 + wheel], out.held[1, 1 + wheel])
        modal[wheel] = between(rail.modal_kernel, here, here, ring)
        for other in range(wheel + 1):
            answer = between(rail.whole_kernel, here, places[other] / rail.spacing, ring)
            total[wheel, other] = total[other, wheel] = answer


class FreeStep(NamedTuple):
    """A step of one symmetry class without wheel forces, and what a wheel force adds.

    Attributes
    ----------
    fastener
        Fastener forces without wheel forces, and per unit force of each wheel, in halves,
        (2, 1 + w, h), N.
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
    def empty(cls, wheels: int, half: int) -> "FreeStep":
        """Return room for as many wheels, and halves of ``half`` fasteners."""
        return cls(
            fastener=np.empty((2, 1 + wheels, half)),
            deflection=np.empty(wheels),
            rate=np.empty(wheels),
            compliance=np.empty((wheels, wheels)),
            mobility=np.empty(wheels),
        )


class ClassFields(NamedTuple):
    """Coordinates of one class at the start of a step, and room for those at its end.

    Attributes
    ----------
    old_rail, old_slab, new_rail, new_slab
        As in :mod:`slab_track.oscillators`, (3, 2N) and (3, S n).
    old_compression, new_compression
        Of the fasteners, and its rate, (2, P).
    fastener
        Receives the fastener forces, (P,), N.
    """

    old_rail: np.ndarray
    old_slab: np.ndarray
    old_compression: np.ndarray
    new_rail: np.ndarray
    new_slab: np.ndarray
    new_compression: np.ndarray
    fastener: np.ndarray


@kernel
def free_class_step(rail, own, fields, coupling, shapes, step, room, out):
    """Step one symmetry class with fasteners but without wheel forces.

    ``rail`` and ``own`` are the operators, ``fields`` a :class:`ClassFields`, ``shapes`` (w, N)
    those of the waves under the wheels, ``room`` a :class:`slab_track.room.Room`. Fills the
    :class:`FreeStep` ``out``.
    """
    waves, held = room.waves, coupling.held
    step_waves(
        fields.old_rail, rail.softening, rail.participation, step, fields.new_rail,
        waves[0], waves[1],
    )  # fmt: skip
    step_damped(fields.old_slab, own.slab_softening, own.slab_drag, step, fields.new_slab)
    _compress(rail, own.seats, waves[0], fields, room, held[0, 0], held[1, 0])
    for half in range(2):
        product(held[half], own.solve[half], out.fastener[half])
    for wheel in range(shapes.shape[0]):
        _under_wheel(
            wheel, coupling.by_modes, held, coupling.modal, coupling.total, waves, shapes[wheel],
            2.0 / step, out.fastener, out.deflection, out.rate, out.mobility, out.compliance,
        )  # fmt: skip


@kernel
def _compress(rail, seats, waves, fields, room, even, odd):
    """Fill the halves (h,) of z - d/nu, for ``waves`` (N,) and slabs after the free step."""
    folding, fastener, sums, less = rail.folding, fields.fastener, room.taken[0], room.halves
    fold(folding.place, folding.sign, waves, sums)
    apply(folding.to_fasteners[0], sums[: even.size], even)
    apply(folding.to_fasteners[1], sums[even.size :], odd)
    modes, count = seats.shape
    slabs, under = fields.new_slab.shape[1] // modes, room.fasteners
    product(shaped(fields.new_slab, 0, (slabs, modes)), seats, shaped(under, 0, (slabs, count)))
    old = fields.old_compression
    _retain(under, rail.flexibility, rail.damping, rail.rate, old[0], old[1], fastener)
    split(fastener, less[0], less[1])
    add_scaled(-1.0, less[0], even)
    add_scaled(-1.0, less[1], odd)


@stream
def _retain(under, flexibility, damping, to_rate, compression, rate, out):
    """Displacement of the slabs under the fasteners and d/nu, (P,)."""
    for i in range(out.size):
        viscous = damping[i] * (to_rate * compression[i] + rate[i])
        out[i] = under[i] + flexibility[i] * viscous


@stream
def _under_wheel(
    wheel, by_modes, held, modal, total, waves, shape, to_rate, fastener, deflection, rate,
    mobility, compliance,
):  # fmt: skip
    """Motion under a wheel without its force, and per unit force: free motion less fasteners'."""
    moved = speed = own = 0.0
    for k in range(shape.size):
        moved += shape[k] * waves[0, k]
        speed += shape[k] * waves[1, k]
    less = slower = 0.0
    for half in range(2):
        for i in range(held.shape[2]):
            less += held[half, 1 + wheel, i] * fastener[half, 0, i]
            slower += by_modes[half, wheel, i] * fastener[half, 0, i]
            own += by_modes[half, wheel, i] * fastener[half, 1 + wheel, i]
    deflection[wheel], rate[wheel] = moved - less, speed - to_rate * slower
    mobility[wheel] = to_rate * (modal[wheel] - own)
    for other in range(wheel + 1):
        answer = total[wheel, other]
        for half in range(2):
            for i in range(held.shape[2]):
                answer -= held[half, 1 + wheel, i] * fastener[half, 1 + other, i]
        compliance[wheel, other] = compliance[other, wheel] = answer


@kernel
def close_class_step(rail, own, fields, free, shapes, forces, step, room):
    """Add fastener forces and wheel forces (w,) to a free step, in place."""
    seats, fastener, halves = own.from_seats, fields.fastener, room.halves
    for side in range(2):
        copy(free.fastener[side, 0], halves[side])
        for wheel in range(forces.size):
            add_scaled(forces[wheel], free.fastener[side, 1 + wheel], halves[side])
    join(halves, fastener)
    _close_rail(rail, halves, room, fields.new_rail, shapes, forces, step)
    count, modes = seats.shape
    slabs = fastener.size // count
    on_slabs = shaped(room.slabs, 0, (slabs, modes))
    product(shaped(fastener, 0, (slabs, count)), seats, on_slabs)
    add_force(fields.new_slab, 0, own.slab_weight, room.slabs[: slabs * modes], step)
    old, new = fields.old_compression, fields.new_compression
    _follow(rail.rate, rail.flexibility, rail.damping, fastener, old[0], old[1], new[0], new[1])


@kernel
def _close_rail(rail, halves, room, new, shapes, forces, step):
    """Add the forces of wheels and fasteners, these in halves, to the rail's waves."""
    folding, wave, sums, half = rail.folding, room.waves[0], room.taken[0], halves.shape[1]
    for side in range(2):
        apply(folding.to_waves[side], halves[side], sums[side * half : (side + 1) * half])
    unfold(folding.home, folding.home_sign, sums, wave)
    for wheel in range(shapes.shape[0]):
        add_scaled(-forces[wheel], shapes[wheel], wave)
    take_force(new, 0, rail.drive, wave, step)
    take_force(new, 1, rail.drive, wave, step)


@stream
def _follow(to_rate, flexibility, damping, force, old, old_rate, new, new_rate):
    """Compression e = (p + d)/nu of the fasteners, its rate by the trapezoidal rule."""
    for i in range(force.size):
        before = to_rate * old[i] + old_rate[i]
        new[i] = flexibility[i] * (force[i] + damping[i] * before)
        new_rate[i] = to_rate * new[i] - before
