"""What a track wheel_outputs after a step."""

from typing import NamedTuple

import numpy as np

from slab_track.state import TrackState


class TrackOutputs(NamedTuple):
    """What the track wheel_outputs; arrays of wheels have shape (wheelsets, 2), left first.

    Attributes
    ----------
    state
        The state that wheel_outputs; nothing is computed before it is asked for.
    contact
        Contact forces and moments on the wheelsets, shape (wheelsets, 6), N and N.m.
    wheel_outputs
        All of the following and more, (WHEEL_OUTPUTS, wheelsets, 2), as in
        :class:`slab_track.state.TrackState`.
    normal_force, longitudinal_creep_force, lateral_creep_force
        Sums over the patches of a wheel, N.
    penetration, contact_angle
        Of the patch that carries most, m and rad.
    rail_deflection, rail_lateral, rail_roll
        Of the rail's axis vertically, of its head laterally (m), and its rotation (rad).
    """

    state: TrackState

    @property
    def contact(self) -> np.ndarray:
        """Contact forces and moments on the wheelsets, N and N.m, (wheelsets, 6)."""
        return self.state.contact

    @property
    def wheel_outputs(self) -> np.ndarray:
        """All of the following and more, (WHEEL_OUTPUTS, wheelsets, 2)."""
        return self.state.wheel_outputs

    @property
    def normal_force(self) -> np.ndarray:
        """Normal force of each wheel, N, (wheelsets, 2); positive in compression."""
        return self.wheel_outputs[0]

    @property
    def longitudinal_creep_force(self) -> np.ndarray:
        """Longitudinal creep force of each wheel, N, (wheelsets, 2)."""
        return self.wheel_outputs[1]

    @property
    def lateral_creep_force(self) -> np.ndarray:
        """Lateral creep force of each wheel, N, (wheelsets, 2)."""
        return self.wheel_outputs[2]

    @property
    def penetration(self) -> np.ndarray:
        """Penetration of the patch that carries most, m, (wheelsets, 2)."""
        return self.wheel_outputs[3]

    @property
    def contact_angle(self) -> np.ndarray:
        """Contact angle of the patch that carries most, rad, (wheelsets, 2)."""
        return self.wheel_outputs[4]

    @property
    def rail_deflection(self) -> np.ndarray:
        """Deflection of the rail's axis under each wheel, m, (wheelsets, 2)."""
        return self.wheel_outputs[5]

    @property
    def rail_lateral(self) -> np.ndarray:
        """Lateral displacement of the rail's head under each wheel, m, (wheelsets, 2)."""
        return self.wheel_outputs[6]

    @property
    def rail_roll(self) -> np.ndarray:
        """Rotation of the rail under each wheel, rad, (wheelsets, 2)."""
        return self.wheel_outputs[7]
