r"""The two branches of a Timoshenko rail, and the waves of deflection and rotation they make up.

A wave of a rail has two coordinates, q of its bending branch and q of its shear branch, with
the deflection :math:`z = d_0 q_0 + d_1 q_1` and the rotation
:math:`\psi = r_0 q_0 + r_1 q_1`. The modes are orthogonal with the masses of both: the columns
of (d, r), scaled, make an orthogonal 2 x 2 matrix. So the way back is its transpose:
:math:`q_i = d_i/|d|^2\, z + r_i/|r|^2\, \psi`.
"""

import numpy as np

from slab_track.kernels.shift import Branches
from slab_track.rail import RailModes


def make_branches(modes: RailModes) -> Branches:
    """Return the weights of a rail."""
    z, psi = modes.deflection, modes.rotation
    return Branches(z, psi, z / np.sum(z**2, axis=0), psi / np.sum(psi**2, axis=0))
