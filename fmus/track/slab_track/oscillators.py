r"""Many scalar oscillators at once: one step of the trapezoidal rule over flat arrays.

Every modal coordinate is a scalar oscillator
:math:`\ddot q + c\dot q + \omega^2 q = g`. With

.. math:: \tilde q = q + h\dot q + \tfrac{h^2}{4}\ddot q,\quad
          \tilde{\dot q} = \dot q + \tfrac h2\ddot q,\quad
          \alpha = 1/(1 + \tfrac h2 c + \tfrac{h^2}{4}\omega^2)

the step is :math:`\ddot q' = \alpha(g' - c\tilde{\dot q} - \omega^2\tilde q)`,
:math:`q' = \tilde q + \tfrac{h^2}{4}\ddot q'`,
:math:`\dot q' = \tilde{\dot q} + \tfrac h2\ddot q'`; it is made in two parts, without the force
and for the force. Loops are split so that the compiler sees few arrays at a time: then it
uses vector instructions. Results may replace the arrays that they are made from.
"""

import numba

FAST = {"contract", "reassoc", "nsz"}
"""Fused and reordered sums: rounding errors only."""


@numba.njit(cache=True, error_model="numpy", fastmath=FAST)
def step_undamped(old, softening, step, new):
    """Step oscillators without damping and without any force.

    ``old`` and ``new`` are displacement, velocity and acceleration, shape (3, n);
    ``softening`` is alpha omega^2, shape (n,).
    """
    q, v, a = old[0], old[1], old[2]
    q_new, v_new, a_new = new[0], new[1], new[2]
    half, quarter = 0.5 * step, 0.25 * step * step
    for i in range(q.size):
        q_new[i] = q[i] + step * v[i] + quarter * a[i]
    for i in range(q.size):
        v_new[i] = v[i] + half * (a[i] - softening[i] * q_new[i])
    for i in range(q.size):
        a_new[i] = -softening[i] * q_new[i]
    for i in range(q.size):
        q_new[i] += quarter * a_new[i]


@numba.njit(cache=True, error_model="numpy", fastmath=FAST)
def step_damped(old, softening, drag, step, new):
    """As :func:`step_undamped`, with ``drag`` alpha c, shape (n,)."""
    q, v, a = old[0], old[1], old[2]
    q_new, v_new, a_new = new[0], new[1], new[2]
    half, quarter = 0.5 * step, 0.25 * step * step
    for i in range(q.size):
        q_new[i] = q[i] + step * v[i] + quarter * a[i]
    for i in range(q.size):
        v_new[i] = v[i] + half * a[i]
    for i in range(q.size):
        a_new[i] = -softening[i] * q_new[i] - drag[i] * v_new[i]
    for i in range(q.size):
        q_new[i] += quarter * a_new[i]
    for i in range(q.size):
        v_new[i] += half * a_new[i]


@numba.njit(cache=True, error_model="numpy", fastmath=FAST)
def add_force(state, first, drive, force, step):
    """Add the step's answer to modal forces, in place.

    ``state`` (3, n) from column ``first`` on; ``drive`` is the acceleration alpha phi
    per unit ``force``, both (m,).
    """
    last = first + force.size
    q, v, a = state[0, first:last], state[1, first:last], state[2, first:last]
    half, quarter = 0.5 * step, 0.25 * step * step
    for i in range(force.size):
        q[i] += quarter * (drive[i] * force[i])
    for i in range(force.size):
        v[i] += half * (drive[i] * force[i])
    for i in range(force.size):
        a[i] += drive[i] * force[i]


@numba.njit(cache=True, error_model="numpy", fastmath=FAST)
def add_acceleration(state, acceleration, step):
    """Add the step's answer to forces that cause ``acceleration`` (n,), in place."""
    q, v, a = state[0], state[1], state[2]
    half, quarter = 0.5 * step, 0.25 * step * step
    for i in range(acceleration.size):
        q[i] += quarter * acceleration[i]
    for i in range(acceleration.size):
        v[i] += half * acceleration[i]
    for i in range(acceleration.size):
        a[i] += acceleration[i]


@numba.njit(cache=True, error_model="numpy", fastmath=FAST)
def wave_amplitudes(participation, coordinates, out):
    """Fill ``out`` (N,) with the amplitudes of the waves of two branches, both (2, N) flat."""
    count = out.size
    first, second = participation[:count], participation[count : 2 * count]
    lower, upper = coordinates[:count], coordinates[count : 2 * count]
    for k in range(count):
        out[k] = first[k] * lower[k] + second[k] * upper[k]


@numba.njit(cache=True)
def fold(index, sign, amplitudes, out):
    """Sum waves (N,) that look alike at the fasteners into ``out`` (P,)."""
    out[:] = 0.0
    for k in range(amplitudes.size):
        out[index[k]] += sign[k] * amplitudes[k]


@numba.njit(cache=True)
def unfold(index, sign, folded, out):
    """Transpose of :func:`fold`: give every wave (N,) the value of its class (P,)."""
    for k in range(out.size):
        out[k] = sign[k] * folded[index[k]]
