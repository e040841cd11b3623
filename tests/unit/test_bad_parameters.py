"""Every parameter of both cores with values that make no sense.

The parameters are those that the FMUs declare, so none is forgotten. Each value has one of two
outcomes: it is refused with name, value and limit, or a short run with it stays finite (those
of the track take some minutes: `make test-slow`).
"""

import numpy as np
import pytest
from bad_values import counted, outcome, values_for
from rail_quantities import flatten, with_values
from rail_vehicle import VehicleModel
from rail_vehicle.errors import StepError
from rail_vehicle.parameters import VehicleParameters
from slab_track import TrackError, TrackModel, TrackParameters

STEP, STEPS = 1e-4, 2
SMALL = {"wheelset_count": 1, "window.slab_count": 5, "rail.mode_count": 60, "slab.mode_count": 6}


def run_track(parameters):
    """Set up a short track and roll one wheelset over it."""
    model = TrackModel(parameters)
    count = parameters.wheelset_count
    motion = np.zeros((count, 11))
    motion[:, 0] = model.default_positions()
    motion[:, 5], motion[:, 10] = 80.0, -80.0 / 0.43
    state = model.initial_state(motion)
    outputs = model.outputs(state)
    for _ in range(STEPS):
        motion = motion.copy()
        motion[:, 0] += motion[:, 5] * STEP
        state, outputs = model.step(state, motion, STEP, applied_force=np.zeros((count, 2, 3)))
    return np.concatenate([outputs.contact.ravel(), outputs.wheel_outputs.ravel(), state.vector])


def run_vehicle(parameters):
    model = VehicleModel(parameters)
    state = model.initial_state(np.zeros(4))
    forces = model.static_forces
    for _ in range(STEPS):
        state, outputs = model.step(state, forces, forces, STEP, parameters.speed)
    return outputs.vector


def tried(defaults, names, run, refusals):
    known = flatten(defaults)
    found = {}
    for name in names:
        about, default = known[name]
        for value in values_for(about, default):
            found[name, repr(value)] = outcome(
                name, value, lambda v=value, n=name: with_values(defaults, {n: v}), run, refusals
            )
    return found


def faults(found):
    return [f"{name} = {value}: {o.fault}" for (name, value), o in found.items() if o.fault]


TRACK = with_values(TrackParameters(), SMALL)
TRACK_NAMES = list(flatten(TRACK))
GROUPS = sorted({name.partition(".")[0] for name in TRACK_NAMES})


VEHICLE_NAMES = list(flatten(VehicleParameters()))


@pytest.mark.parametrize("defaults", [TRACK, VehicleParameters()], ids=["track", "vehicle"])
def test_refusals_give_name_value_and_limit(defaults):
    found = tried(defaults, flatten(defaults), lambda parameters: np.zeros(1), ())
    print(counted(found))
    assert faults(found) == []
    kinds = [outcome.kind for outcome in found.values()]
    assert kinds.count("refused") > 0.6 * len(kinds)
    for name in flatten(defaults):
        assert any(o.kind == "refused" for (n, _), o in found.items() if n == name), name


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_track(group):
    names = [n for n in TRACK_NAMES if n.partition(".")[0] == group]
    found = tried(TRACK, names, run_track, (TrackError,))
    print(group, counted(found))
    assert faults(found) == []


@pytest.mark.parametrize("group", sorted({name.partition(".")[0] for name in VEHICLE_NAMES}))
def test_vehicle(group):
    names = [n for n in VEHICLE_NAMES if n.partition(".")[0] == group]
    found = tried(VehicleParameters(), names, run_vehicle, (StepError,))
    print(group, counted(found))
    assert faults(found) == []
