r"""FASTSIM: creep forces of an elliptic contact by Kalker's simplified theory.

The ellipse is cut into strips along the rolling direction x. Along a strip the traction
on the wheel grows from the leading edge as ``dp/dx = w / L`` against the rolling direction
until the bound ``mu p_z`` (parabolic over x and y) is reached, with the rigid slip
``w = (xi - phi y, eta + phi x)`` per unit of rolling speed and the flexibilities

.. math:: L_1 = \frac{8 a}{3 G C_{11}},\quad L_2 = \frac{8 a}{3 G C_{22}},\quad
          L_3 = \frac{\pi a \sqrt{a/b}}{4 G C_{23}}

Up to there the traction is known in closed form: at the distance s from the leading edge
:math:`-s\,(w_x, w_y - \tfrac12 \phi s)`, with the slip at the edge. It meets the bound
:math:`s\,(2 l - s)`, l being half the strip's length, at the smallest root of

.. math:: (1 - \tfrac14\phi^2) s^2 - 2 (2 l - \tfrac12 w_y \phi) s + 4 l^2 - w_x^2 - w_y^2 = 0

(in units of the semi-axes and of the bound), and its integrals are polynomials in s. Only
the rest of the strip is stepped through, in cells whose centres are the zeros of a Chebyshev
polynomial, with Fejer's weights: exact for the parabola of full slip. Each step takes the
slip at its middle. Strips are at equal steps of the angle whose sine is y. As no cell holds
both adhesion and slip, 10 x 8 cells are within 0.1 % of :func:`closed_form`, and the forces
are smooth functions of the creepages.

In a slipping cell the traction must oppose the slip ``w - L dp/dx``. With different
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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rail_native import Matrix, Vector, fast_kernel

from slab_track.core import core

_LANES = 8
"""Strips that are computed side by side: constant, so that the compiler uses vectors."""

# Rows of the working array: what is known of each strip while it is stepped through.
_HALF, _EDGE, _MIDDLE, _LENGTH, _SLIP, _P_X, _P_Y, _SUM_X, _SUM_Y, _SUM_M, _HELD = range(11)
_ROWS = 11
STRIP_WORK = _ROWS * _LANES
"""Numbers that :func:`creep_forces` computes on its way."""


class FastsimGrid(NamedTuple):
    """Places and weights of FASTSIM's cells.

    Attributes
    ----------
    strips
        y, half length, and width times half length of the strips, in units of the
        semi-axes, shape (3, n); n is filled up to a multiple of 8 with strips of no width.
    columns
        Places on (-1, 1) from the leading end of the slip zone, and weights, shape (2, m).
    """

    strips: Matrix
    columns: Matrix


def fastsim_grid(columns: int, strips: int) -> FastsimGrid:
    """Return the :class:`FastsimGrid` of ``columns`` x ``strips`` cells."""
    count = -(-strips // _LANES) * _LANES
    across, along = np.zeros((3, count)), np.empty((2, columns))
    across[1] = 1.0
    for row in range(strips):
        theta = (row + 0.5) * math.pi / strips - 0.5 * math.pi
        across[0, row], across[1, row] = math.sin(theta), math.cos(theta)
        across[2, row] = math.cos(theta) * math.pi / strips
    for column in range(columns):
        theta = (column + 0.5) * math.pi / columns
        along[0, column], weight = math.cos(theta), 1.0
        for k in range(1, columns // 2 + 1):
            weight -= 2.0 * math.cos(2 * k * theta) / (4 * k * k - 1)
        along[1, column] = 2.0 / columns * weight
    return FastsimGrid(across, along)


def fastsim(
    normal_force: float,
    a: float,
    b: float,
    c11: float,
    c22: float,
    c23: float,
    shear_modulus: float,
    friction: float,
    xi: float,
    eta: float,
    phi: float,
    columns: int,
    strips: int,
) -> tuple[float, float, float]:
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
        Cells of the slip zone along, and strips across.

    Returns
    -------
    Longitudinal force (N), lateral force (N), moment about the contact normal (N.m).
    """
    t_x, t_y, moment, _ = creep_forces(
        fastsim_grid(columns, strips), np.zeros(STRIP_WORK),
        normal_force, a, b, c11, c22, c23, shear_modulus, friction, xi, eta, phi,
    )  # fmt: skip
    return t_x, t_y, moment


