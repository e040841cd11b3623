"""Lateral bending and torsion of one rail as plain dense matrices, for tests of the compiled step.

The coordinates are the amplitudes of the waves themselves: deflection (N), rotation of the
section (N), roll (N), with the mass and stiffness of the beam's energies. Nothing is
uncoupled, folded or reduced.
"""

from typing import NamedTuple

import numpy as np
from slab_track.lateral import LateralTrack
from slab_track.parameters import TrackParameters


class DenseLateral(NamedTuple):
    """One rail on its fasteners: M x'' + C x' + K x = f."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    wave_number: np.ndarray

    def rows(self, x: float) -> np.ndarray:
        """Displacement and roll of the axis at ``x`` m from the window's start, (2, 3N)."""
        shape, none = np.sin(self.wave_number * x), np.zeros(self.wave_number.size)
        return np.array([np.r_[shape, none, none], np.r_[none, none, shape]])

    def energy(self, value: np.ndarray, rate: np.ndarray) -> float:
        """Kinetic and elastic energy, J."""
        return float(0.5 * (rate @ self.mass @ rate + value @ self.stiffness @ value))

    def amplitudes(self, lateral: LateralTrack, coordinates: np.ndarray) -> np.ndarray:
        """Amplitudes (3N,) of the product's modal coordinates (3, N)."""
        q = coordinates
        return np.concatenate(
            [
                np.sum(lateral.bending.deflection * q[:2], axis=0),
                np.sum(lateral.bending.rotation * q[:2], axis=0),
                lateral.torsion_amplitude * q[2],
            ]
        )


def dense_lateral(p: TrackParameters) -> DenseLateral:
    """Assemble one rail from the energies of beam, torsion bar and fasteners."""
    rail, half = p.rail, 0.5 * p.window_length
    k = np.pi / p.window_length * np.arange(1, rail.mode_count + 1)
    bending = rail.youngs_modulus * rail.lateral_second_moment
    shear = rail.lateral_shear_coefficient * rail.shear_modulus * rail.area
    per_length = np.array([rail.area, rail.lateral_second_moment, rail.polar_second_moment])
    mass = half * np.diag(np.repeat(rail.density * per_length, k.size))
    none = np.zeros((k.size, k.size))
    # Energies: shear (y' - psi)^2 with y' and psi both cosines, bending psi'^2, torsion phi'^2.
    stiffness = half * np.block(
        [
            [np.diag(shear * k**2), np.diag(-shear * k), none],
            [np.diag(-shear * k), np.diag(shear + bending * k**2), none],
            [none, none, np.diag(rail.torsional_stiffness * k**2)],
        ]
    )
    damping = np.zeros_like(stiffness)
    f, roll = p.fastener, rail.base_width**2 / 4.0
    for i in range(p.fastener_count):
        shape, zero = np.sin(k * (i + 0.5) * f.spacing), np.zeros(k.size)
        foot = np.concatenate([shape, zero, -rail.axis_height * shape])
        turn = np.concatenate([zero, zero, shape])
        for matrix, lateral, vertical in (
            (stiffness, f.lateral_stiffness, f.vertical_stiffness),
            (damping, f.lateral_damping, f.vertical_damping),
        ):
            matrix += lateral * np.outer(foot, foot) + vertical * roll * np.outer(turn, turn)
    return DenseLateral(mass, damping, stiffness, k)
