r"""Vertical motion of rails and slabs over an internal step, both symmetry classes together.

The trapezoidal rule for every modal coordinate, with the fasteners' law p = k e + c de/dt and the
wheel forces at the end of the step (docs/theory.md, section 5). With the compression z by the
modes in the free step, that is without any new force,

.. math:: p' = S\,(z - d/\nu + A_w F'),\quad e' = (p' + d)/\nu,\quad \nu = k + \tfrac{2c}{h},
          \quad d = c(\tfrac2h e + \dot e)

S is a constant matrix per class and step size; it falls into an even and an odd part about the
window's middle. Under the wheels remains the compliance
:math:`C = A_{ww} - A_w^T S A_w`. Arrays have the symmetry class (symmetric, antisymmetric) first
and the parity (even, odd) next.
"""

import math
from typing import NamedTuple

from rail_native import Array3, Array4, Matrix, Vector, fast_kernel, kernel

from slab_track.kernels.arrays import add_scaled, copy, multiply, multiply_rows, multiply_two
from slab_track.kernels.distance import between, to_fasteners
from slab_track.kernels.waves import (
    Aliasing,
    add_force,
    join_parity,
    split_parity,
    step_damped,
    step_waves,
    sum_aliases,
)

_SQRT_HALF = math.sqrt(0.5)


class VerticalConstants(NamedTuple):
    """Constants of the vertical motion for one internal step size h.

    Attributes
    ----------
    rail_softening, rail_participation, rail_drive
        alpha omega^2, deflection per unit coordinate phi, and alpha phi of both branches, (2, N).
    wave_number
        Of the waves, (N,), rad/m.
    aliasing
        Sums of waves at the fasteners.
    modal_kernel, whole_kernel
        Tables of the rail's response to a force by the modes, and by them and the residual
        (see :mod:`slab_track.kernel`).
    fastener_damping, fastener_flexibility
        c, N.s/m, and 1/nu, m/N, of each fastener, (P,).
    slab_softening, slab_drag, slab_weight
        alpha omega^2, alpha c and alpha of the modes of a slab, (2, n); 0 where a class has less.
    seats, from_seats
        Shapes at the seats, (2, n, C), and transposed, (2, C, n).
    solve
        S, fastener force per unit compression within a step, (2, 2, h, h), N/m.
    spacing
        Distance of the fasteners, m.
    ring
        True if the track closes on itself.
    """

    rail_softening: Matrix
    rail_participation: Matrix
    rail_drive: Matrix
    wave_number: Vector
    aliasing: Aliasing
    modal_kernel: Matrix
    whole_kernel: Matrix
    fastener_damping: Vector
    fastener_flexibility: Vector
    slab_softening: Matrix
    slab_drag: Matrix
    slab_weight: Matrix
    seats: Array3
    from_seats: Array3
    solve: Array4
    spacing: float
    ring: bool


class VerticalFields(NamedTuple):
    """Vertical coordinates of the track, symmetry class first.

    Attributes
    ----------
    rail
        (2, 3, 2, N): class; displacement, velocity, acceleration; branch; wave.
    slab
        (2, 3, S, n): class; displacement, velocity, acceleration; slab; mode.
    compression
        Of the fasteners, modes and residual together, m, and its rate, m/s, (2, 2, P).
    fastener_force
        (2, P), N, compression positive.
    """

    rail: Array4
    slab: Array4
    compression: Array3
    fastener_force: Matrix


class VerticalWork(NamedTuple):
    """What a step computes on its way.

    Attributes
    ----------
    by_modes
        Deflection at the fasteners per unit force of each wheel, by the modes, (2, w, h), m/N.
    compliance_to_fasteners
        The same, modes and residual, (2, w, h), m/N.
    own_by_modes, between_wheels
        Deflection under a wheel per unit force of its own by the modes, (w,), and under each
        wheel per unit force under each, (w, w), m/N; without fasteners.
    compression
        z - d/nu, (2, 2, h), m.
    fastener
        Fastener forces without wheel forces, (2, 2, h), N.
    fastener_by_wheel
        S A_w: fastener forces per unit force of each wheel, (2, 2, w, h).
    deflection, rate
        Of the rail under the wheels without wheel forces, (2, w), m and m/s.
    compliance, mobility
        Deflection under the wheels per unit wheel force, (2, w, w), and its rate under a wheel per
        unit force of its own, (2, w).
    amplitude, amplitude_rate, wave_force
        Of waves, (N,).
    sums, parts
        Sums of waves that look alike at the fasteners, (2h,), and parts at the fasteners, (2, h).
    at_fasteners, at_seats, slab_force
        (P,), (S, C) and (S, n).
    """

    by_modes: Array3
    compliance_to_fasteners: Array3
    own_by_modes: Vector
    between_wheels: Matrix
    compression: Array3
    fastener: Array3
    fastener_by_wheel: Array4
    deflection: Matrix
    rate: Matrix
    compliance: Array3
    mobility: Matrix
    amplitude: Vector
    amplitude_rate: Vector
    wave_force: Vector
    sums: Vector
    parts: Matrix
    at_fasteners: Vector
    at_seats: Matrix
    slab_force: Matrix


