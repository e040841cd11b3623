r"""The slide of the window: eqs. (8)-(11) of the article as constant matrices.

When the window moves on by :math:`L_m`, one pitch or several, the new coordinates must
reproduce the old field, :math:`\Phi Q = D` (eq. (10)), where D is the old field
at the sample points moved by :math:`L_m` and zero beyond the old front end
(eq. (9)). D is linear in the old coordinates, so a slide is one matrix for the
deflection (sines) and one for the rotation (cosines), applied to displacement,
velocity and acceleration alike.

``least_squares`` is eq. (11). For M to infinity it becomes the ``projection``

.. math:: Q_j = \frac2l \int_0^{l-L_m} \varphi_j(x)\, u(x + L_m)\,dx,

which a uniform rail's mass weights too; its integrals have closed forms. ``constrained`` adds the
smallest change, in the mass norm, that gives the rails under the wheels their old motion
back: :math:`\Delta q = \Phi_w^T(\Phi_w\Phi_w^T)^{-1} r` for the misfits r at the wheels.
``triangular`` is the square eq. (10) solved by its LU factors, as in the
article's Fig. 5 (a).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg

from slab_track.rail import RailModes

_SEEN_EVERY = 0.25
"""Distance of the points at which the slide's residual is looked for, m."""

_ONE_THREAD = 250_000
"""Products up to which OpenBLAS starts no second thread: waiting for it would cost more than it
does, and the sums would depend on the number of threads."""

_FINE = 16
"""Sample points per wave number that stand for an integral over a tapered field."""


class SlideOperator(NamedTuple):
    """Matrices that move the modal series back by one slide.

    Attributes
    ----------
    deflection, rotation
        New wave amplitudes from old ones, both of shape (N, N).
    before, after
        Shapes of the deflection at points of the common part of the old and the new window,
        (N, points), in the old and in the new window.
    ring
        True if slabs and fasteners that leave at the rear come back at the front.
    shift
        Way of the window, m.
    constrained
        True if the rails under the wheels keep their motion exactly.
    """

    deflection: np.ndarray
    rotation: np.ndarray
    before: np.ndarray
    after: np.ndarray
    ring: bool
    shift: float
    constrained: bool

    def rows(self, values: np.ndarray, count: int) -> np.ndarray:
        """Move what belongs to slabs or fasteners back by ``count`` rows; new ones are at rest."""
        moved = np.empty_like(values)
        moved[:-count] = values[count:]
        moved[-count:] = values[:count] if self.ring else 0.0
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
    taper: float = 0.0,
    points: np.ndarray | None = None,
) -> SlideOperator:
    """Compute the operator for a slide by ``shift`` metres.

    Parameters
    ----------
    sample_count
        Sample points M; without effect for ``projection``.
    solver
        "least_squares", "projection", "constrained" or "triangular". A ring needs none.
    taper
        Length at the rear end over which the moved field falls to nothing, m.
    points
        Other sample points than :func:`sample_points`, (M,), m.
    """
    common = np.linspace(shift, length, max(2, round((length - shift) / _SEEN_EVERY)))
    before, after = rail.waves.shapes(common), rail.waves.shapes(common - shift)
    if rail.waves.ring:
        turn = _rotation(rail.wave_number, shift)
        return SlideOperator(turn, turn, before, after, ring=True, shift=shift, constrained=False)
    if solver == "projection" and taper == 0.0:
        deflection = _projection(rail.wave_number, length, shift, sign=-1.0)
        rotation = _projection(rail.wave_number, length, shift, sign=1.0)
    else:
        if points is None:
            fine = _FINE * rail.wave_number.size
            points = sample_points(length, fine if solver == "projection" else sample_count)
        kept = np.where(points + shift <= length, _rise(points, taper), 0.0)[:, None]
        solve = scipy.linalg.solve if solver == "triangular" else _least_squares
        deflection, rotation = (
            solve(shapes(points).T, kept * shapes(points + shift).T)
            for shapes in (rail.waves.shapes, rail.waves.rotation_shapes)
        )
    return SlideOperator(
        deflection=deflection,
        rotation=rotation,
        before=before,
        after=after,
        ring=False,
        shift=shift,
        constrained=solver == "constrained",
    )


