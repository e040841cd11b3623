"""The example of the vehicle on rigid rails with a contact of one's own."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from fmu_probes import run_on_rigid_track

EXAMPLE = Path(__file__).parents[2] / "examples" / "vehicle_alone" / "rigid_track.py"


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(EXAMPLE))


@pytest.fixture(scope="module")
def heights(fmus, example):
    times, heights = fmus.call(run_on_rigid_track, EXAMPLE, fmus.vehicle, 6.0)
    return times, dict(zip(example["BODIES"], heights.T, strict=True))


def test_at_rest_until_the_rails_sink(heights, example):
    times, of_body = heights
    before = times * example["SPEED"] < example["BEGIN"] - 1.0
    for body, height in of_body.items():
        assert np.abs(height[before]).max() < 1e-9, body


def test_everything_is_lower_by_the_depth_in_the_end(heights, example):
    """The car body takes the longest to come to rest, at some 1 Hz."""
    _, of_body = heights
    for body, height in of_body.items():
        share = 5e-3 if body == "car_body" else 1e-4
        assert height[-1] == pytest.approx(example["DEPTH"], rel=share), body


def test_wheelsets_follow_the_rails(heights, example):
    """To within their contact spring under the unsprung mass's inertia and the suspension."""
    times, of_body = heights
    rails = example["rail_height"](times * example["SPEED"])
    assert np.abs(of_body["wheelset[1]"] - rails).max() < 0.01 * example["DEPTH"]
    lag = np.argmax(of_body["wheelset[4]"] > 0.5 * example["DEPTH"]) - np.argmax(
        of_body["wheelset[1]"] > 0.5 * example["DEPTH"]
    )
    assert lag * example["STEP"] * example["SPEED"] == pytest.approx(20.3, abs=0.1)
