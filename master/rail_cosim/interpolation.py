r"""How a slave understands the inputs of a macro step between two communication points.

This is the part of the coupling contract that ``coupling.input_time`` stands for, with ``H`` the
macro step, ``s = (t - t_0) / H`` from 0 to 1 over the step, and values at the communication
points ``s = ..., -2, -1, 0, 1``:

- *force* (``coupling.force_order`` = p, from 0 to 2): the polynomial of degree p through the newest
  p + 1 values; the newest is that of ``s = 0`` (``step_start``) or ``s = 1`` (``step_end``).
- *motion* with position and velocity: the cubic through both at the two newest points (Hermite);
  its velocity is ``z'(s) / H``. The pitch rate, which has no position: the line through both.
- A slave without ``coupling.input_time`` holds the newest value.

All of them are linear in the values, so they are weights: of the values at :data:`POINTS` for the
function at the nodes of Gauss's quadrature over the step.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS = (-2, -1, 0, 1)
"""Communication points that weights refer to; the step goes from 0 to 1."""

_nodes, _weights = np.polynomial.legendre.leggauss(4)
NODES, QUADRATURE = 0.5 * (_nodes + 1.0), 0.5 * _weights
"""Gauss's quadrature over the step, exact up to degree 7: a force's cubic times a velocity."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Velocity:
    """A velocity over the step: weights of velocities, and of positions over H.

    Attributes
    ----------
    of_velocities, of_positions
        Shape (nodes, points).
    """

    of_velocities: Array
    of_positions: Array


def polynomial(newest: int, degree: int) -> Array:
    """Return weights, (nodes, points), of the polynomial through ``degree + 1`` newest values.

    Lagrange's formula. ``newest`` is 0 or 1.
    """
    weights = np.zeros((NODES.size, len(POINTS)))
    used = range(newest - degree, newest + 1)
    for point in used:
        others = [other for other in used if other != point]
        factors = [(NODES - other) / (point - other) for other in others]
        weights[:, POINTS.index(point)] = np.prod(factors, axis=0) if factors else 1.0
    return weights


def hermite(newest: int) -> Velocity:
    """Return the velocity of the cubic through position and velocity at the two newest points."""
    found = Velocity(of_velocities=polynomial(newest, 0), of_positions=polynomial(newest, 0) * 0.0)
    s, now = NODES - (newest - 1), POINTS.index(newest)
    slope = 6.0 * s * (1.0 - s)
    found.of_positions[:, now - 1], found.of_positions[:, now] = -slope, slope
    found.of_velocities[:, now - 1] = (1.0 - s) * (1.0 - 3.0 * s)
    found.of_velocities[:, now] = s * (3.0 * s - 2.0)
    return found


def rate(weights: Array) -> Velocity:
    """Return a velocity that follows from velocities alone."""
    return Velocity(of_velocities=weights, of_positions=np.zeros_like(weights))
