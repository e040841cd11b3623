r"""Many scalar oscillators at once: one step of the trapezoidal rule over flat arrays.

Every modal coordinate is a scalar oscillator
:math:`\ddot q + c\dot q + \omega^2 q = g`. With

.. math:: \tilde q = q + h\dot q + \tfrac{h^2}{4}\ddot q,\quad
          \tilde{\dot q} = \dot q + \tfrac h2\ddot q,\quad
          \alpha = 1/(1 + \tfrac h2 c + \tfrac{h^2}{4}\omega^2)

the step is :math:`\ddot q' = \alpha(g' - c\tilde{\dot q} - \omega^2\tilde q)`,
:math:`q' = \tilde q + \tfrac{h^2}{4}\ddot q'`,
:math:`\dot q' = \tilde{\dot q} + \tfrac h2\ddot q'`; it is made in two parts, without the force
and for the force. Coordinates are flat: all displacements, then all velocities, then all
accelerations.
"""

from slab_track.compiled import kernel, stream


@stream
def step_waves(old, softening, participation, step, new, deflection, rate):
    """Step the two branches of N undamped waves without any force.

    Parameters
    ----------
    old
        Coordinates, three equal parts: displacements, velocities, accelerations. In each the two
        branches come first, one after the other.
    softening, participation
        alpha omega^2, and displacement per unit coordinate, (2N,).
    step
        s.
    new
        Receives the coordinates.
    deflection, rate
        Receive the waves' amplitudes and their rates, (N,).
    """
    count = deflection.size
    upper, v, a = count, old.size // 3, 2 * (old.size // 3)
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(count):
        q0 = old[k] + step * old[v + k] + quarter * old[a + k]
        q1 = old[upper + k] + step * old[v + upper + k] + quarter * old[a + upper + k]
        a0, a1 = -softening[k] * q0, -softening[upper + k] * q1
        v0 = old[v + k] + half * (old[a + k] + a0)
        v1 = old[v + upper + k] + half * (old[a + upper + k] + a1)
        q0 += quarter * a0
        q1 += quarter * a1
        new[k], new[upper + k] = q0, q1
        new[v + k], new[v + upper + k] = v0, v1
        new[a + k], new[a + upper + k] = a0, a1
        deflection[k] = participation[k] * q0 + participation[upper + k] * q1
        rate[k] = participation[k] * v0 + participation[upper + k] * v1


@stream
def step_single(old, first, softening, participation, step, new, deflection, rate):
    """As :func:`step_waves` for one branch, whose coordinates begin at ``first`` in each part."""
    count = deflection.size
    v, a = old.size // 3, 2 * (old.size // 3)
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(first, first + count):
        q0 = old[k] + step * old[v + k] + quarter * old[a + k]
        a0 = -softening[k] * q0
        v0 = old[v + k] + half * (old[a + k] + a0)
        q0 += quarter * a0
        new[k], new[v + k], new[a + k] = q0, v0, a0
        deflection[k - first] = participation[k] * q0
        rate[k - first] = participation[k] * v0


@stream
def step_damped(old, softening, drag, step, new):
    """Step damped oscillators without any force.

    ``old`` and ``new`` (3 x n,), ``softening`` alpha omega^2 and ``drag`` alpha c, (n,).
    """
    count = softening.size
    v, a = count, 2 * count
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(count):
        q0 = old[k] + step * old[v + k] + quarter * old[a + k]
        v0 = old[v + k] + half * old[a + k]
        a0 = -softening[k] * q0 - drag[k] * v0
        new[k], new[v + k], new[a + k] = q0 + quarter * a0, v0 + half * a0, a0


@stream
def add_force(state, first, drive, force, step):
    """Add the step's answer to modal forces, in place.

    ``state`` (3 x n,) from place ``first`` of each part on; ``drive`` is the acceleration alpha phi
    per unit ``force``, from the same place on; ``force`` (m,).
    """
    v, a = first + state.size // 3, first + 2 * (state.size // 3)
    half, quarter = 0.5 * step, 0.25 * step * step
    for k in range(force.size):
        change = drive[first + k] * force[k]
        state[first + k] += quarter * change
        state[v + k] += half * change
        state[a + k] += change


@kernel
def fold(place, sign, amplitudes, out):
    """Sum waves (N,) that look alike at the fasteners into ``out`` (2h,), both halves.

    ``place`` and ``sign`` (terms, 2h): the waves of each sum and their signs, 0 for none.
    """
    for i in range(out.size):
        total = 0.0
        for term in range(place.shape[0]):
            total += sign[term, i] * amplitudes[place[term, i]]
        out[i] = total


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
