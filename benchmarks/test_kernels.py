"""Cost of the kernels and its growth: ``python -m pytest benchmarks --benchmark-sort=name``.

Cost must grow in proportion to what there is to compute, not faster; distance costs nothing but
its steps, since the window stays as large as it is.
"""

import numpy as np
import pytest
from rail_quantities import with_values
from slab_track import TrackModel, TrackParameters
from slab_track.contact.fastsim import STRIP_WORK, creep_forces, fastsim_grid

SPEED, STEP = 300.0 / 3.6, 1e-4


def steps(count, **settings):
    """Return a function that makes ``count`` macro steps of a running track."""
    values = {"contact.model": "profiles"} | {
        name.replace("__", "."): value for name, value in settings.items()
    }
    model = TrackModel(with_values(TrackParameters(), values))
    motion = np.zeros((model.parameters.wheelset_count, 11))
    motion[:, 0] = model.default_positions()
    motion[:, 5], motion[:, 10] = SPEED, -SPEED / model.parameters.contact.wheel_radius
    state = model.initial_state(motion)
    motion[:, 2] = state.static_heights
    state = model.with_motion(state, motion)

    def run():
        nonlocal state
        for _ in range(count):
            motion[:, 0] += SPEED * STEP
            state, _ = model.step(state, motion, STEP)

    run()
    return run


def test_fastsim(benchmark):
    grid = fastsim_grid(10, 8), np.zeros(STRIP_WORK)
    patch = (71733.0, 6.0e-3, 6.1e-3, 4.1, 3.6, 1.5, 8e10, 0.3, 4e-4, 3e-6, 2.9e-2)
    force = benchmark(creep_forces, *grid, *patch)
    assert force[0] < 0.0


@pytest.mark.parametrize("modes", [128, 256, 512])
def test_modes(benchmark, modes):
    benchmark(steps(50, rail__mode_count=modes))


@pytest.mark.parametrize("slabs", [9, 13, 17])
def test_slabs_in_the_window(benchmark, slabs):
    benchmark(steps(50, window__slab_count=slabs))


@pytest.mark.parametrize("wheelsets", [1, 2, 4])
def test_wheelsets(benchmark, wheelsets):
    benchmark(steps(50, wheelset_count=wheelsets))


@pytest.mark.parametrize("count", [604, 1208])
def test_distance(benchmark, count):
    """One and two slab lengths: slides included."""
    benchmark.pedantic(steps(count), rounds=10)
