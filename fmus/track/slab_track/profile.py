r"""Shapes of rails and slabs along the line, for pictures and for reading off between the wheels.

Nothing of this takes part in the steps: it is evaluated from a state when it is asked for. The
rails' deflection is that of the moving modes and of the static compliance of the waves left out,
under the wheels' forces less the fasteners':

.. math:: z(x)=\sum_k \varphi_k(x)\,q_k
          +\sum_k g_k \sin\kappa_k x\,\Big(\sum_w \sin\kappa_k x_w\,F_w
          -\sum_p \sin\kappa_k x_p\,F_p\Big)
"""

import numpy as np

from slab_track.assembly import LinearTrack, plate_modes
from slab_track.parameters import TrackParameters
from slab_track.state import FieldState, TrackState
from slab_track.waves import fold_table

_SQRT_HALF = np.sqrt(0.5)


class TrackProfile:
    """Vertical displacement of rails and slabs at places along the line.

    Parameters
    ----------
    parameters, track
        Of the model whose states are looked at.
    """

    def __init__(self, parameters: TrackParameters, track: LinearTrack) -> None:
        self._p, self._track = parameters, track
        self._plate = plate_modes(parameters)
        fine = track.residual_flexibility.size
        self._fold = fold_table(fine, track.fastener_count, ring=track.ring)

    def rails(self, state: TrackState, offsets: np.ndarray) -> np.ndarray:
        """Return the vertical displacement of the rails' axes, downwards.

        Parameters
        ----------
        state
            A state of the model.
        offsets
            Ahead of the leading wheelset, shape (points,), m.

        Returns
        -------
        ndarray
            Shape (2, points), m, left first; 0 beyond the ends of the window.
        """
        track, wheels = self._track, self._wheels(state)
        x = wheels[0] + offsets
        shapes = track.wave_shapes(x)
        classes = [
            np.sum(track.participation * field.rail[0], axis=0) @ shapes
            for field in (state.symmetric, state.antisymmetric)
        ]
        if track.residual_flexibility.size:
            classes = np.array(classes) + self._residual(state, wheels, x)
        return np.where(self._inside(x), _sides(classes), 0.0)

    def _residual(self, state: TrackState, wheels: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Share of the waves left out, by symmetry class, (2, points)."""
        track, fine = self._track, self._track.fine
        force = state.rail_force[:, :, 1]
        classes = _SQRT_HALF * np.stack([force[:, 1] + force[:, 0], force[:, 1] - force[:, 0]])
        index, sign = self._fold
        carried = (track.fastener_sines @ state.fastener_force.T)[index] * sign[:, None]
        loads = fine.shapes(wheels) @ classes.T
        amplitude = track.residual_flexibility[:, None] * (loads - carried)
        return amplitude.T @ fine.shapes(x)

    def slabs(self, state: TrackState, offsets: np.ndarray) -> np.ndarray:
        """Return the vertical displacement of the slabs' surface under the rails, downwards.

        Slabs as their modes move, without the dishing under the seats of the modes left out.
        In the gap between two slabs it is that of the nearer edge.

        Parameters
        ----------
        state
            A state of the model.
        offsets
            Ahead of the leading wheelset, shape (points,), m.

        Returns
        -------
        ndarray
            Shape (2, points), m, left first; 0 beyond the ends of the window.
        """
        p, x = self._p, self._wheels(state)[0] + offsets
        inside = self._inside(x)
        slab = np.clip(np.floor(x / p.pitch).astype(int), 0, self._track.slab_count - 1)
        half = 0.5 * p.slab_length
        along = np.clip(x - (slab + 0.5) * p.pitch, -half, half)
        across = np.full_like(along, 0.5 * p.contact.rolling_circle_distance)
        shapes = np.sqrt(2.0) * self._plate.shapes(along, across)
        classes = [
            _of_slabs(field, slab, shapes[of])
            for field, of in (
                (state.symmetric, self._plate.even),
                (state.antisymmetric, ~self._plate.even),
            )
        ]
        return np.where(inside, _sides(classes), 0.0)

    def _wheels(self, state: TrackState) -> np.ndarray:
        """Places of the wheelsets in the window, (wheelsets,), m."""
        if self._p.window.method == "moving_irregularity":
            return state.places
        return state.wheel_positions - state.window_start

    def _inside(self, x: np.ndarray) -> np.ndarray:
        return (x >= 0.0) & (x <= self._p.window_length)


def _of_slabs(field: FieldState, slab: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    return np.einsum("pn,np->p", field.slab[0][slab], shapes)


def _sides(classes) -> np.ndarray:
    """Left and right from the symmetric and the antisymmetric class, (2, points)."""
    symmetric, antisymmetric = classes
    return _SQRT_HALF * np.array([symmetric - antisymmetric, symmetric + antisymmetric])