@kernel
def couple_wheels(constants, positions, work):
    """Compute how wheels at ``positions`` (w,), m in the window, move rails and fasteners."""
    modal, whole, ring = constants.modal_kernel, constants.whole_kernel, constants.ring
    spacing, at_fasteners = constants.spacing, work.at_fasteners
    by_modes, by_all = work.by_modes, work.compliance_to_fasteners
    own, between_wheels = work.own_by_modes, work.between_wheels
    for wheel in range(positions.size):
        here = positions[wheel] / spacing
        to_fasteners(modal, here, at_fasteners)
        split_parity(at_fasteners, by_modes[0, wheel], by_modes[1, wheel])
        to_fasteners(whole, here, at_fasteners)
        split_parity(at_fasteners, by_all[0, wheel], by_all[1, wheel])
        own[wheel] = between(modal, here, here, ring)
        for other in range(wheel + 1):
            response = between(whole, here, positions[other] / spacing, ring)
            between_wheels[wheel, other] = between_wheels[other, wheel] = response


@kernel
def free_step(constants, old, new, shapes, step, work):
    """Step rails, slabs and fasteners without new wheel forces.

    ``old`` and ``new`` are :class:`VerticalFields`, ``shapes`` (w, N) those of the waves under the
    wheels. Afterwards ``new`` has rails and slabs free of new forces, and ``work`` what fasteners
    and rails do under the wheels without wheel forces and per unit of them.
    """
    softening, participation = constants.rail_softening, constants.rail_participation
    slab_softening, slab_drag = constants.slab_softening, constants.slab_drag
    solve, amplitude, rate = constants.solve, work.amplitude, work.amplitude_rate
    rail, new_rail, slab, new_slab = old.rail, new.rail, old.slab, new.slab
    compression, fastener = work.compression, work.fastener
    by_wheel, by_all = work.fastener_by_wheel, work.compliance_to_fasteners
    for symmetry in range(2):
        step_waves(
            rail[symmetry], softening, participation, step, new_rail[symmetry], amplitude, rate
        )
        step_damped(
            slab[symmetry], slab_softening[symmetry], slab_drag[symmetry], step, new_slab[symmetry]
        )
        _compress_fasteners(
            constants, symmetry, new_slab[symmetry, 0], old.compression[symmetry], step, work
        )
        for parity in range(2):
            matrix = solve[symmetry, parity]
            multiply(matrix, compression[symmetry, parity], fastener[symmetry, parity])
            forces = by_wheel[symmetry, parity]
            for wheel in range(0, shapes.shape[0] - 1, 2):
                multiply_two(
                    matrix,
                    by_all[parity, wheel],
                    by_all[parity, wheel + 1],
                    forces[wheel],
                    forces[wheel + 1],
                )
            if shapes.shape[0] % 2 == 1:
                last = shapes.shape[0] - 1
                multiply(matrix, by_all[parity, last], forces[last])
        for wheel in range(shapes.shape[0]):
            _move_under_wheel(
                symmetry, wheel, shapes[wheel], step, amplitude, rate, work.by_modes, by_all,
                work.own_by_modes, work.between_wheels, fastener[symmetry], by_wheel[symmetry],
                work.deflection, work.rate, work.mobility, work.compliance,
            )  # fmt: skip


@kernel
def _compress_fasteners(constants, symmetry, slab, old_compression, step, work):
    """Compute z - d/nu of all fasteners after the free step, in parts."""
    aliasing, sums, parts = constants.aliasing, work.sums, work.parts
    at_seats, at_fasteners, compression = work.at_seats, work.at_fasteners, work.compression
    sum_aliases(aliasing.members, aliasing.member_sign, work.amplitude, sums)
    half, to_fasteners = parts.shape[1], aliasing.to_fasteners
    for parity in range(2):
        of = sums[parity * half : (parity + 1) * half]
        multiply(to_fasteners[parity], of, compression[symmetry, parity])
    multiply_rows(slab, constants.seats[symmetry], at_seats)
    _add_viscous(
        constants.fastener_damping, constants.fastener_flexibility, at_seats, old_compression,
        2.0 / step, at_fasteners,
    )  # fmt: skip
    split_parity(at_fasteners, parts[0], parts[1])
    for parity in range(2):
        add_scaled(-1.0, parts[parity], compression[symmetry, parity])


@fast_kernel
def _add_viscous(damping, flexibility, at_seats, compression, to_rate, out):
    """Write the displacement of the slabs under the fasteners plus d/nu, (P,)."""
    for i in range(out.size):
        d = damping[i] * (to_rate * compression[0, i] + compression[1, i])
        out[i] = at_seats.flat[i] + flexibility[i] * d