def _rise(points: np.ndarray, taper: float) -> np.ndarray:
    """Return a smooth rise from 0 at the rear end to 1 at ``taper`` metres."""
    if taper == 0.0:
        return np.ones_like(points)
    return np.sin(0.5 * np.pi * np.clip(points / taper, 0.0, 1.0)) ** 2


def _projection(wave_number: np.ndarray, length: float, shift: float, sign: float) -> np.ndarray:
    """Return 2/l times the integral of shape j at x and shape k at x + shift, shape (N, N).

    Of sines with ``sign`` -1, of cosines with 1.
    """
    new, old, end = wave_number[:, None], wave_number[None, :], length - shift

    def integral(wave, phase):
        """Of cos(wave x + phase) from 0 to the end: by its mean phase, for wave = 0 too."""
        return end * np.cos(0.5 * wave * end + phase) * np.sinc(0.5 * wave * end / np.pi)

    phase = old * shift
    return (integral(new - old, -phase) + sign * integral(new + old, phase)) / length


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


def slide_rails(
    operator: SlideOperator,
    rails: Sequence[tuple[RailModes, np.ndarray]],
    waves: Sequence[np.ndarray] = (),
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Move modal coordinates of rails by one slide, all with one product.

    The branches combine to wave amplitudes of deflection and rotation, these
    slide, and separate again. The two participation vectors are orthogonal, so
    the way back is a projection.

    Parameters
    ----------
    rails
        Modes and coordinates (..., 2, N), whose modes have the same waves.
    waves
        Amplitudes (..., N) of fields that have one branch only.

    Returns
    -------
    rails, waves
        The same after the slide.
    """
    deflections = [both_branches(modes.deflection, values) for modes, values in rails]
    rotations = [both_branches(modes.rotation, values) for modes, values in rails]
    z = _moved(operator.deflection, [*deflections, *waves])
    psi = _moved(operator.rotation, rotations)
    moved = []
    for (modes, _), deflection, rotation in zip(rails, z, psi, strict=False):
        # Rows of (deflection, rotation) scaled to an orthogonal 2x2 matrix per wave number.
        back_z = modes.deflection / (modes.deflection[0] ** 2 + modes.deflection[1] ** 2)
        back_psi = modes.rotation / (modes.rotation[0] ** 2 + modes.rotation[1] ** 2)
        moved.append(back_z * deflection[..., None, :] + back_psi * rotation[..., None, :])
    return moved, z[len(rails) :]


def both_branches(weight: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return wave amplitudes (..., N) of coordinates (..., 2, N) with weights (2, N)."""
    return weight[0] * values[..., 0, :] + weight[1] * values[..., 1, :]


def _moved(matrix: np.ndarray, fields: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return ``matrix`` times each row of the fields (..., N), read once for all of them."""
    count = matrix.shape[0]
    old = np.concatenate([field.reshape(-1, count) for field in fields])
    rows, width = np.empty_like(old), max(1, _ONE_THREAD // old.size)
    for first in range(0, count, width):
        rows[:, first : first + width] = old @ matrix[first : first + width].T
    ends = np.cumsum([field.size // count for field in fields])[:-1]
    return [
        part.reshape(field.shape) for part, field in zip(np.split(rows, ends), fields, strict=True)
    ]


def slide_rail(rail: RailModes, operator: SlideOperator, coordinates: np.ndarray) -> np.ndarray:
    """Move modal coordinates (..., 2, N) of one rail by one slide, as :func:`slide_rails`."""
    return slide_rails(operator, [(rail, coordinates)])[0][0]


def keep_under_wheels(
    rail: RailModes,
    weight: np.ndarray,
    places: np.ndarray,
    shift: float,
    old: np.ndarray,
    new: np.ndarray,
) -> np.ndarray:
    """Return moved coordinates that give the rail under the wheels its old motion.

    Parameters
    ----------
    weight
        Deflection per unit coordinate that the wheels feel, (2, N).
    places
        Of the wheels in the old window, (w,), m.
    old, new
        Coordinates before and after the slide, (..., 2, N).
    """
    there = rail.waves.shapes(places - shift)
    wanted = np.sum(weight * old, axis=-2) @ rail.waves.shapes(places)
    misfit = wanted - np.sum(weight * new, axis=-2) @ there
    compliance = (there.T * np.sum(weight**2, axis=0)) @ there
    change = np.linalg.solve(compliance, misfit.reshape(-1, places.size).T)
    return new + weight * (there @ change).T.reshape(*misfit.shape[:-1], 1, -1)
