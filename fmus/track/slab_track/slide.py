r"""The slide of the window: eqs. (8)-(11) of the article.

When the window moves on by :math:`L_m`, one pitch or several, the new coordinates must
reproduce the old field, :math:`\Phi Q = D` (eq. (10)), where D is the old field
at the sample points moved by :math:`L_m` and zero beyond the old front end
(eq. (9)). D is linear in the old coordinates, so a slide is one constant linear map for the
deflection (sines) and one for the rotation (cosines), applied to displacement,
velocity and acceleration alike.

``least_squares`` is eq. (11). At the middle of M > N equal segments the shapes are orthogonal,
:math:`\Phi^T\Phi = \tfrac M2`, so its solution is :math:`Q = \tfrac2M\Phi^T D`; and if
:math:`L_m` is a whole number of segments, D is the old field's own samples: a discrete sine (or
cosine) transform there, and one back (:class:`BySamples`). Otherwise it is a matrix
(:class:`ByMatrix`). For M to infinity it becomes the ``projection``

.. math:: Q_j = \frac2l \int_0^{l-L_m} \varphi_j(x)\, u(x + L_m)\,dx,

which a uniform rail's mass weights too; its integrals have closed forms. ``constrained`` adds the
smallest change, in the mass norm, that gives the rails under the wheels their old motion
back: :math:`\Delta q = \Phi_w^T(\Phi_w\Phi_w^T)^{-1} r` for the misfits r at the wheels.
``triangular`` is the square eq. (10) solved by its LU factors, as in the
article's Fig. 5 (a).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.fft
import scipy.linalg

from slab_track.branches import make_branches
from slab_track.rail import RailModes

_ONE_THREAD = 250_000
"""Products up to which OpenBLAS starts no second thread: waiting for it would cost more than it
does, and the sums would depend on the number of threads."""

_FINE = 16
"""Sample points per wave number that stand for an integral over a tapered field."""

_WHOLE = 1e-9
"""Segments by which a slide may miss a whole number of them, from rounding."""


class ByMatrix(NamedTuple):
    """A slide as a constant matrix, (N, N)."""

    matrix: np.ndarray

    @property
    def room(self) -> tuple[int, int]:
        """Length of the rows that :meth:`move` takes, and where in them the waves begin."""
        return self.matrix.shape[0], 0

    def move(self, rows: np.ndarray) -> np.ndarray:
        """Return wave amplitudes (rows, N) after the slide."""
        moved, count = np.empty_like(rows), self.matrix.shape[0]
        width = max(1, _ONE_THREAD // rows.size)
        for first in range(0, count, width):
            moved[:, first : first + width] = rows @ self.matrix[first : first + width].T
        return moved

    def __call__(self, waves: np.ndarray) -> np.ndarray:
        """Return wave amplitudes (rows, N) after the slide."""
        return _moved(self, waves)


class BySamples(NamedTuple):
    """A slide as eqs. (9) and (11) say it, by a transform to the sample points and one back.

    Attributes
    ----------
    cosines
        True for the rotation, whose shapes are cosines.
    count, shift
        Sample points M at the middle of equal segments, and how many of them the window moves.
    kept
        Part of the old field that stays at the M - ``shift`` sample points it covers, over 2 M,
        (M - shift,).
    """

    cosines: bool
    count: int
    shift: int
    kept: np.ndarray

    @property
    def room(self) -> tuple[int, int]:
        """As for :class:`ByMatrix`; the cosines' transform begins with the constant."""
        return self.count, int(self.cosines)

    def move(self, rows: np.ndarray) -> np.ndarray:
        """Return wave amplitudes (rows, M), zero but for N of them, after the slide.

        They take the memory of ``rows``. Besides the N amplitudes others come about, which are
        not to be used.
        """
        transform = scipy.fft.dct if self.cosines else scipy.fft.dst
        field = transform(rows, type=3, axis=1, overwrite_x=True)  # twice its value
        moved = np.zeros_like(field)
        moved[:, : self.kept.size] = self.kept * field[:, self.shift :]
        return np.asarray(transform(moved, type=2, axis=1, overwrite_x=True))  # twice the sum

    def __call__(self, waves: np.ndarray) -> np.ndarray:
        """Return wave amplitudes (rows, N) after the slide."""
        return _moved(self, waves)


Map = ByMatrix | BySamples


def _moved(slide: Map, waves: np.ndarray) -> np.ndarray:
    length, first = slide.room
    rows, here = np.zeros((waves.shape[0], length)), slice(first, first + waves.shape[1])
    rows[:, here] = waves
    return slide.move(rows)[:, here]


class SlideOperator(NamedTuple):
    """What moves the modal series back by one slide.

    Attributes
    ----------
    deflection, rotation
        New wave amplitudes from old ones.
    ring
        True if slabs and fasteners that leave at the rear come back at the front.
    shift
        Way of the window, m.
    constrained
        True if the rails under the wheels keep their motion exactly.
    """

    deflection: Map
    rotation: Map
    ring: bool
    shift: float
    constrained: bool


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
    deflection, rotation = _maps(rail, length, shift, sample_count, solver, taper, points)
    return SlideOperator(
        deflection,
        rotation,
        ring=rail.waves.ring,
        shift=shift,
        constrained=solver == "constrained" and not rail.waves.ring,
    )


def _maps(
    rail: RailModes,
    length: float,
    shift: float,
    sample_count: int,
    solver: str,
    taper: float,
    points: np.ndarray | None,
) -> tuple[Map, Map]:
    """Return what moves deflection and rotation."""
    if rail.waves.ring:
        turn = ByMatrix(_rotation(rail.wave_number, shift))
        return turn, turn
    if solver == "projection" and taper == 0.0:
        sines = _projection(rail.wave_number, length, shift, sign=-1.0)
        cosines = _projection(rail.wave_number, length, shift, sign=1.0)
        return ByMatrix(sines), ByMatrix(cosines)
    waves = rail.wave_number.size
    count = _FINE * waves if solver == "projection" else sample_count
    segments = shift / length * count
    whole = round(segments)
    if (
        points is None
        and solver != "triangular"
        and count > waves
        and abs(segments - whole) < _WHOLE
    ):
        kept = _rise(sample_points(length, count)[: count - whole], taper) / (2 * count)
        return BySamples(False, count, whole, kept), BySamples(True, count, whole, kept)
    if points is None:
        points = sample_points(length, count)
    kept = np.where(points + shift <= length, _rise(points, taper), 0.0)[:, None]
    solve = scipy.linalg.solve if solver == "triangular" else _least_squares

    def solved(shapes: Callable[[np.ndarray], np.ndarray]) -> ByMatrix:
        return ByMatrix(solve(shapes(points).T, kept * shapes(points + shift).T))

    return solved(rail.waves.shapes), solved(rail.waves.rotation_shapes)


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


def slide_rail(rail: RailModes, operator: SlideOperator, coordinates: np.ndarray) -> np.ndarray:
    """Move modal coordinates (..., 2, N) of one rail by one slide.

    The branches combine to wave amplitudes of deflection and rotation, these slide, and separate
    again.
    """
    rows, branches = coordinates.reshape(-1, *coordinates.shape[-2:]), make_branches(rail)
    z = operator.deflection(np.sum(branches.deflection * rows, axis=1))
    psi = operator.rotation(np.sum(branches.rotation * rows, axis=1))
    moved = branches.from_deflection * z[:, None] + branches.from_rotation * psi[:, None]
    return moved.reshape(coordinates.shape)


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
