r"""Many scalar oscillators at once: one step of the trapezoidal rule over flat arrays.

Every modal coordinate is a scalar oscillator
:math:`\ddot q + c\dot q + \omega^2 q = g`. With

.. math:: \tilde q = q + h\dot q + \tfrac{h^2}{4}\ddot q,\quad
          \tilde{\dot q} = \dot q + \tfrac h2\ddot q,\quad
          \alpha = 1/(1 + \tfrac h2 c + \tfrac{h^2}{4}\omega^2)

the step is :math:`\ddot q' = \alpha(g' - c\tilde{\dot q} - \omega^2\tilde q)`,
:math:`q' = \tilde q + \tfrac{h^2}{4}\ddot q'`,
:math:`\dot q' = \tilde{\dot q} + \tfrac h2\ddot q'`; it is made in two parts, without the force
and for the force. Coordinates are arrays with rows of displacements, velocities and
accelerations.
"""

import numpy as np

from slab_track.compiled import maker, stream


@stream
def step_waves(old, softening, participation, step, new, deflection, rate):
    """Step the two branches of N undamped waves without any force.

    Parameters
    ----------
    old
        Coordinates, (3, m): displacements, velocities, accelerations. In each row the two
        branches come first, one after the other.
    softening, participation
        alpha omega^2, and displacement per unit coordinate, from the same place on.
    step
        s.
    new
        Receives the coordinates.
    deflection, rate
        Receive the waves' amplitudes and their rates, (N,).
    """
    count = deflection.size
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(count):
        q0 = old[0, k] + step * old[1, k] + quarter * old[2, k]
        q1 = old[0, count + k] + step * old[1, count + k] + quarter * old[2, count + k]
        a0, a1 = -softening[k] * q0, -softening[count + k] * q1
        v0 = old[1, k] + half * (old[2, k] + a0)
        v1 = old[1, count + k] + half * (old[2, count + k] + a1)
        q0 += quarter * a0
        q1 += quarter * a1
        new[0, k], new[1, k], new[2, k] = q0, v0, a0
        new[0, count + k], new[1, count + k], new[2, count + k] = q1, v1, a1
        deflection[k] = participation[k] * q0 + participation[count + k] * q1
        rate[k] = participation[k] * v0 + participation[count + k] * v1


@stream
def step_last(old, softening, participation, step, new, deflection, rate):
    """As :func:`step_waves` for the last of three branches."""
    count = deflection.size
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(count):
        i = 2 * count + k
        q0 = old[0, i] + step * old[1, i] + quarter * old[2, i]
        a0 = -softening[i] * q0
        v0 = old[1, i] + half * (old[2, i] + a0)
        q0 += quarter * a0
        new[0, i], new[1, i], new[2, i] = q0, v0, a0
        deflection[k] = participation[i] * q0
        rate[k] = participation[i] * v0


@stream
def step_damped(old, softening, drag, step, new):
    """Step damped oscillators without any force.

    ``old`` and ``new`` (3, n), ``softening`` alpha omega^2 and ``drag`` alpha c, (n,).
    """
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(softening.size):
        q0 = old[0, k] + step * old[1, k] + quarter * old[2, k]
        v0 = old[1, k] + half * old[2, k]
        a0 = -softening[k] * q0 - drag[k] * v0
        new[0, k], new[1, k], new[2, k] = q0 + quarter * a0, v0 + half * a0, a0


@stream
def add_force(state, branch, drive, force, step):
    """Add the step's answer to modal forces, in place.

    ``state`` (3, m): the force (n,) acts on n coordinates of each row, the ``branch``-th (0, 1, 2)
    of them; ``drive`` (m,) is their acceleration alpha phi per unit force.
    """
    half, quarter = 0.5 * step, 0.25 * step * step
    count = force.size
    first, last = branch * count, (branch + 1) * count
    q, v, a = state[0, first:last], state[1, first:last], state[2, first:last]
    per_force = drive[first:last]
    for k in range(count):
        change = per_force[k] * force[k]
        q[k] += quarter * change
        v[k] += half * change
        a[k] += change


@stream
def take_force(state, branch, drive, force, step):
    """As :func:`add_force` for a force that is taken from the coordinates."""
    half, quarter = 0.5 * step, 0.25 * step * step
    count = force.size
    first, last = branch * count, (branch + 1) * count
    q, v, a = state[0, first:last], state[1, first:last], state[2, first:last]
    per_force = drive[first:last]
    for k in range(count):
        change = per_force[k] * force[k]
        q[k] -= quarter * change
        v[k] -= half * change
        a[k] -= change


@stream
def fold(place, sign, amplitudes, out):
    """Sum waves (N,) that look alike at the fasteners into ``out`` (2h,), both halves.

    ``place`` and ``sign`` (terms, 2h): the waves of each sum and their signs, 0 for none.
    """
    for i in range(out.size):
        out[i] = sign[0, i] * amplitudes[place[0, i]]
    for term in range(1, place.shape[0]):
        for i in range(out.size):
            out[i] += sign[term, i] * amplitudes[place[term, i]]


@stream
def unfold(place, sign, folded, out):
    """Give every wave (N,) the value of its sum, (2h,), times its sign."""
    for k in range(out.size):
        out[k] = sign[k] * folded[place[k]]


@stream
def add_scaled(factor, values, out):
    """Add ``factor`` times an array, (n,), to another one, in place."""
    for k in range(out.size):
        out[k] += factor * values[k]


@stream
def copy(values, out):
    """Copy an array, (n,)."""
    for k in range(out.size):
        out[k] = values[k]


@stream
def dot(a, b):
    """Scalar product of two arrays of equal length."""
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total


@maker
def product(a, b, out):
    """Fill in the product (m, n) of two matrices, (m, k) and (k, n)."""
    np.dot(a, b, out)