@fast_kernel
def _move_under_wheel(
    symmetry, wheel, shape, step, amplitude, amplitude_rate, by_modes, by_all, own_by_modes,
    between_wheels, fastener, by_wheel, deflection, rate, mobility, compliance,
):  # fmt: skip
    """Compute the rail's motion under a wheel: free motion less what the fasteners do."""
    moved = speed = 0.0
    for k in range(shape.size):
        moved += shape[k] * amplitude[k]
        speed += shape[k] * amplitude_rate[k]
    held = slowed = own = 0.0
    for parity in range(2):
        for i in range(fastener.shape[1]):
            held += by_all[parity, wheel, i] * fastener[parity, i]
            slowed += by_modes[parity, wheel, i] * fastener[parity, i]
            own += by_modes[parity, wheel, i] * by_wheel[parity, wheel, i]
    deflection[symmetry, wheel] = moved - held
    rate[symmetry, wheel] = speed - 2.0 / step * slowed
    mobility[symmetry, wheel] = 2.0 / step * (own_by_modes[wheel] - own)
    for other in range(wheel + 1):
        response = between_wheels[wheel, other]
        for parity in range(2):
            for i in range(fastener.shape[1]):
                response -= by_all[parity, wheel, i] * by_wheel[parity, other, i]
        compliance[symmetry, wheel, other] = compliance[symmetry, other, wheel] = response


@kernel
def close_step(constants, old, new, shapes, rail_force, step, work):
    """Add what wheel forces and fasteners do within the step to ``new``.

    ``rail_force`` (w, 2, 3): lateral, vertical force and roll moment on each rail's axis.
    """
    fastener, by_wheel, parts = work.fastener, work.fastener_by_wheel, work.parts
    drive, rail, slab = constants.rail_drive, new.rail, new.slab
    old_compression, compression, forces = old.compression, new.compression, new.fastener_force
    for symmetry in range(2):
        sign = 1.0 if symmetry == 0 else -1.0
        for parity in range(2):
            copy(fastener[symmetry, parity], parts[parity])
        for wheel in range(shapes.shape[0]):
            force = _class_force(rail_force, wheel, sign)
            for parity in range(2):
                add_scaled(force, by_wheel[symmetry, parity, wheel], parts[parity])
        join_parity(parts, forces[symmetry])
        _load_waves(constants.aliasing, shapes, rail_force, sign, parts, work.sums, work.wave_force)
        for branch in range(2):
            add_force(rail[symmetry], branch, drive, work.wave_force, step)
        multiply_seats(
            forces[symmetry], constants.from_seats[symmetry], work.at_seats, work.slab_force
        )
        _push_slabs(constants.slab_weight[symmetry], work.slab_force, step, slab[symmetry])
        _settle_fasteners(
            constants.fastener_damping, constants.fastener_flexibility, 2.0 / step,
            forces[symmetry], old_compression[symmetry], compression[symmetry],
        )  # fmt: skip


@kernel
def _class_force(rail_force, wheel, sign):
    """Return a wheel's vertical force on the rails in a symmetry class, N."""
    return _SQRT_HALF * (rail_force[wheel, 1, 1] + sign * rail_force[wheel, 0, 1])


@kernel
def _load_waves(aliasing, shapes, rail_force, sign, parts, sums, wave_force):
    """Compute the waves' forces (N,) from wheels and fasteners, these in ``parts``."""
    half, to_waves = parts.shape[1], aliasing.to_waves
    for parity in range(2):
        multiply(to_waves[parity], parts[parity], sums[parity * half : (parity + 1) * half])
    _unfold(aliasing.alias, aliasing.alias_sign, sums, wave_force)
    for wheel in range(shapes.shape[0]):
        add_scaled(_class_force(rail_force, wheel, sign), shapes[wheel], wave_force)


@fast_kernel
def _unfold(alias, alias_sign, sums, force):
    """Write the waves' forces (N,) that fasteners exert, minus the value of their sums, (2h,)."""
    for k in range(force.size):
        force[k] = -alias_sign[k] * sums[alias[k]]


@kernel
def multiply_seats(force, from_seats, at_seats, slab_force):
    """Write the modal forces of the slabs (S, n) from those of the fasteners (P,)."""
    copy(force, at_seats)
    multiply_rows(at_seats, from_seats, slab_force)


@fast_kernel
def _push_slabs(weight, force, step, slab):
    half, quarter = 0.5 * step, 0.25 * step * step
    for s in range(force.shape[0]):
        for k in range(force.shape[1]):
            change = weight[k] * force[s, k]
            slab[0, s, k] += quarter * change
            slab[1, s, k] += half * change
            slab[2, s, k] += change


@fast_kernel
def _settle_fasteners(damping, flexibility, to_rate, force, old, new):
    """Compression e = (p + d)/nu of the fasteners, its rate by the trapezoidal rule, (2, P)."""
    for i in range(force.size):
        before = to_rate * old[0, i] + old[1, i]
        new[0, i] = flexibility[i] * (force[i] + damping[i] * before)
        new[1, i] = to_rate * new[0, i] - before
