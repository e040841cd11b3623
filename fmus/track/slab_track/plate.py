r"""Modes of a free rectangular plate by the Ritz method, for eq. (7) of the article.

Trial functions are products of Legendre polynomials. They satisfy no boundary
condition, as a free edge asks for none, contain the rigid motions exactly, and
are orthogonal, so the mass matrix is the identity. The four symmetry classes
(even and odd in x and y) are solved apart.

Thin (Kirchhoff) plate:

.. math:: U = \frac{D}{2}\int w_{xx}^2 + w_{yy}^2 + 2\nu w_{xx}w_{yy}
          + 2(1-\nu) w_{xy}^2 \,dA, \quad D = \frac{E h^3}{12(1-\nu^2)}
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre


class PlateModes(NamedTuple):
    """Mass-normalised modes of a free rectangular plate, by rising frequency.

    Attributes
    ----------
    omega_squared
        Squared circular frequencies, rad2/s2, shape (n,); zero for the rigid modes.
    even
        True where the shape is symmetric in y (alike under both rails), shape (n,).
    coefficients
        Ritz coefficients, shape (n, degrees in x, degrees in y), of the orthonormal
        Legendre products on the plate.
    length, width
        Dimensions of the plate in m.
    """

    omega_squared: np.ndarray
    even: np.ndarray
    coefficients: np.ndarray
    length: float
    width: float

    def shapes(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the mode shapes at points from the plate's centre, shape (n, points)."""
        along = _orthonormal(2.0 * np.asarray(x) / self.length, self.coefficients.shape[1])
        across = _orthonormal(2.0 * np.asarray(y) / self.width, self.coefficients.shape[2])
        return np.einsum(
            "nij,ip,jp->np", self.coefficients, along, across, optimize=True
        ) / np.sqrt(0.25 * self.length * self.width)


def _orthonormal(points: np.ndarray, degrees: int, derivative: int = 0) -> np.ndarray:
    """Orthonormal Legendre polynomials (or derivatives) on [-1, 1], shape (degrees, points)."""
    rows = [
        legendre.legval(points, legendre.legder(np.eye(degrees)[i], derivative)) * np.sqrt(i + 0.5)
        for i in range(degrees)
    ]
    return np.array(rows)


def _integrals(degrees: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integrals of f'' g'', f'' g and f' g' over [-1, 1] for all pairs of polynomials."""
    points, weights = legendre.leggauss(degrees + 1)
    f0, f1, f2 = (_orthonormal(points, degrees, d) for d in range(3))
    return (f2 * weights) @ f2.T, (f2 * weights) @ f0.T, (f1 * weights) @ f1.T


def free_plate_modes(
    *,
    length: float,
    width: float,
    thickness: float,
    youngs_modulus: float,
    poisson_ratio: float,
    density: float,
    count: int,
) -> PlateModes:
    """Return the first ``count`` modes of a free plate, the three rigid ones included.

    The mass norm is that of the whole plate: a rigid bounce has the shape
    1/sqrt(mass). Degrees are chosen so that the frequencies of the modes asked
    for are converged to 0.1 % or better.
    """
    nx, ny = _degrees(length / width, count)
    scale = _bending_stiffness(thickness, youngs_modulus, poisson_ratio) / (density * thickness)
    found = []
    for i, j, stiffness in _classes(nx, ny, length, width, poisson_ratio):
        values, vectors = np.linalg.eigh(scale * stiffness)
        for value, vector in zip(values[:count], vectors.T[:count], strict=True):
            full = np.zeros((nx, ny))
            full[np.ix_(i, j)] = vector.reshape(len(i), len(j))
            found.append((value, j[0] == 0, full))
    found.sort(key=lambda mode: mode[0])
    found = found[:count]
    omega_squared = np.array([mode[0] for mode in found])
    omega_squared[:3] = 0.0  # rigid modes, exact up to rounding
    return PlateModes(
        omega_squared=omega_squared,
        even=np.array([mode[1] for mode in found]),
        coefficients=np.array([mode[2] for mode in found]) / np.sqrt(density * thickness),
        length=length,
        width=width,
    )


def seat_compliance(
    *,
    length: float,
    width: float,
    thickness: float,
    youngs_modulus: float,
    poisson_ratio: float,
    foundation: float,
    seats: np.ndarray,
    offset: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the static compliance of a free plate on a uniform layer at its rail seats.

    The layer has ``foundation`` N/m3; seats stand at x = ``seats`` (C,) and y = -/+
    ``offset``. Returns the symmetric and antisymmetric matrices (C, C) in m/N for the
    orthonormal pairs (left +/- right)/sqrt(2).
    """
    bending = _bending_stiffness(thickness, youngs_modulus, poisson_ratio)
    # The dish under a seat has the size of the layer's characteristic length.
    dish = (bending / foundation) ** 0.25
    nx = int(np.clip(4.0 * length / dish, 24, 90))
    ny = int(np.clip(4.0 * width / dish, 24, 90))
    along = _orthonormal(2.0 * seats / length, nx)
    across = _orthonormal(np.array([2.0 * offset / width]), ny)[:, 0]
    result = [np.zeros((seats.size, seats.size)) for _ in range(2)]
    for i, j, stiffness in _classes(nx, ny, length, width, poisson_ratio):
        matrix = bending * stiffness
        matrix[np.diag_indices_from(matrix)] += foundation
        loads = np.sqrt(2.0) * np.kron(along[i], across[j][:, None])
        loads /= np.sqrt(0.25 * length * width)
        result[int(j[0])] += loads.T @ np.linalg.solve(matrix, loads)
    return result[0], result[1]


def _bending_stiffness(thickness: float, youngs_modulus: float, poisson_ratio: float) -> float:
    return youngs_modulus * thickness**3 / (12.0 * (1.0 - poisson_ratio**2))


def _classes(
    nx: int, ny: int, length: float, width: float, poisson_ratio: float
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Degrees in x, degrees in y and stiffness at D = 1 of the four symmetry classes."""
    sx, sy = 2.0 / length, 2.0 / width
    a2, a20, a1 = _integrals(nx)
    b2, b20, b1 = _integrals(ny)
    for px in (0, 1):
        for py in (0, 1):
            i, j = np.arange(px, nx, 2), np.arange(py, ny, 2)
            ii, jj = np.ix_(i, i), np.ix_(j, j)
            yield (
                i,
                j,
                sx**4 * np.kron(a2[ii], np.eye(j.size))
                + sy**4 * np.kron(np.eye(i.size), b2[jj])
                + poisson_ratio
                * (sx * sy) ** 2
                * (np.kron(a20[ii], b20[jj].T) + np.kron(a20[ii].T, b20[jj]))
                + 2.0 * (1.0 - poisson_ratio) * (sx * sy) ** 2 * np.kron(a1[ii], b1[jj]),
            )


def _degrees(aspect: float, count: int) -> tuple[int, int]:
    """Numbers of polynomials along and across that resolve ``count`` modes."""
    # A plate of aspect a has about sqrt(count*a) half waves along it; a polynomial
    # basis needs some pi/2 degrees per half wave, and a dozen for the edges.
    along = np.sqrt(count * aspect)
    across = np.sqrt(count / aspect)
    return int(np.ceil(1.7 * along)) + 12, int(np.ceil(1.7 * across)) + 12
