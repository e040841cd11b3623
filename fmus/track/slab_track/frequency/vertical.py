r"""Harmonic response of the vertical track: one symmetry class at one complex frequency.

With all quantities proportional to :math:`e^{st}`, the equations that the time step
integrates (:mod:`slab_track.kernels.vertical`) become algebraic. The answer of a mode to a modal
force is

.. math:: w(s) = 1/(\omega^2 + c s + s^2),

the modes left out with their static compliance. Fasteners, with
:math:`\kappa(s) = k + s c` on modal and residual compression alike, carry

.. math:: p = (\kappa^{-1} + Y + R)^{-1} (Y_w + R_w) F

with Y the modal and R the residual compliance between the fasteners (rail and slab),
:math:`Y_w, R_w` those between fasteners and places on the rail. The rail at the places x is

.. math:: z = (Y_{xw} + R_{xw}) F - (Y_x + R_x)^T p.

Only P x P systems are solved, P fasteners per rail. :math:`s = i\omega` gives receptances,
complex s eigenmodes.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from rail_quantities import ParameterError

from slab_track.assembly import LinearTrack

NEAREST_POLE = 1e-9
"""Least relative distance of s^2 from a pole of an undamped rail mode."""


class VerticalSolution(NamedTuple):
    """Response of one symmetry class to unit forces at the sources.

    Attributes
    ----------
    rail
        Deflection at the receivers, m/N, shape (receivers, sources), complex.
    fastener
        Forces in the fasteners, compression positive, shape (P, sources), complex.
    slab
        Modal coordinates of the slabs, shape (S, n, sources), complex.
    """

    rail: np.ndarray
    fastener: np.ndarray
    slab: np.ndarray


class _Places(NamedTuple):
    """Shapes at places on the rail: modes (N, x), and waves of the residual (R, x)."""

    modal: np.ndarray
    residual: np.ndarray


class VerticalResponse:
    """Response of the rails between fixed places, for any frequency and class.

    Parameters
    ----------
    track
        The linear track that the time domain uses as well.
    sources, receivers
        Places of forces and deflections, m from the window's start, shapes (w,) and (x,).

    Raises
    ------
    ParameterError
        If a place lies outside the window.
    """

    def __init__(self, track: LinearTrack, sources: np.ndarray, receivers: np.ndarray) -> None:
        self.track = track
        check_places(track.length, sources=sources, receivers=receivers)
        self._sources = _places(track, sources)
        self._receivers = _places(track, receivers)
        fasteners = (np.arange(track.fastener_count) + 0.5) * track.length / track.fastener_count
        at_fasteners = _residual_shapes(track, fasteners)
        flexibility = track.residual_flexibility[:, None]
        self._from_source = at_fasteners.T @ (flexibility * self._sources.residual)
        self._to_receiver = at_fasteners.T @ (flexibility * self._receivers.residual)
        self._direct = self._receivers.residual.T @ (flexibility * self._sources.residual)
        self._between_fasteners = [track.fastener_residual(symmetry) for symmetry in (0, 1)]

    def solve(self, s: complex, symmetry: int) -> VerticalSolution:
        """Return the response of class ``symmetry`` at the complex frequency ``s``, rad/s."""
        track, slab = self.track, self.track.slabs[symmetry]
        rail_weight = modal_weight(track.rail.omega_squared, s)
        slab_weight = 1.0 / (slab.omega_squared + slab.damping * s + s**2)
        beta = np.sum(track.participation**2 * rail_weight, axis=0)[:, None]
        matrix = _admittance(track, rail_weight, slab_weight, symmetry)
        matrix = matrix + self._between_fasteners[symmetry]
        matrix[np.diag_indices_from(matrix)] += 1.0 / fastener_stiffness(track, s)
        # Places to fasteners: the forces there per force here, and the deflections back.
        excited = self._at_fasteners(beta * self._sources.modal) + self._from_source
        felt = self._at_fasteners(beta * self._receivers.modal) + self._to_receiver
        fastener = np.linalg.solve(matrix, excited)
        free = self._receivers.modal.T @ (beta * self._sources.modal) + self._direct
        seat_forces = fastener.reshape(track.slab_count, track.seat_count, -1)
        return VerticalSolution(
            rail=free - felt.T @ fastener,
            fastener=fastener,
            slab=slab_weight[:, None] * (slab.seats @ seat_forces),
        )

    def _at_fasteners(self, amplitudes: np.ndarray) -> np.ndarray:
        """Sum waves (N, x), real or complex, at the fasteners, (P, x)."""
        return self.track.fastener_sines.T @ _apart(self.track.fold, amplitudes)


def fastener_stiffness(track: LinearTrack, s: complex) -> np.ndarray:
    """Return kappa(s) of every fastener, N/m, (P,); those near the ends may have more damping."""
    return track.stiffness + s * (track.damping + track.end_damping)


def check_places(length: float, **places: np.ndarray) -> None:
    """Raise :class:`ParameterError` for places that are not in a window of ``length`` m."""
    for name, x in places.items():
        x = np.asarray(x, dtype=float)
        outside = ~((x >= 0.0) & (x <= length))
        if x.ndim != 1 or x.size == 0 or outside.any():
            shown = float(x[outside][0]) if outside.any() else x.tolist()
            raise ParameterError(
                name,
                shown,
                f"must be a row of places from 0 to {length:g} m, the length of the window",
                "give metres from the window's start, or raise window.slab_count",
            )


def modal_weight(omega_squared: np.ndarray, s: complex) -> np.ndarray:
    """Return 1/(omega^2 + s^2) of undamped modes; real if s is purely imaginary or real.

    At an eigenfrequency of the rail alone, which is none of the track, the pole is
    passed at a relative distance of :data:`NEAREST_POLE`.
    """
    square = complex(s) ** 2
    on_axis = square.imag == 0.0
    distance = omega_squared + (square.real if on_axis else square)
    least = NEAREST_POLE * abs(square)
    return 1.0 / np.where(np.abs(distance) < least, least, distance)


def _places(track: LinearTrack, x: np.ndarray) -> _Places:
    x = np.asarray(x, dtype=float)
    return _Places(track.wave_shapes(x), _residual_shapes(track, x))


def _residual_shapes(track: LinearTrack, x: np.ndarray) -> np.ndarray:
    """Waves with static compliance at places x, (R, x)."""
    if track.residual_flexibility.size == 0:
        return np.empty((0, x.size))
    return track.fine.shapes(x)


def _admittance(
    track: LinearTrack, rail_weight: np.ndarray, slab_weight: np.ndarray, symmetry: int
) -> np.ndarray:
    """Modal compliance between the fasteners, (P, P), also for complex rail weights."""
    if np.isrealobj(rail_weight):
        return track.fastener_admittance(rail_weight, slab_weight, symmetry)
    # It is linear in the weights, and sums real rail weights only.
    real, imaginary = np.real(rail_weight), np.imag(rail_weight)
    of_rail = track.fastener_admittance(imaginary, np.zeros(slab_weight.size), symmetry)
    return track.fastener_admittance(real, slab_weight, symmetry) + 1j * of_rail


def _apart(function: Callable[[np.ndarray], np.ndarray], values: np.ndarray) -> np.ndarray:
    """Apply a real linear function to complex values."""
    if np.isrealobj(values):
        return function(values)
    return function(np.real(values)) + 1j * function(np.imag(values))
