"""Room for arrays that a compiled function makes and drops: made once, not in every step."""

from typing import NamedTuple

import numpy as np

from slab_track.halves import half_size


class Room(NamedTuple):
    """Arrays whose contents no function leaves to another one.

    Attributes
    ----------
    waves, more_waves
        Amplitudes of the waves, (4, N) and (2, N).
    halves
        At the fasteners or sums of waves, in halves, (2, h).
    taken
        Sums of waves in two directions, (2, 2h).
    fasteners, slabs
        At all fasteners, (P,), and of all slabs' modes, (S n,) for the class with most.
    forces
        Of the wheels in two directions, (2, w).
    """

    waves: np.ndarray
    more_waves: np.ndarray
    halves: np.ndarray
    taken: np.ndarray
    fasteners: np.ndarray
    slabs: np.ndarray
    forces: np.ndarray

    @classmethod
    def empty(cls, wheels: int, waves: int, fasteners: int, slab_modes: int) -> "Room":
        """Return room for wheelsets, waves, fasteners and modes of all slabs."""
        half = half_size(fasteners)
        return cls(
            waves=np.empty((4, waves)),
            more_waves=np.empty((2, waves)),
            halves=np.empty((2, half)),
            taken=np.empty((2, 2 * half)),
            fasteners=np.empty(fasteners),
            slabs=np.empty(slab_modes),
            forces=np.empty((2, wheels)),
        )
