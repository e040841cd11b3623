r"""The two branches of a Timoshenko rail, and the waves of deflection and rotation they make up.

A wave of a rail has two coordinates, q of its bending branch and q of its shear branch, with
the deflection :math:`z = d_0 q_0 + d_1 q_1` and the rotation
:math:`\psi = r_0 q_0 + r_1 q_1`. The modes are orthogonal with the masses of both: the columns
of (d, r), scaled, make an orthogonal 2 x 2 matrix. So the way back is its transpose:
:math:`q_i = d_i/|d|^2\, z + r_i/|r|^2\, \psi`.
"""

from typing import NamedTuple

import numpy as np

from slab_track.compiled import stream
from slab_track.rail import RailModes


class Branches(NamedTuple):
    """Weights between a rail's coordinates and its waves.

    Attributes
    ----------
    deflection, rotation
        Amplitude per unit coordinate, (2, N).
    from_deflection, from_rotation
        Coordinate per unit amplitude, (2, N).
    """

    deflection: np.ndarray
    rotation: np.ndarray
    from_deflection: np.ndarray
    from_rotation: np.ndarray


def make_branches(modes: RailModes) -> Branches:
    """Return the weights of a rail."""
    z, psi = modes.deflection, modes.rotation
    return Branches(z, psi, z / np.sum(z**2, axis=0), psi / np.sum(psi**2, axis=0))


@stream
def amplitudes(weight, values, out):
    """Fill in wave amplitudes (N,) of coordinates ``values`` (2 or more, N); ``weight`` (2, N)."""
    for k in range(out.size):
        out[k] = weight[0, k] * values[0, k] + weight[1, k] * values[1, k]


@stream
def separate(branches, deflection, rotation, out):
    """Fill in the coordinates (2 or more, N) of waves ``deflection`` and ``rotation`` (N,)."""
    to_z, to_psi = branches.from_deflection, branches.from_rotation
    for branch in range(2):
        for k in range(deflection.size):
            out[branch, k] = to_z[branch, k] * deflection[k] + to_psi[branch, k] * rotation[k]
