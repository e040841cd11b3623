r"""The rail as a Timoshenko beam in modal coordinates, eqs. (2)-(6) of the article.

With hinged ends the shapes are :math:`\sin(k\pi x/l)` for the deflection and
:math:`\cos(k\pi x/l)` for the rotation; for every wave number k the two
equations (6a), (6b) are a pair of coupled oscillators. They are uncoupled here
once and for all: the bending and the shear branch, two plain oscillators.
"""

from typing import NamedTuple

import numpy as np

from slab_track.parameters import Rail
from slab_track.waves import Waves, waves


class RailModes(NamedTuple):
    """Mass-normalised modes of a Timoshenko rail, hinged or closed to a ring.

    Attributes
    ----------
    wave_number
        kappa in rad/m, shape (N,).
    omega_squared
        Squared circular frequencies in rad2/s2, shape (2, N): bending, shear branch.
    deflection
        Deflection amplitude of each mode at unit modal coordinate, kg^-1/2, shape (2, N).
    rotation
        Rotation amplitude of each mode at unit modal coordinate, shape (2, N).
    waves
        The waves along the rail.
    """

    wave_number: np.ndarray
    omega_squared: np.ndarray
    deflection: np.ndarray
    rotation: np.ndarray
    waves: Waves


def timoshenko_modes(
    along: Waves,
    *,
    bending_stiffness: float,
    shear_stiffness: float,
    mass_per_length: float,
    rotary_inertia: float,
) -> RailModes:
    """Return the modes of a Timoshenko beam.

    Parameters
    ----------
    along
        Waves of the deflection.
    bending_stiffness, shear_stiffness
        E I in N.m2 and kappa G A in N.
    mass_per_length, rotary_inertia
        rho A in kg/m and rho I in kg.m.
    """
    kappa, square = along.wave_number, along.mean_square * along.length
    # Eqs. (6a), (6b): symmetric 2x2 stiffness in the mass-normalised (q, w).
    k11 = shear_stiffness * kappa**2 / mass_per_length
    k22 = (shear_stiffness + bending_stiffness * kappa**2) / rotary_inertia
    k12 = -shear_stiffness * kappa / np.sqrt(mass_per_length * rotary_inertia)
    mean, half = 0.5 * (k11 + k22), np.hypot(0.5 * (k11 - k22), k12)
    upper = mean + half
    # The product of the roots is the determinant; the difference would cancel.
    lower = bending_stiffness * shear_stiffness * kappa**4 / (mass_per_length * rotary_inertia)
    lower /= upper
    angle = 0.5 * np.arctan2(2.0 * k12, k11 - k22)
    cosine, sine = np.cos(angle), np.sin(angle)
    # (cos, sin) belongs to the upper root, (-sin, cos) to the lower one.
    scale_z = 1.0 / np.sqrt(mass_per_length * square)
    scale_psi = 1.0 / np.sqrt(rotary_inertia * square)
    return RailModes(
        wave_number=kappa,
        omega_squared=np.stack([lower, upper]),
        deflection=scale_z * np.stack([-sine, cosine]),
        rotation=scale_psi * np.stack([cosine, sine]),
        waves=along,
    )


def vertical_modes(rail: Rail, length: float, *, ring: bool = False) -> RailModes:
    """Return the vertical bending modes of a rail of ``length`` metres."""
    return timoshenko_modes(
        waves(length, rail.modes_over(length), ring=ring),
        bending_stiffness=rail.youngs_modulus * rail.vertical_second_moment,
        shear_stiffness=rail.vertical_shear_coefficient * rail.shear_modulus * rail.area,
        mass_per_length=rail.density * rail.area,
        rotary_inertia=rail.density * rail.vertical_second_moment,
    )


def static_flexibility(rail: Rail, length: float, wave_number: np.ndarray) -> np.ndarray:
    """Return the static deflection amplitude per unit wave force, m/N, for wave numbers > 0.

    Both branches together: 2/l (1/(E I kappa^4) + 1/(kappa_z G A kappa^2)), the terms
    of the Timoshenko beam's static Green's function.
    """
    bending = rail.youngs_modulus * rail.vertical_second_moment
    shear = rail.vertical_shear_coefficient * rail.shear_modulus * rail.area
    return 2.0 / length * (1.0 / (bending * wave_number**4) + 1.0 / (shear * wave_number**2))
