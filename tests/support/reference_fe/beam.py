"""Rail: Timoshenko beam elements whose shapes solve the static beam equations exactly.

Two nodes, each with deflection ``w`` and section rotation ``theta``. Deflection is cubic, rotation
quadratic, bound by constant shear within an element (Friedman and Kosmatka, Computers and
Structures 47, 1993), so there is no locking, and static nodal values are exact for any load.
"""

from dataclasses import dataclass

import numpy as np

from .parameters import ReferenceTrack

HALF_BANDWIDTH = 3


@dataclass(frozen=True, kw_only=True)
class BeamSection:
    """Stiffnesses (N m2, N) and inertias (kg/m, kg m) of the rail's section."""

    bending_stiffness: float
    shear_stiffness: float
    mass_per_length: float
    rotary_inertia: float

    @classmethod
    def of(cls, track: ReferenceTrack) -> "BeamSection":
        """Section of a track's rail."""
        shear = track.rail_shear_coefficient * track.rail_shear_modulus * track.rail_area
        return cls(
            bending_stiffness=track.rail_youngs_modulus * track.rail_second_moment,
            shear_stiffness=shear,
            mass_per_length=track.rail_density * track.rail_area,
            rotary_inertia=track.rail_density * track.rail_second_moment,
        )


def shape_coefficients(section: BeamSection, length: float) -> np.ndarray:
    """Coefficients (shape: power 0-3, element dof) of the deflection shapes in x, 0 <= x <= L."""
    ratio = section.bending_stiffness / section.shear_stiffness
    nodal = np.zeros((4, 4))
    for node, x in enumerate((0.0, length)):
        nodal[2 * node] = 1.0, x, x**2, x**3
        nodal[2 * node + 1] = 0.0, 1.0, 2 * x, 3 * x**2 + 6 * ratio  # theta = w' + EI/kGA w'''
    return np.linalg.inv(nodal)


def element_matrices(section: BeamSection, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Consistent mass and stiffness (each 4 x 4) for the dofs w1, theta1, w2, theta2."""
    ratio = section.bending_stiffness / section.shear_stiffness
    coefficients = shape_coefficients(section, length)
    mass, stiffness = np.zeros((4, 4)), np.zeros((4, 4))
    points, weights = np.polynomial.legendre.leggauss(4)
    for x, weight in zip(0.5 * length * (points + 1), 0.5 * length * weights, strict=True):
        deflection = np.array([1, x, x**2, x**3]) @ coefficients
        rotation = np.array([0, 1, 2 * x, 3 * x**2 + 6 * ratio]) @ coefficients
        curvature = np.array([0, 0, 2, 6 * x]) @ coefficients
        shear = np.array([0, 0, 0, -6 * ratio]) @ coefficients  # w' - theta
        mass += weight * section.mass_per_length * np.outer(deflection, deflection)
        mass += weight * section.rotary_inertia * np.outer(rotation, rotation)
        stiffness += weight * section.bending_stiffness * np.outer(curvature, curvature)
        stiffness += weight * section.shear_stiffness * np.outer(shear, shear)
    return mass, stiffness


def assemble_hinged(
    section: BeamSection, element_length: float, element_count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a beam hinged at both ends, by diagonals.

    Returns
    -------
    mass, stiffness : ndarray, shape (7, dof)
        ``matrix[3 + d, i]`` is entry ``(i, i + d)``. The two end deflections stay as unit rows
        apart from the rest, so that a node's dofs remain ``2 * node`` and ``2 * node + 1``.
    """
    size = 2 * (element_count + 1)
    first = 2 * np.arange(element_count)
    matrices = []
    for element in element_matrices(section, element_length):
        diagonals = np.zeros((2 * HALF_BANDWIDTH + 1, size))
        for i in range(4):
            for j in range(4):
                diagonals[HALF_BANDWIDTH + j - i, first + i] += element[i, j]
        for end in (0, size - 2):
            for d in range(-HALF_BANDWIDTH, HALF_BANDWIDTH + 1):
                diagonals[HALF_BANDWIDTH + d, end] = 0.0
                if 0 <= end - d < size:
                    diagonals[HALF_BANDWIDTH + d, end - d] = 0.0
            diagonals[HALF_BANDWIDTH, end] = 1.0
        matrices.append(diagonals)
    return matrices[0], matrices[1]
