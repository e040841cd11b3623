"""Several instances in a process, and FMU states, of both real FMUs."""

import numpy as np
import pytest
from fmu_probes import (
    run_alone,
    run_restored,
    run_three,
    save_and_run_twice,
)

PHASES = (0.0, 0.4, 1.1)
SMALL_TRACK = {  # quick to set up
    "window.slab_count": 8,
    "rail.mode_count": 370,
    "slab.mode_count": 20,
}
BEFORE = {"vehicle": 40, "track": 540}
"""Steps to the saved state; the track slides for the second time 70 steps later."""


def test_three_instances_of_each_do_not_touch_each_other(fmus):
    """Loaded, stepped in turn, freed, and loaded again, in a process that ends well."""
    count, parameters = 40, [{}, SMALL_TRACK]
    rounds = fmus.call(run_three, fmus.both, PHASES, count, parameters)
    alone = [
        fmus.call(run_alone, path, PHASES[1], count, **values)
        for path, values in zip(fmus.both, parameters, strict=True)
    ]
    first, again = rounds
    assert len(first) == 6
    assert all(np.array_equal(one, other) for one, other in zip(first, again, strict=True))
    assert np.array_equal(first[1], alone[0])
    assert np.array_equal(first[4], alone[1])
    # The comparison means something: phases make instances differ.
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first[3], first[4])


@pytest.fixture(
    scope="module",
    params=[(name, instant) for name in BEFORE for instant in ("step_start", "step_end")],
    ids=" ".join,
)
def saved(request, fmus):
    """Both meanings of the inputs' instant: the FMUs remember other values for each."""
    name, instant = request.param
    path, values = getattr(fmus, name), {"coupling.input_time": instant}
    return name, path, fmus.call(save_and_run_twice, path, BEFORE[name], 100, **values)


def test_restored_state_gives_the_same_bits(saved):
    name, _, found = saved
    assert np.array_equal(found["first"], found["second"])
    assert np.ptp(found["first"], axis=0).any()
    at_save, at_end, restored = found["slides"]
    assert restored == at_save
    assert at_end - at_save == (1 if name == "track" else 0)  # the track across a slide


@pytest.mark.parametrize("used", [False, True], ids=["new", "used"])
def test_state_goes_to_another_process(fmus, saved, used):
    """Into an instance that was never initialised, and into one that ran with other values."""
    name, path, found = saved
    others = {"vehicle": {"car_body.mass": 30e3}, "track": SMALL_TRACK}[name]
    rows = fmus.call(
        run_restored, path, found["data"], BEFORE[name], 100, used=used, **(others if used else {})
    )
    assert np.array_equal(rows, found["first"])
