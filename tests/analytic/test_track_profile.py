"""Shapes of rails and slabs between the wheels, against what wheels and fasteners see."""

import numpy as np
import pytest
from rail_quantities import with_values
from slab_track import TrackModel, TrackParameters
from slab_track.profile import TrackProfile

LOAD, SPEED, STEP = 69.2e3, 300.0 / 3.6, 1e-4
MODEL = TrackModel(TrackParameters(static_wheel_load=LOAD))


def rolling(model, lateral=0.0):
    """Yield states: at rest, and every four milliseconds of wheelsets at constant height."""
    motion = np.zeros((model.parameters.wheelset_count, 11))
    motion[:, 0], motion[:, 1] = model.default_positions(), lateral
    motion[:, 5], motion[:, 10] = SPEED, -SPEED / 0.46
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    state = model.with_motion(state, motion)
    yield state
    for n in range(1, 800):
        state, _ = model.step(state, motion, STEP)
        motion[:, 0] += SPEED * STEP
        if n % 40 == 0:
            yield state


def at_wheels(model, state):
    """Profile of the rails at the wheels, (wheels, 2)."""
    offsets = state.wheel_positions - state.wheel_positions[0]
    return TrackProfile(model.parameters, model.linear).rails(state, offsets).T


@pytest.mark.parametrize(
    ("settings", "lateral"),
    [
        ({}, 0.0),
        ({}, 6e-3),  # the rails carry unlike loads
        ({"rail.residual_compliance": False, "rail.mode_count": 200}, 0.0),
        ({"window.method": "moving_irregularity"}, 0.0),
    ],
)
def test_under_the_wheels_it_is_what_the_wheels_feel(settings, lateral):
    """At rest and moving, before and after a slide."""
    model = TrackModel(with_values(MODEL.parameters, settings))
    slides = 0
    for state in rolling(model, lateral):
        np.testing.assert_allclose(
            at_wheels(model, state), state.rail_deflection, rtol=2e-3, atol=1e-7
        )
        slides = state.slide_count
    assert np.abs(state.rail_deflection).min() > 5e-4
    assert (slides > 0) == (not settings.get("window.method"))
    if lateral:
        assert np.abs(np.diff(state.rail_deflection, axis=1)).max() > 1e-6


def test_rails_lie_above_the_slabs_by_what_the_fasteners_give():
    """At rest a fastener's force is its stiffness times rail less slab at its place."""
    state = next(rolling(MODEL, 6e-3))
    p, track = MODEL.parameters, MODEL.linear
    profile = TrackProfile(p, track)
    places = (np.arange(track.fastener_count) + 0.5) * p.fastener.spacing
    offsets = places + state.window_start - state.wheel_positions[0]
    compression = profile.rails(state, offsets) - profile.slabs(state, offsets)
    force = track.stiffness * compression
    expected = np.sqrt(0.5) * np.array([[1.0, -1.0], [1.0, 1.0]]) @ state.fastener_force
    loaded = np.abs(expected) > 5e3
    assert loaded.sum() > 20
    # Left out of the slabs' shape is the dishing under the seats.
    np.testing.assert_allclose(force[loaded], expected[loaded], rtol=0.01)
    assert (force[loaded] > expected[loaded]).all()
    assert profile.slabs(state, offsets).max() > 1e-6


def test_outside_of_the_window_nothing_moves():
    state = next(rolling(MODEL))
    profile = TrackProfile(MODEL.parameters, MODEL.linear)
    for of in (profile.rails, profile.slabs):
        assert not of(state, np.array([-70.0, 70.0])).any()
