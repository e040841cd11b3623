r"""Harmonic response of one rail in lateral bending and torsion.

The system is that of :mod:`slab_track.lateral`: foot motion :math:`u = T q` with
q = (y, phi) and :math:`T = ((1, -h_f), (0, 1))`, fasteners :math:`p = G(s) u` with
:math:`G = \mathrm{diag}(k + s c)`. Waves that look different at the fasteners do not couple;
for each of the P folded ones, with A the diagonal compliance of its modes,

.. math:: K(s) = T^T (I + G T A T^T)^{-1} G T

is what the fasteners hold it with. In the time domain the compliance of the modes left out
acts under its own wheel only, and so it does here: at receivers that coincide with a source.
"""

import numpy as np

from slab_track.frequency.vertical import check_places, modal_weight
from slab_track.lateral import LateralTrack

COINCIDENT = 1e-9
"""Distance in m up to which a receiver is taken to be where a source is."""


class LateralResponse:
    """Lateral and roll motion of a rail's axis between fixed places.

    Parameters
    ----------
    track
        The rail that the time domain uses as well.
    sources, receivers
        Places of forces and motions, m from the window's start, shapes (w,) and (x,).
    """

    def __init__(self, track: LateralTrack, sources: np.ndarray, receivers: np.ndarray) -> None:
        check_places(track.length, sources=sources, receivers=receivers)
        self.track = track
        self._sources = track.bending.waves.shapes(sources)
        self._receivers = track.bending.waves.shapes(receivers)
        self._same = np.abs(np.subtract.outer(receivers, sources)) < COINCIDENT

    def solve(self, s: complex) -> np.ndarray:
        """Return lateral displacement and roll per unit force and moment on the axis.

        Shape (receivers, sources, 2, 2), complex: motion (m, rad), load (N, N.m).
        """
        track = self.track
        bending, torsion = track.bending, track.torsion_amplitude
        response = np.stack(
            [
                np.sum(bending.deflection**2 * modal_weight(bending.omega_squared, s), axis=0),
                torsion**2 * modal_weight(track.torsion_omega_squared, s),
            ]
        )
        held = self._held(response, s)
        result = np.zeros((*self._same.shape, 2, 2), dtype=complex)
        sources = [self._folded(r[:, None] * self._sources) for r in response]
        receivers = [self._folded(r[:, None] * self._receivers) for r in response]
        for i in (0, 1):
            free = self._receivers.T @ (response[i][:, None] * self._sources)
            result[:, :, i, i] = free + self._same * track.residual[i]
            for j in (0, 1):
                result[:, :, i, j] -= receivers[i].T @ (held[:, i, j, None] * sources[j])
        return result

    def _held(self, response: np.ndarray, s: complex) -> np.ndarray:
        """K of every folded wave, times the sum of its squares at the fasteners, (P, 2, 2)."""
        track = self.track
        weighted = response * track.fold_sign**2
        compliance = np.zeros((track.class_weight.size, 2, 2), dtype=complex)
        for i in (0, 1):
            np.add.at(compliance[:, i, i], track.fold_index, weighted[i])
        compliance *= track.class_weight[:, None, None]
        foot = np.array([[1.0, -track.foot], [0.0, 1.0]])
        gain = np.diag(track.stiffness + s * track.damping)
        system = np.eye(2) + gain @ foot @ compliance @ foot.T
        return track.class_weight[:, None, None] * (foot.T @ np.linalg.solve(system, gain @ foot))

    def _folded(self, amplitudes: np.ndarray) -> np.ndarray:
        """Sum waves (N, x) that look alike at the fasteners, (P, x)."""
        folded = np.zeros((self.track.class_weight.size, amplitudes.shape[1]), amplitudes.dtype)
        np.add.at(folded, self.track.fold_index, self.track.fold_sign[:, None] * amplitudes)
        return folded
