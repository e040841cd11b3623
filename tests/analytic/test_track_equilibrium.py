"""Equilibrium of wheelsets on profiles, flanges included; what is said beside the rails."""

import numpy as np
import pytest
from pair import WholeVehicle, run_staggered
from rail_vehicle import VehicleModel, VehicleParameters
from slab_track import TrackModel, TrackParameters
from slab_track.equilibrium import rails_at_rest
from slab_track.errors import TrackError
from slab_track.irregularity import IrregularityParameters
from slab_track.irregularity.parameters import CosineParameters

LOAD, SPEED = 69.2e3, 300.0 / 3.6
SOLUTION = TrackModel(TrackParameters(static_wheel_load=LOAD))


def at_rest(lateral):
    motion = np.zeros((4, 11))
    motion[:, 0], motion[:, 1] = SOLUTION.default_positions(), lateral
    motion[:, 5], motion[:, 10] = SPEED, -SPEED / 0.46
    state = SOLUTION.initial_state(motion)
    motion[:, 2] = state.static_heights
    return state, SOLUTION.with_motion(state, motion)


@pytest.mark.parametrize("lateral", [0.0, 3e-3, 8.5e-3, 11e-3])
def test_every_wheelset_carries_its_load_on_rails_in_equilibrium(lateral):
    """From the tread to full flange contact: loads, and rails displaced by their very forces."""
    state, resting = at_rest(lateral)
    forces = SOLUTION.outputs(resting).contact
    np.testing.assert_allclose(forces[:, 2], -2.0 * LOAD, rtol=1e-6)
    positions = SOLUTION.default_positions() - state.window_start
    rails = rails_at_rest(
        SOLUTION.linear, SOLUTION.lateral, positions, resting.wheels.rail_force
    ).motion
    np.testing.assert_allclose(state.wheels.rail[:, :, :3], rails[:, :, :3], rtol=0, atol=1e-9)
    if lateral > 8e-3:
        angle = SOLUTION.outputs(resting).contact_angle[:, 1]
        assert np.all(np.abs(angle) > 0.15)  # the right wheels' flange roots


def test_mirrored_wheelsets_rest_in_mirrored_equilibrium():
    _, right = at_rest(9e-3)
    _, left = at_rest(-9e-3)
    a, b = SOLUTION.outputs(right), SOLUTION.outputs(left)
    np.testing.assert_allclose(a.normal_force, b.normal_force[:, ::-1], rtol=1e-6)
    np.testing.assert_allclose(a.contact[:, 1], -b.contact[:, 1], rtol=1e-6)


def test_wheelsets_beside_the_rails_are_refused():
    with pytest.raises(TrackError, match=r"beside its rails.*22 mm or 40 mrad.*rail\.gauge"):
        at_rest(30e-3)


def test_a_derailment_is_told_with_time_and_place():
    """40 mm sideways over 6 m at 300 km/h: no vehicle follows that."""
    kink = CosineParameters(side="both", direction="lateral", length=6.0, position=15.0, depth=0.04)
    track = TrackModel(TrackParameters(irregularity=IrregularityParameters(cosine=kink)))
    vehicle = WholeVehicle(VehicleModel(VehicleParameters(speed=SPEED)))
    message = r"at t = 0\.1\d+ s, wheelset 1 at 1[345]\.\d+ m.*left its rail.*derailment"
    with pytest.raises(TrackError, match=message):
        run_staggered(track, vehicle, distance=60.0, speed=SPEED, step=1e-4)
