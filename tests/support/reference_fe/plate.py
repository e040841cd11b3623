"""Slab: free thin plate of conforming Bogner-Fox-Schmit elements on a uniform foundation.

The elements are products of cubic Hermite shapes, so every matrix is a sum of Kronecker products
of one-dimensional ones. Both rails being alike, only the half y >= 0 is meshed, once for motion
symmetric about the centre line and once for antisymmetric motion.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy.linalg

from .parameters import ReferenceTrack

Symmetry = Literal["symmetric", "antisymmetric"]


@dataclass(frozen=True, kw_only=True)
class HalfSlab:
    """Modes of half a slab, normalised to unit modal mass.

    Attributes
    ----------
    plate_frequency : ndarray, shape (mode,)
        Angular frequency of the free plate in rad/s, without foundation.
    stiffness, damping : ndarray, shape (mode,)
        Modal values on the foundation, in 1/s2 and 1/s.
    seat_shape : ndarray, shape (seat, mode)
        Deflection at the rail seats in 1/sqrt(kg).
    """

    plate_frequency: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    seat_shape: np.ndarray


def hermite_matrices(nodes: np.ndarray) -> dict[str, np.ndarray]:
    """Integrals of cubic Hermite shapes, dofs (value, slope) per node.

    Keys name the derivatives of test and trial shapes: "00", "11", "22", "20".
    """
    size = 2 * len(nodes)
    matrices = {key: np.zeros((size, size)) for key in ("00", "11", "22", "20")}
    points, weights = np.polynomial.legendre.leggauss(4)
    for element, h in enumerate(np.diff(nodes)):
        place = slice(2 * element, 2 * element + 4)
        for point, weight in zip(0.5 * (points + 1), 0.5 * weights * h, strict=True):
            derivative = _hermite_shapes(point, h)
            for key, matrix in matrices.items():
                test, trial = derivative[int(key[0])], derivative[int(key[1])]
                matrix[place, place] += weight * np.outer(test, trial)
    return matrices


def _hermite_shapes(s: float, h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, first and second x-derivative of the four shapes at x = s * h."""
    value = [1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3]
    slope = [6 * (s**2 - s) / h, 1 - 4 * s + 3 * s**2, 6 * (s - s**2) / h]
    second = [(12 * s - 6) / h**2, (6 * s - 4) / h, (6 - 12 * s) / h**2]
    return (
        np.array([*value, h * (s**3 - s**2)]),
        np.array([*slope, 3 * s**2 - 2 * s]),
        np.array([*second, (6 * s - 2) / h]),
    )


def plate_matrices(
    x: np.ndarray,
    y: np.ndarray,
    *,
    rigidity: float,
    poisson_ratio: float,
    mass_per_area: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a free plate; dof order: x dof outer, y dof inner."""
    along, across = hermite_matrices(x), hermite_matrices(y)
    mixed = np.kron(along["20"], across["20"].T)
    stiffness = rigidity * (
        np.kron(along["22"], across["00"])
        + np.kron(along["00"], across["22"])
        + poisson_ratio * (mixed + mixed.T)
        + 2 * (1 - poisson_ratio) * np.kron(along["11"], across["11"])
    )
    return mass_per_area * np.kron(along["00"], across["00"]), stiffness


def subdivide(points: np.ndarray, size: float) -> np.ndarray:
    """Grid through all points whose elements are about ``size`` long."""
    pieces = [
        np.linspace(a, b, max(1, round((b - a) / size)) + 1)[:-1] for a, b in pairwise(points)
    ]
    return np.append(np.concatenate(pieces), points[-1])


def half_slab(track: ReferenceTrack, symmetry: Symmetry) -> HalfSlab:
    """Lowest plate modes and the static shapes of unit forces at the rail seats.

    The foundation is a multiple of the mass matrix, hence diagonal in the plate's modes; the
    seats' static shapes, freed from the kept modes, carry the flexibility of all others.
    """
    mass, stiffness, seats = _half_plate(track, symmetry)
    count = min(track.slab_mode_count, len(mass) - len(seats))
    eigenvalues, modes = scipy.linalg.eigh(stiffness, mass, subset_by_index=(0, count - 1))
    support = track.foundation_stiffness / track.slab_mass_per_area
    static = np.linalg.solve(stiffness + support * mass, np.eye(len(mass))[:, seats])
    static -= modes @ (modes.T @ (mass @ static))
    static /= np.sqrt(np.einsum("ij,ij->j", static, mass @ static))
    extra, shapes = scipy.linalg.eigh(static.T @ stiffness @ static, static.T @ mass @ static)
    square = np.maximum(np.concatenate([eigenvalues, extra]), 0.0)
    frequency = np.sqrt(square)
    return HalfSlab(
        plate_frequency=frequency,
        stiffness=square + support,
        damping=2 * track.slab_damping_ratio * frequency
        + track.foundation_damping / track.slab_mass_per_area,
        seat_shape=np.hstack([modes, static @ shapes])[seats],
    )


def _half_plate(
    track: ReferenceTrack, symmetry: Symmetry
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, stiffness and the dofs of the rail seats' deflections."""
    half_length = 0.5 * track.actual_slab_length
    half_count = 0.5 * (track.fastener_count_per_slab - 1)
    seat_x = np.linspace(-half_count, half_count, track.fastener_count_per_slab)
    seat_x = seat_x * track.fastener_spacing
    x = subdivide(
        np.array([-half_length, *seat_x, half_length]),
        track.fastener_spacing / track.slab_elements_per_bay,
    )
    half_width, seat_y = 0.5 * track.slab_width, 0.5 * track.rail_distance
    y = subdivide(np.array([0.0, seat_y, half_width]), half_width / track.slab_elements_across)
    rigidity = track.slab_youngs_modulus * track.slab_thickness**3
    rigidity /= 12 * (1 - track.slab_poisson_ratio**2)
    mass, stiffness = plate_matrices(
        x,
        y,
        rigidity=rigidity,
        poisson_ratio=track.slab_poisson_ratio,
        mass_per_area=track.slab_mass_per_area,
    )
    dof_y = 2 * len(y)
    column = 2 * np.array([np.abs(x - seat).argmin() for seat in seat_x])
    seats = column * dof_y + 2 * np.abs(y - seat_y).argmin()
    # On the centre line slope (symmetric) or value (antisymmetric) vanish.
    fixed = 1 if symmetry == "symmetric" else 0
    kept = np.flatnonzero(np.arange(len(mass)) % dof_y != fixed)
    inside = np.ix_(kept, kept)
    return mass[inside], stiffness[inside], np.searchsorted(kept, seats)