@core.entry
def creep_forces(
    grid: FastsimGrid,
    work: Vector,
    normal_force: float,
    a: float,
    b: float,
    c11: float,
    c22: float,
    c23: float,
    shear_modulus: float,
    friction: float,
    xi: float,
    eta: float,
    phi: float,
) -> tuple[float, float, float, float]:
    """As :func:`fastsim`, on a grid made before, with ``work`` (STRIP_WORK,).

    A fourth value is the part of Kalker's slope of the forces, 0 to 1, that the adhering particles
    account for: the slope itself lies between this part of it and the whole.
    """
    if normal_force <= 0.0 or friction <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    # Everything in units of the semi-axes and of the traction bound at the centre.
    bound = 2.0 * friction * normal_force / (math.pi * a * b)
    scale = 0.375 * shear_modulus * c11 / bound
    slip_x = xi * scale
    slip_y = eta * scale * c22 / c11
    spin = phi * 4.0 * shear_modulus * c23 / (math.pi * math.sqrt(a / b) * bound)
    stiffer = math.sqrt(c22 / c11)
    force_x = force_y = moment = held = 0.0
    for first in range(0, grid.strips.shape[1], _LANES):
        _adhere(grid.strips, first, slip_x, slip_y, spin * a, spin * b, work)
        _slip(grid.columns, slip_y, spin * a, stiffer, work)
        for i in range(_LANES):
            weight, sum_x = grid.strips[2, first + i], work[_SUM_X * _LANES + i]
            force_x += weight * sum_x
            force_y += weight * work[_SUM_Y * _LANES + i]
            held += weight * work[_HELD * _LANES + i]
            moment += weight * (
                a * work[_SUM_M * _LANES + i] - b * grid.strips[0, first + i] * sum_x
            )
    unit = bound * a * b
    # Without slip the sum is 16 / 3.
    return unit * force_x, unit * force_y, unit * moment, 0.1875 * held


@fast_kernel
def _adhere(strips, first, slip_x, slip_y, spin_a, spin_b, work):
    """Fill ``work`` with the traction where adhesion ends, and its integrals up to there."""
    for i in range(_LANES):
        half = strips[1, first + i]
        w_x, w_y = slip_x - spin_b * strips[0, first + i], slip_y + spin_a * half
        linear = 2.0 * half - 0.5 * w_y * spin_a
        constant = 4.0 * half * half - w_x * w_x - w_y * w_y
        # The discriminant, written so that nothing cancels.
        centre = w_y - spin_a * half
        square = w_x * w_x * (1.0 - 0.25 * spin_a * spin_a) + centre * centre
        divisor = linear + math.sqrt(max(square, 0.0))
        meets = (square >= 0.0) & (divisor > 0.0)
        s = min(constant / divisor if meets else 2.0 * half, 2.0 * half)
        s = s if constant > 0.0 else 0.0
        s2 = s * s
        sum_y = s2 * (spin_a * s / 6.0 - 0.5 * w_y)
        work[_HALF * _LANES + i] = half
        work[_EDGE * _LANES + i] = half - s
        work[_MIDDLE * _LANES + i] = -0.5 * s
        work[_LENGTH * _LANES + i] = half - 0.5 * s
        work[_SLIP * _LANES + i] = w_x
        work[_P_X * _LANES + i] = -w_x * s
        work[_P_Y * _LANES + i] = (0.5 * spin_a * s - w_y) * s
        work[_HELD * _LANES + i] = s2
        work[_SUM_X * _LANES + i] = -0.5 * w_x * s2
        work[_SUM_Y * _LANES + i] = sum_y
        work[_SUM_M * _LANES + i] = half * sum_y + s2 * s * (w_y / 3.0 - 0.125 * spin_a * s)


@fast_kernel
def _slip(columns, slip_y, spin_a, stiffer, work):
    """Step through the rest of the strips, in place."""
    softer = 1.0 / stiffer
    for column in range(columns.shape[1]):
        node, share = columns[0, column], columns[1, column]
        for i in range(_LANES):
            half, length = work[_HALF * _LANES + i], work[_LENGTH * _LANES + i]
            edge = work[_EDGE * _LANES + i]
            x = work[_MIDDLE * _LANES + i] + length * node
            step = edge - x
            p_x = work[_P_X * _LANES + i] - work[_SLIP * _LANES + i] * step
            p_y = work[_P_Y * _LANES + i] - (slip_y + 0.5 * spin_a * (edge + x)) * step
            limit = (half - x) * (half + x)
            excess = math.sqrt(p_x * p_x + p_y * p_y) - limit
            # Onto the bound, in the direction of the slip.
            q_x, q_y = p_x * (limit + excess * stiffer), p_y * (limit + excess * softer)
            reduction = limit / math.sqrt(q_x * q_x + q_y * q_y)
            p_x = q_x * reduction if excess > 0.0 else p_x
            p_y = q_y * reduction if excess > 0.0 else p_y
            weight = share * length
            work[_EDGE * _LANES + i] = x
            work[_P_X * _LANES + i], work[_P_Y * _LANES + i] = p_x, p_y
            work[_SUM_X * _LANES + i] += weight * p_x
            work[_SUM_Y * _LANES + i] += weight * p_y
            work[_SUM_M * _LANES + i] += weight * p_y * x


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
