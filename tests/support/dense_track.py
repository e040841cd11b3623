"""The window's modal track as plain dense matrices, for tests of the compiled step.

Nothing is folded, symmetrised or reduced here: both rails, all slabs, all fasteners
in one second-order system M = 1, C, K.
"""

from typing import NamedTuple

import numpy as np
from slab_track.assembly import LinearTrack, plate_modes
from slab_track.parameters import TrackParameters
from slab_track.rail import vertical_modes


class DenseTrack(NamedTuple):
    """Mass-normalised coordinates: left rail (2N), right rail (2N), slabs (S n)."""

    damping: np.ndarray
    stiffness: np.ndarray
    wave_number: np.ndarray
    deflection: np.ndarray

    def wheel_rows(self, positions: np.ndarray) -> np.ndarray:
        """Deflection under the wheels, rows left wheels then right wheels."""
        shapes = np.sin(np.outer(positions, self.wave_number))
        rail = np.hstack([shapes * self.deflection[0], shapes * self.deflection[1]])
        rows = np.zeros((2 * len(positions), self.stiffness.shape[0]))
        n = rail.shape[1]
        rows[: len(positions), :n] = rail
        rows[len(positions) :, n : 2 * n] = rail
        return rows


def dense_track(p: TrackParameters) -> DenseTrack:
    """Assemble the track without any of the product's shortcuts (no residual compliance)."""
    rail, plate = vertical_modes(p.rail, p.window_length), plate_modes(p)
    n_rail, n_slab, slabs = rail.omega_squared.size, plate.omega_squared.size, p.window.slab_count
    foundation, dashpot = p.support_per_area
    area_mass = p.slab.density * p.slab.thickness
    slab_k = plate.omega_squared + foundation / area_mass
    slab_c = 2 * p.slab.damping_ratio * np.sqrt(plate.omega_squared) + dashpot / area_mass
    size = 2 * n_rail + slabs * n_slab
    stiffness = np.diag(np.concatenate([rail.omega_squared.ravel()] * 2 + [slab_k] * slabs))
    damping = np.diag(np.concatenate([np.zeros(2 * n_rail)] + [slab_c] * slabs))
    for i in range(p.fastener_count):
        x = (i + 0.5) * p.fastener.spacing
        slab, seat = divmod(i, p.fastener.count_per_slab)
        shapes = np.sin(rail.wave_number * x)
        along = (seat + 0.5) * p.fastener.spacing - 0.5 * p.pitch
        for side in (0, 1):
            row = np.zeros(size)
            row[side * n_rail : (side + 1) * n_rail] = (rail.deflection * shapes).ravel()
            across = (side - 0.5) * p.contact.rolling_circle_distance
            first = 2 * n_rail + slab * n_slab
            row[first : first + n_slab] = -plate.shapes(np.array([along]), np.array([across]))[:, 0]
            stiffness += p.fastener.vertical_stiffness * np.outer(row, row)
            damping += p.fastener.vertical_damping * np.outer(row, row)
    return DenseTrack(damping, stiffness, rail.wave_number, rail.deflection)


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
