r"""The slide of the window: eqs. (8)-(11) of the article as constant matrices.

When the window moves on by one pitch :math:`L_m`, the new coordinates must
reproduce the old field, :math:`\Phi Q = D` (eq. (10)), where D is the old field
at the sample points moved by :math:`L_m` and zero beyond the old front end
(eq. (9)). D is linear in the old coordinates, so a slide is one matrix for the
deflection (sines) and one for the rotation (cosines), applied to displacement,
velocity and acceleration alike.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg

from slab_track.rail import RailModes


class SlideOperator(NamedTuple):
    """Matrices that move the modal series back by one pitch.

    Attributes
    ----------
    deflection, rotation
        New wave amplitudes from old ones, both of shape (N, N).
    before, after
        Shapes of the deflection at points of the common part of the old and the new window,
        (N, points), in the old and in the new window.
    ring
        True if slabs and fasteners that leave at the rear come back at the front.
    """

    deflection: np.ndarray
    rotation: np.ndarray
    before: np.ndarray
    after: np.ndarray
    ring: bool

    def rows(self, values: np.ndarray, count: int) -> np.ndarray:
        """Move what belongs to slabs or fasteners back by ``count`` rows; new ones are at rest."""
        moved = np.roll(values, -count, axis=0)
        if not self.ring:
            moved[-count:] = 0.0
        return moved


def sample_points(length: float, count: int) -> np.ndarray:
    """Return the sample points of eq. (10), at the middle of ``count`` equal segments.

    The hinges are not among them: there all shapes vanish, and eq. (10) is singular.
    """
    return (np.arange(count) + 0.5) * length / count


def slide_operator(
    rail: RailModes,
    *,
    length: float,
    shift: float,
    sample_count: int,
    solver: str,
    points: np.ndarray | None = None,
) -> SlideOperator:
    """Compute the operator for a slide by ``shift`` metres.

    ``solver`` is "least_squares", eq. (11), or "triangular": the LU factors of the
    square eq. (10), as the article's Fig. 5(a). A ring needs neither. ``points`` are other
    sample points than :func:`sample_points`, (M,), m.
    """
    common = np.linspace(shift, length, max(2, round((length - shift) / (0.05 * shift))))
    before, after = rail.waves.shapes(common), rail.waves.shapes(common - shift)
    if rail.waves.ring:
        turn = _rotation(rail.wave_number, shift)
        return SlideOperator(turn, turn, before, after, ring=True)
    if points is None:
        points = sample_points(length, sample_count)
    inside = (points + shift <= length)[:, None]

    def matrix(shapes) -> np.ndarray:
        phi = shapes(points).T
        target = np.where(inside, shapes(points + shift).T, 0.0)
        if solver == "triangular":
            return scipy.linalg.solve(phi, target)
        return _least_squares(phi, target)

    return SlideOperator(
        deflection=matrix(rail.waves.shapes),
        rotation=matrix(rail.waves.rotation_shapes),
        before=before,
        after=after,
        ring=False,
    )


def _rotation(wave_number: np.ndarray, shift: float) -> np.ndarray:
    r"""Turn constant, cosines and sines of a ring by ``shift``: exact.

    :math:`\cos\kappa(x+L)` and :math:`\sin\kappa(x+L)` by the addition theorems; the
    rotations' shapes, -sin and cos, turn alike.
    """
    turn = np.zeros((wave_number.size, wave_number.size))
    turn[0, 0] = 1.0
    row = np.arange(1, wave_number.size, 2)
    cosine, sine = np.cos(wave_number[row] * shift), np.sin(wave_number[row] * shift)
    turn[row, row] = turn[row + 1, row + 1] = cosine
    turn[row, row + 1], turn[row + 1, row] = sine, -sine
    return turn


def _least_squares(phi: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Solve eq. (11) for all right-hand sides through a QR factorisation."""
    q, r = np.linalg.qr(phi)
    return np.ascontiguousarray(scipy.linalg.solve_triangular(r, q.T @ target))


def slide_rail(rail: RailModes, operator: SlideOperator, coordinates: np.ndarray) -> np.ndarray:
    """Move modal coordinates (..., 2, N) of the rail by one pitch.

    The branches combine to wave amplitudes of deflection and rotation, these
    slide, and separate again. The two participation vectors are orthogonal, so
    the way back is a projection.
    """
    z = np.sum(rail.deflection * coordinates, axis=-2) @ operator.deflection.T
    psi = np.sum(rail.rotation * coordinates, axis=-2) @ operator.rotation.T
    # Rows of (deflection, rotation) scaled to an orthogonal 2x2 matrix per wave number.
    back_z = rail.deflection / np.sum(rail.deflection**2, axis=0)
    back_psi = rail.rotation / np.sum(rail.rotation**2, axis=0)
    return back_z * z[..., None, :] + back_psi * psi[..., None, :]
