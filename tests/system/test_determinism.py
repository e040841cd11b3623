"""The same run gives the same bits: again, elsewhere, in other portions, in company, restored."""

import numpy as np
import pytest
from determinism import COUNT, SAVED_AT, runs, ways_to_begin, ways_to_restore, ways_to_step

EVERY = 7
COMMON = {"line": "HD", "speed": 300.0, "distance": 6.0, "irregularity": "german_low"}
PARAMETERS = {
    "vehicle": {"car_body.mass": 38e3, "speed": 80.0, "yaw_damper.damping": 3e5},
    "track": {  # quick to set up
        "window.slab_count": 8,
        "rail.mode_count": 370,
        "slab.mode_count": 20,
        "fastener.vertical_stiffness": 5e7,
        "irregularity.spectrum": "german_low",
        "irregularity.start": -30.0,
    },
}
OTHERS = {"vehicle": {"car_body.mass": 30e3}, "track": {**PARAMETERS["track"], "slab.width": 2.3}}


def assert_same(one, other):
    assert set(one) == set(other)
    for name, values in one.items():
        assert np.array_equal(values, other[name], equal_nan=values.dtype.kind == "f"), name


@pytest.fixture(scope="module")
def pairs(fmus):
    """Run the pair in two processes, in the second one after another line's."""
    case = COMMON | {"vehicle": fmus.vehicle, "track": fmus.track}
    zx = case | {"line": "ZX", "distance": 2.0}
    first = fmus.call(runs, [case, case, case | {"record_every": EVERY}])
    second = fmus.call(runs, [zx, case])
    return {
        "first": first[0],
        "again": first[1],
        "thinned": first[2],
        "elsewhere": second[1],
        "zx": second[0],
    }


@pytest.mark.parametrize("other", ["again", "elsewhere"])
def test_a_run_repeats_itself(pairs, other):
    """Once more in its process; in a new one, whose hash seed differs, after a run of another."""
    assert_same(pairs["first"], pairs[other])
    force = pairs["first"]["normal_force"]
    assert np.ptp(force, axis=0).min() > 100.0
    assert not np.array_equal(force[:20], pairs["zx"]["normal_force"][:20])


def test_recording_changes_nothing(pairs):
    whole, thinned = pairs["first"], pairs["thinned"]
    assert thinned["time"].size == (whole["time"].size - 1) // EVERY + 1
    at_times = {
        name: values[::EVERY] if values.shape[:1] == whole["time"].shape else values
        for name, values in whole.items()
    }
    assert_same(at_times, thinned)


@pytest.mark.parametrize("name", PARAMETERS)
def test_steps_in_any_portions_and_company(fmus, name):
    """With rests between, in turn with another instance, and without reading outputs."""
    found = fmus.call(ways_to_step, getattr(fmus, name), PARAMETERS[name])
    whole = found.pop("whole")
    assert whole.shape[0] == COUNT
    assert np.ptp(whole, axis=0).any()
    for way, rows in found.items():
        assert np.array_equal(rows, whole[-len(rows) :]), way


@pytest.mark.parametrize("name", PARAMETERS)
def test_steps_after_a_restored_state(fmus, name):
    """In the same instance and in others of the process, from memory and from bytes."""
    found = fmus.call(ways_to_restore, getattr(fmus, name), PARAMETERS[name], OTHERS[name])
    went_on = found.pop("went on")
    assert went_on.shape[0] == COUNT - SAVED_AT
    for way, rows in found.items():
        assert np.array_equal(rows, went_on), way


@pytest.mark.parametrize("name", PARAMETERS)
def test_set_up_calls_in_any_order(fmus, name):
    found = fmus.call(ways_to_begin, getattr(fmus, name), PARAMETERS[name], 10)
    reference = found.pop("parameters first")
    for order, rows in found.items():
        assert np.array_equal(rows, reference), order
