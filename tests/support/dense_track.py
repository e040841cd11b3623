"""The window's vertical modal track as second-order matrices, for tests of the compiled step."""

from typing import NamedTuple

import numpy as np
from slab_track.assembly import LinearTrack
from slab_track.matrices import PSI, VERTICAL, TrackMatrices, Z
from slab_track.parameters import TrackParameters


class DenseTrack(NamedTuple):
    """Fasteners included, M = 1; coordinates: left rail (2N), right rail (2N), slabs (S n)."""

    damping: np.ndarray
    stiffness: np.ndarray
    matrices: TrackMatrices
    vertical: np.ndarray

    def wheel_rows(self, positions: np.ndarray) -> np.ndarray:
        """Deflection under the wheels, rows left wheels then right wheels."""
        rows = self.matrices.wheels(positions)[0].reshape(positions.size, 2, 3, -1)
        return np.concatenate([rows[:, 0, VERTICAL], rows[:, 1, VERTICAL]])[:, self.vertical]


def dense_track(p: TrackParameters) -> DenseTrack:
    """Return the matrices of a track without residual compliance."""
    t = TrackMatrices(p)
    rail = np.isin(
        np.arange(10 * t.waves.wave_number.size) // t.waves.wave_number.size % 5, (Z, PSI)
    )
    vertical = np.flatnonzero(np.append(rail, np.ones(t.c.size - rail.size, bool)))
    pick = np.ix_(vertical, vertical)
    stiffness = t.K + t.B.T @ (t.k_p[:, None] * t.B)
    damping = np.diag(t.c) + t.B.T @ (t.c_p[:, None] * t.B)
    return DenseTrack(damping[pick], stiffness[pick], t, vertical)


def field_energy(track: LinearTrack, state) -> float:
    """Kinetic and elastic energy of a track state without residual compliance, J."""
    energy = 0.0
    for symmetry, field in enumerate((state.symmetric, state.antisymmetric)):
        rail, slab = track.rail, track.slabs[symmetry]
        energy += 0.5 * np.sum(field.rail[1] ** 2 + rail.omega_squared * field.rail[0] ** 2)
        energy += 0.5 * np.sum(field.slab[1] ** 2 + slab.omega_squared * field.slab[0] ** 2)
        amplitude = np.sum(rail.deflection * field.rail[0], axis=0)
        at_fasteners = track.fastener_sines.T @ track.fold(amplitude)
        compression = at_fasteners - (field.slab[0] @ slab.seats).ravel()
        energy += 0.5 * track.stiffness * np.sum(compression**2)
    return energy
