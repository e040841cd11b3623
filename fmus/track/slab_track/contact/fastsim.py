r"""FASTSIM: creep forces of an elliptic contact by Kalker's simplified theory.

The ellipse is cut into strips along the rolling direction x, each strip into
columns from its leading edge. Along a strip the traction on the wheel grows as
``dp/dx = w / L`` against the rolling direction until the bound
``mu p_z`` (parabolic over x and y) is reached, with the rigid slip
``w = (xi - phi y, eta + phi x)`` per unit of rolling speed and the flexibilities

.. math:: L_1 = \frac{8 a}{3 G C_{11}},\quad L_2 = \frac{8 a}{3 G C_{22}},\quad
          L_3 = \frac{\pi a \sqrt{a/b}}{4 G C_{23}}

Tractions are taken at the columns' centres: the first step is half a column long,
and each step takes the slip at its middle. Columns are narrower towards the leading and
trailing edge and strips towards the sides (equal steps of the angle of a cosine): the
trailing edge, where slip begins, is resolved, and the quadrature over y converges
faster than with equal strips. 12 x 10 cells are within 0.9 % of :func:`closed_form`
from tau = 0.05 to full slip, where 12 x 10 equal ones err by 3 %.

In a slipping column the traction must oppose the slip ``w - L dp/dx``. With different
flexibilities that is not the direction of the adhesive traction ``p'``, by which FASTSIM
is usually scaled down: Coulomb's law in the step is ``p_i (1 + k / L_i) = p'_i`` with
the slip per traction k, so ``p`` is along ``p'_x (1 + k / L_2), p'_y (1 + k / L_1)``. Here k
is taken from the excess ``|p'| / (mu p_z) - 1`` and the mean of ``1/L``: exact for one
direction or equal flexibilities, otherwise good to the square of the difference of the
``L_i``. In full slip forces then oppose the creepage; plain scaling turns them, by
6 deg at a/b = 0.5.

References
----------
J. J. Kalker, A fast algorithm for the simplified theory of rolling contact,
Vehicle System Dynamics 11 (1982) 1-13.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, fastmath={"contract", "arcp"})
def fastsim(
    normal_force, a, b, c11, c22, c23, shear_modulus, friction, xi, eta, phi, columns, strips
):
    """Return forces and moment on the wheel in the contact plane.

    Parameters
    ----------
    normal_force
        N; 0 or less gives no force.
    a, b
        Semi-axes in and across the rolling direction (m).
    c11, c22, c23
        Kalker's coefficients.
    shear_modulus
        Pa.
    friction
        Coefficient of friction.
    xi, eta, phi
        Longitudinal and lateral creepage (1) and spin (1/m), wheel less rail,
        per unit of rolling speed.
    columns, strips
        Cells along and across.

    Returns
    -------
    Longitudinal force (N), lateral force (N), moment about the contact normal (N.m).
    """
    if normal_force <= 0.0 or friction <= 0.0:
        return 0.0, 0.0, 0.0
    # Everything in units of the semi-axes and of the traction bound at the centre.
    bound = 2.0 * friction * normal_force / (math.pi * a * b)
    scale = 0.375 * shear_modulus * c11 / bound
    slip_x = xi * scale
    slip_y = eta * scale * c22 / c11
    spin = phi * 4.0 * shear_modulus * c23 / (math.pi * math.sqrt(a / b) * bound)
    spin_a, spin_b = spin * a, spin * b
    stiffer = math.sqrt(c22 / c11)
    softer = 1.0 / stiffer
    force_x = force_y = moment = 0.0
    d_theta, d_psi = math.pi / strips, math.pi / columns
    turn_c, turn_s = math.cos(d_psi), math.sin(d_psi)
    first_c, first_s = math.cos(0.5 * d_psi), math.sin(0.5 * d_psi)
    for row in range(strips):
        theta = (row + 0.5) * d_theta - 0.5 * math.pi
        y, half = math.sin(theta), math.cos(theta)
        slip_row = slip_x - spin_b * y
        p_x = p_y = 0.0
        sum_x = sum_y = sum_m = 0.0
        edge, cosine, sine = half, first_c, first_s
        for _ in range(columns):
            x = half * cosine
            step = edge - x
            p_x -= slip_row * step
            p_y -= (slip_y + 0.5 * spin_a * (edge + x)) * step
            limit = (half - x) * (half + x)
            square = p_x * p_x + p_y * p_y
            if square > limit * limit:
                # Onto the bound, in the direction of the slip.
                excess = math.sqrt(square) / limit - 1.0
                p_x *= 1.0 + excess * stiffer
                p_y *= 1.0 + excess * softer
                reduction = limit / math.sqrt(p_x * p_x + p_y * p_y)
                p_x *= reduction
                p_y *= reduction
            sum_x += p_x * sine
            sum_y += p_y * sine
            sum_m += p_y * sine * x
            cosine, sine = cosine * turn_c - sine * turn_s, sine * turn_c + cosine * turn_s
            edge = x
        # Width of a column: 2 half sin(d_psi / 2) sine; of the strip: half d_theta.
        weight = 2.0 * first_s * half * half * d_theta
        force_x += weight * sum_x
        force_y += weight * sum_y
        moment += weight * (a * sum_m - b * y * sum_x)
    unit = bound * a * b
    return unit * force_x, unit * force_y, unit * moment


def closed_form(tau: float, nodes: int = 400) -> float:
    """Return ``F / (mu N)`` of the simplified theory for pure longitudinal creepage.

    ``tau = G a b C11 xi / (mu N)``; parabolic traction bound. The exact limit of
    :func:`fastsim` for ever finer grids.
    """
    s = 3.0 * math.pi * tau / 16.0
    # Gauss-Legendre in theta, y = sin(theta): the integrand is smooth at the edges.
    node, weight = np.polynomial.legendre.leggauss(nodes)
    half = np.cos(0.5 * math.pi * node)
    adhesion = 2.0 * half**2 * s - half * s**2 + s**3 / 6.0
    phi: NDArray[np.float64] = np.where(s < 2.0 * half, adhesion, 4.0 * half**3 / 3.0)
    return float(2.0 / math.pi * np.sum(weight * 0.5 * math.pi * half * phi))
