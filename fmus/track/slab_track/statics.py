"""Static equilibrium of the window under given forces at the rail heads."""

from typing import NamedTuple

import numpy as np

from slab_track.assembly import LinearTrack


class StaticSolution(NamedTuple):
    """Equilibrium of one symmetry class.

    Attributes
    ----------
    rail, slab
        Modal coordinates, (2, N) and (S, n).
    fastener
        Forces in the fasteners, (P,), N, compression positive.
    residual
        Part of the fasteners' compression from the modes left out, (P,), m.
    deflection
        Of the rail under the loads, (w,), m.
    """

    rail: np.ndarray
    slab: np.ndarray
    fastener: np.ndarray
    residual: np.ndarray
    deflection: np.ndarray


class StaticTrack:
    """One symmetry class at rest under forces at given places: what does not depend on the forces.

    ``positions`` (w,) in m from the window's start.
    """

    def __init__(self, track: LinearTrack, positions: np.ndarray, symmetry: int) -> None:
        self._track, self._slab = track, track.slabs[symmetry]
        rail, slab = track.rail, self._slab
        # A ring's first mode is its rise as a whole, which only the fasteners hold.
        self._rigid = rigid = rail.omega_squared == 0.0
        flexibility = np.where(rigid, 0.0, 1.0 / np.where(rigid, 1.0, rail.omega_squared))
        beta = np.sum(track.participation**2 * flexibility, axis=0)
        places = (np.arange(track.fastener_count) + 0.5) * track.length / track.fastener_count
        self._residual = track.fastener_residual(symmetry)
        matrix = track.fastener_admittance(flexibility, 1.0 / slab.omega_squared, symmetry)
        self._matrix = matrix + self._residual + np.eye(track.fastener_count) / track.stiffness
        modal = track.wave_shapes(positions)
        to_fasteners = track.wave_shapes(places).T @ (beta[:, None] * modal)
        direct = modal.T @ (beta[:, None] * modal)
        rail_residual = np.zeros_like(to_fasteners)
        if track.residual_flexibility.size:
            fine, weight = track.fine.shapes(positions), track.residual_flexibility[:, None]
            rail_residual = track.fine.shapes(places).T @ (weight * fine)
            direct = direct + fine.T @ (weight * fine)
        self._modal, self._direct, self._flexibility = modal, direct, flexibility
        self._both, self._rail_residual = to_fasteners + rail_residual, rail_residual

    def solve(self, forces: np.ndarray) -> StaticSolution:
        """Return the equilibrium under forces (w,) of this symmetry class, N."""
        track, slab, rigid = self._track, self._slab, self._rigid
        load, free = float(np.sum(forces)), bool(rigid.any())
        fastener, rise = _carry(self._matrix, self._both @ forces, load, free=free)
        net = self._modal @ forces - track.unfold(track.fastener_sines @ fastener)
        seat_forces = fastener.reshape(track.slab_count, track.seat_count)
        coordinates = self._flexibility * track.participation * net
        if free:
            coordinates[rigid] = rise / track.participation[rigid]
        return StaticSolution(
            rail=coordinates,
            slab=seat_forces @ slab.seats.T / slab.omega_squared,
            fastener=fastener,
            residual=self._rail_residual @ forces - self._residual @ fastener,
            deflection=self._direct @ forces - self._both.T @ fastener + rise,
        )


def static_coordinates(
    track: LinearTrack, positions: np.ndarray, forces: np.ndarray, symmetry: int
) -> StaticSolution:
    """Solve the equilibrium of one symmetry class.

    ``positions`` (w,) in m from the window's start and ``forces`` (w,) in N are
    those of one symmetry class.
    """
    return StaticTrack(track, positions, symmetry).solve(forces)


def _carry(
    matrix: np.ndarray, extension: np.ndarray, load: float, *, free: bool
) -> tuple[np.ndarray, float]:
    """Return the fastener forces (P,) and the rise of the whole rail, m, 0 if it is held.

    A rail that can rise does so until the fasteners carry the ``load``.
    """
    if not free:
        return np.linalg.solve(matrix, extension), 0.0
    count = extension.size
    border = np.ones((count, 1))
    bordered = np.block([[matrix, -border], [border.T, np.zeros((1, 1))]])
    solution = np.linalg.solve(bordered, np.append(extension, load))
    return solution[:count], float(solution[count])
