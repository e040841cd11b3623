r"""Sums over the rails' waves: under the wheels and at the fasteners, and steps of the waves.

At the fasteners the shapes of all waves repeat those of P of them (:mod:`slab_track.waves`), and
the line is its own mirror image about the middle of the window. So sums at the fasteners are made
of ``aliases``: sums of waves that look alike there, first those that are even about the middle,
then the odd ones, each part filled up to h values (:mod:`slab_track.halves`).
"""

import math
from typing import NamedTuple

import numpy as np
from rail_native import Array3, IndexMatrix, Indices, Matrix, Vector, fast_kernel, kernel

_SQRT_HALF = math.sqrt(0.5)
_ROWS = 8


class Aliasing(NamedTuple):
    """How N waves, the sums of those that look alike at P fasteners, and these go together.

    Attributes
    ----------
    members, member_sign
        The waves of each sum, and their signs, 0 for none, (terms, 2h).
    alias, alias_sign
        The sum that each wave belongs to, and its sign, 0 if it vanishes at the fasteners, (N,).
    to_fasteners, to_waves
        Parts at the fasteners from the sums, and sums from the parts, by columns, (2, h, h).
    """

    members: IndexMatrix
    member_sign: Matrix
    alias: Indices
    alias_sign: Vector
    to_fasteners: Array3
    to_waves: Array3


@fast_kernel
def sum_aliases(members, sign, amplitudes, sums):
    """Sum waves (N,) that look alike at the fasteners, (2h,)."""
    for i in range(sums.size):
        sums[i] = sign[0, i] * amplitudes[members[0, i]]
    for term in range(1, members.shape[0]):
        for i in range(sums.size):
            sums[i] += sign[term, i] * amplitudes[members[term, i]]


@fast_kernel
def split_parity(values, even, odd):
    """Write the even and the odd part, (h,), of ``values`` (P,) about the window's middle."""
    count = values.size
    for i in range(count // 2, even.size):
        even[i] = odd[i] = 0.0
    for i in range(count // 2):
        even[i] = _SQRT_HALF * (values[i] + values[count - 1 - i])
        odd[i] = _SQRT_HALF * (values[i] - values[count - 1 - i])
    if count % 2 == 1:
        even[count // 2] = values[count // 2]


@fast_kernel
def join_parity(parts, out):
    """Write the values (P,) whose even and odd parts are given, (2, h)."""
    count = out.size
    for i in range(count // 2):
        out[i] = _SQRT_HALF * (parts[0, i] + parts[1, i])
        out[count - 1 - i] = _SQRT_HALF * (parts[0, i] - parts[1, i])
    if count % 2 == 1:
        out[count // 2] = parts[0, count // 2]


@kernel
def shapes_at_wheels(wave_number, positions, shapes):
    """Write the waves' shapes at every wheel, (wheels, N), by recurrence in k.

    The first wave number is 0 on a ring, which has cosines and sines in turn. Eight waves ahead
    the angle has grown by a constant, so f(k+8) = 2 cos f(k) - f(k-8).
    """
    ring = wave_number[0] == 0.0
    first = 1 if ring else 0
    start = min(2 * _ROWS + first, wave_number.size)
    for wheel in range(positions.size):
        row, angle = shapes[wheel], wave_number[first] * positions[wheel]
        cosine, sine = math.cos(angle), math.sin(angle)
        c, s, twice = cosine, sine, 0.0
        if ring:
            row[0] = 1.0
        for k in range(first, start):
            is_cosine = ring and k % 2 == 1
            row[k] = c if is_cosine else s
            if k - first == _ROWS - 1:
                twice = 2.0 * c
            if not is_cosine:
                c, s = c * cosine - s * sine, s * cosine + c * sine
        _continue_recurrence(twice, np.uint64(start), row)


@fast_kernel
def _continue_recurrence(twice, start, row):
    """Write the rest of a row; unsigned indices are never negative, so vectors can be used."""
    for k in range(start, np.uint64(row.size)):
        row[k] = twice * row[k - np.uint64(_ROWS)] - row[k - np.uint64(2 * _ROWS)]


# The trapezoidal rule for q'' + c q' + omega^2 q = g, in two parts (docs/theory.md, section 5):
# without the force, and for the force, g' = g.


@fast_kernel
def step_waves(old, softening, participation, step, new, deflection, rate):
    """Step the two branches of N undamped waves without any force.

    Parameters
    ----------
    old, new
        Displacement, velocity, acceleration at the start, and at the end, (3, 2 or 3, N).
    softening, participation
        alpha omega^2, and deflection per unit coordinate, (2 or 3, N).
    step
        h, s.
    deflection, rate
        Written: amplitudes of the waves and their rates, (N,).
    """
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(deflection.size):
        q0 = old[0, 0, k] + step * old[1, 0, k] + quarter * old[2, 0, k]
        q1 = old[0, 1, k] + step * old[1, 1, k] + quarter * old[2, 1, k]
        a0, a1 = -softening[0, k] * q0, -softening[1, k] * q1
        v0 = old[1, 0, k] + half * (old[2, 0, k] + a0)
        v1 = old[1, 1, k] + half * (old[2, 1, k] + a1)
        q0 += quarter * a0
        q1 += quarter * a1
        new[0, 0, k], new[1, 0, k], new[2, 0, k] = q0, v0, a0
        new[0, 1, k], new[1, 1, k], new[2, 1, k] = q1, v1, a1
        deflection[k] = participation[0, k] * q0 + participation[1, k] * q1
        rate[k] = participation[0, k] * v0 + participation[1, k] * v1


@fast_kernel
def step_torsion(old, softening, participation, step, new, roll, rate):
    """As :func:`step_waves` for the third branch of N waves."""
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(roll.size):
        q0 = old[0, 2, k] + step * old[1, 2, k] + quarter * old[2, 2, k]
        a0 = -softening[2, k] * q0
        v0 = old[1, 2, k] + half * (old[2, 2, k] + a0)
        q0 += quarter * a0
        new[0, 2, k], new[1, 2, k], new[2, 2, k] = q0, v0, a0
        roll[k] = participation[2, k] * q0
        rate[k] = participation[2, k] * v0


@fast_kernel
def step_damped(old, softening, drag, step, new):
    """Step damped oscillators without any force, (3, slabs, n).

    ``softening`` alpha omega^2 and ``drag`` alpha c, (n,).
    """
    half, quarter = 0.5 * step, 0.25 * step * step
    for slab in range(old.shape[1]):
        for k in range(softening.size):
            q0 = old[0, slab, k] + step * old[1, slab, k] + quarter * old[2, slab, k]
            v0 = old[1, slab, k] + half * old[2, slab, k]
            a0 = -softening[k] * q0 - drag[k] * v0
            new[0, slab, k], new[1, slab, k] = q0 + quarter * a0, v0 + half * a0
            new[2, slab, k] = a0


@fast_kernel
def add_force(state, branch, drive, force, step):
    """Add what a modal force (n,) does within a step.

    ``state`` (3, branches, n), ``drive`` (branches, n): alpha phi, acceleration per unit force.
    """
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(force.size):
        change = drive[branch, k] * force[k]
        state[0, branch, k] += quarter * change
        state[1, branch, k] += half * change
        state[2, branch, k] += change
