"""Linear multibody system assembled from springs and dampers between points.

Every element joins one point of two bodies. The displacement of a body's
point follows from the body's coordinates, so lever arms and moments need no
formula of their own: with the Jacobian ``J`` of the relative motion of the
two points the element adds ``J^T k J`` to the stiffness.

Preloaded elements add two terms (see ``geometric_stiffness``): their points
move to second order when a body turns, and their force turns with them. These
are what makes a body above its springs want to topple, and what lets a
tilted suspension push sideways.
"""

import dataclasses
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from rail_vehicle.coordinates import COORDINATE_COUNT, PITCH, ROLL, YAW, coordinate

Array = NDArray[np.float64]

ZERO = np.zeros(3)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body as seen by the elements attached to it.

    Attributes
    ----------
    name
        For messages and tests.
    position
        Reference point (centre of mass, or axle of an axle box), shape (3,), m.
    motion
        Displacement and rotation of the reference point per coordinate,
        shape (6, 50).
    """

    name: str
    position: Array
    motion: Array

    @property
    def rotation(self) -> Array:
        """Rotation per coordinate, shape (3, 50)."""
        return self.motion[3:]

    def point_displacement(self, point: Array) -> Array:
        """Displacement of the body's point at ``point`` (3,) per coordinate, shape (3, 50)."""
        return self.motion[:3] - cross_matrix(point - self.position) @ self.motion[3:]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Element:
    """Spring and damper in parallel between one point of two bodies.

    Attributes
    ----------
    upper, lower
        The two bodies; deflection is the motion of ``upper`` less ``lower``.
    point
        Where the element acts, shape (3,), m.
    stiffness, damping
        Along x, y, z, shape (3,), N/m and N s/m.
    roll_stiffness
        Against relative roll, N m/rad.
    preload
        Force on ``upper`` at rest, shape (3,), N.
    """

    upper: Body
    lower: Body
    point: Array
    stiffness: Array = dataclasses.field(default_factory=lambda: ZERO)
    damping: Array = dataclasses.field(default_factory=lambda: ZERO)
    roll_stiffness: float = 0.0
    preload: Array = dataclasses.field(default_factory=lambda: ZERO)

    @property
    def deflection(self) -> Array:
        """Relative displacement of the two points per coordinate, shape (3, 50)."""
        return self.upper.point_displacement(self.point) - self.lower.point_displacement(self.point)


def cross_matrix(vector: Array) -> Array:
    """Return the matrix S of the cross product, ``S @ b == cross(vector, b)``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rigid_body(name: str, index: int, position: Array) -> Body:
    """Return the rigid body whose six coordinates are the ``index``-th six."""
    motion = np.zeros((6, COORDINATE_COUNT))
    motion[np.arange(6), coordinate(index, 0) + np.arange(6)] = 1.0
    return Body(name=name, position=position, motion=motion)


def axle_box(name: str, wheelset: Body, position: Array, pitch_coordinate: int) -> Body:
    """Return an axle box: it moves with the wheelset but pitches on its own.

    ``position`` lies on the axle, so that the wheelset's spin does not move it.
    """
    motion = np.zeros_like(wheelset.motion)
    motion[:3] = wheelset.point_displacement(position)
    motion[ROLL] = wheelset.motion[ROLL]
    motion[PITCH, pitch_coordinate] = 1.0
    motion[YAW] = wheelset.motion[YAW]
    return Body(name=name, position=position, motion=motion)


def stiffness_matrix(elements: Iterable[Element]) -> Array:
    """Assemble the stiffness matrix, geometric terms included, shape (50, 50)."""
    matrix = np.zeros((COORDINATE_COUNT, COORDINATE_COUNT))
    for element in elements:
        deflection = element.deflection
        matrix += deflection.T @ (element.stiffness[:, None] * deflection)
        roll = element.upper.rotation[0] - element.lower.rotation[0]
        matrix += element.roll_stiffness * np.outer(roll, roll)
        matrix += geometric_stiffness(element)
    return matrix


def damping_matrix(elements: Iterable[Element]) -> Array:
    """Assemble the damping matrix of the elements, shape (50, 50)."""
    matrix = np.zeros((COORDINATE_COUNT, COORDINATE_COUNT))
    for element in elements:
        deflection = element.deflection
        matrix += deflection.T @ (element.damping[:, None] * deflection)
    return matrix


def geometric_stiffness(element: Element) -> Array:
    r"""Stiffness from the preload ``F`` of an element, shape (50, 50).

    With the deflection ``d`` measured in axes that turn with the mean rotation
    ``m`` of the two bodies, as a coil or air spring between two seats does,
    the preload's energy is ``-F . (d - m x d)``. To second order in the
    rotations ``a``, ``b`` of the two bodies about their reference points, from
    where ``r`` and ``s`` lead to the element, that is

    ``-1/2 F.[a x (a x r)] + 1/2 F.[b x (b x s)] + F.[m x d]``.
    """
    force = element.preload
    if not force.any():
        return np.zeros((COORDINATE_COUNT, COORDINATE_COUNT))
    upper, lower = element.upper, element.lower
    matrix = upper.rotation.T @ _tilt(force, element.point - upper.position) @ upper.rotation
    matrix -= lower.rotation.T @ _tilt(force, element.point - lower.position) @ lower.rotation
    mean_rotation = 0.5 * (upper.rotation + lower.rotation)
    # F . (m x d) = d . (F x m), a bilinear form: its Hessian is the sum with the transpose.
    coupling = element.deflection.T @ cross_matrix(force) @ mean_rotation
    return matrix + coupling + coupling.T


def _tilt(force: Array, arm: Array) -> Array:
    """Hessian of ``-1/2 force . [a x (a x arm)]`` with respect to the rotation a."""
    product = np.outer(force, arm)
    return np.trace(product) * np.eye(3) - 0.5 * (product + product.T)
