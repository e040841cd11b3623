"""Rail joints, cosines, conversions and parameters of the irregularities."""

import numpy as np
import pytest
from rail_quantities import ParameterError, flatten, with_values
from slab_track.irregularity import (
    CosineParameters,
    Irregularity,
    IrregularityParameters,
    RailJointParameters,
    rails_from_track,
    track_from_rails,
)

LEFT, RIGHT, VERTICAL, LATERAL = 0, 1, 0, 1


def with_joint(**values) -> Irregularity:
    return Irregularity(IrregularityParameters(rail_joint=RailJointParameters(**values)))


def with_cosine(**values) -> Irregularity:
    return Irregularity(IrregularityParameters(cosine=CosineParameters(**values)))


def test_default_is_smooth_track():
    offsets, slopes = Irregularity(IrregularityParameters()).evaluate(np.linspace(-100, 1e6, 999))
    assert not offsets.any()
    assert not slopes.any()


def test_rail_joint_is_the_sum_of_two_cosine_dips():
    x = np.array([20.0, 20.025, 20.05, 20.25, 20.5, 19.4, 21.0])
    offsets, _ = with_joint(side="both", position=20.0).evaluate(x)
    expected = 1e-3 * np.array([0.6, 0, 0, 0.15, 0, 0, 0])
    expected[1] = 0.15e-3 * (1 + np.cos(2 * np.pi * 0.025)) + 0.15e-3
    expected[2] = 0.15e-3 * (1 + np.cos(2 * np.pi * 0.05))
    for side in (LEFT, RIGHT):
        assert offsets[:, side, VERTICAL] == pytest.approx(expected, abs=1e-15)
    assert not offsets[:, :, LATERAL].any()


@pytest.mark.parametrize(("side", "index"), [("left", LEFT), ("right", RIGHT)])
def test_joint_on_one_rail(side, index):
    offsets, _ = with_joint(side=side, position=7.0).evaluate([7.0])
    assert offsets[0, index, VERTICAL] == pytest.approx(0.6e-3)
    assert offsets[0, 1 - index, VERTICAL] == 0.0


@pytest.mark.parametrize("position", [20.0, 1e6])
def test_slope_of_the_joint_is_its_derivative(position):
    irregularity = with_joint(side="both", position=position)
    step = 2.0**-13
    x = position + np.arange(-0.75, 0.75, step)
    offsets, slopes = irregularity.evaluate(x)
    middle = (offsets[2:] - offsets[:-2]) / (2 * step)
    assert np.abs(middle - slopes[1:-1]).max() < 1e-4 * np.pi * 0.3e-3 / 0.1 + 6e-5
    # Continuous: the largest change per step is the curvature's.
    assert np.abs(np.diff(slopes, axis=0)).max() < 1.05 * step * 2 * np.pi**2 * 0.3e-3 * 101


def test_repeated_joint_comes_endlessly_in_running_direction_only():
    irregularity = with_joint(side="both", position=20.0, repeat_distance=25.0)
    first = irregularity.evaluate(20.0 + np.linspace(-0.5, 0.5, 33))[0]
    for count in (1, 2, 40_000):
        x = 20.0 + 25.0 * count + np.linspace(-0.5, 0.5, 33)
        assert irregularity.evaluate(x)[0] == pytest.approx(first, abs=1e-11)
    assert not irregularity.evaluate(-5.0 + np.linspace(-1, 1, 33))[0].any()
    assert not irregularity.evaluate([32.5])[0].any()


def test_repeat_equal_to_the_length_is_a_corrugation():
    irregularity = with_cosine(side="both", length=0.08, depth=4e-5, repeat_distance=0.08)
    x = np.linspace(20.0, 30.0, 4001)
    expected = 2e-5 * (1 + np.cos(2 * np.pi * (x - 20.0) / 0.08))
    offsets = irregularity.evaluate(x)[0]
    assert offsets[:, LEFT, VERTICAL] == pytest.approx(expected, abs=1e-16)


@pytest.mark.parametrize("depth", [2e-3, -2e-3])
@pytest.mark.parametrize(("direction", "index"), [("vertical", VERTICAL), ("lateral", LATERAL)])
def test_cosine_dip_and_bump(depth, direction, index):
    irregularity = with_cosine(
        side="right", direction=direction, position=-30.0, length=3.0, depth=depth
    )
    offsets, slopes = irregularity.evaluate([-31.5, -30.75, -30.0, -29.25, -28.5])
    values = offsets[:, RIGHT, index]
    assert values == pytest.approx(depth * np.array([0, 0.5, 1, 0.5, 0]), abs=1e-15)
    steepest = np.pi * depth / 3.0
    assert slopes[:, RIGHT, index] == pytest.approx(
        steepest * np.array([0, 1, 0, -1, 0]), abs=1e-15
    )
    assert np.count_nonzero(np.abs(offsets).max(axis=0)) == 1


def test_parts_add_up_and_only_the_random_part_is_faded_in():
    joint = RailJointParameters(side="both", position=5.0)
    random = IrregularityParameters(spectrum="german_low", start=0.0, ramp_length=10.0)
    x = np.linspace(-5, 30, 701)
    total = Irregularity(random.replace(rail_joint=joint)).evaluate(x)
    parts = Irregularity(random), Irregularity(IrregularityParameters(rail_joint=joint))
    for k in range(2):
        assert total[k] == pytest.approx(sum(part.evaluate(x)[k] for part in parts), abs=1e-15)
    early = with_joint(side="both", position=-4.0).evaluate([-4.0])[0]
    assert early[0, LEFT, VERTICAL] == pytest.approx(0.6e-3)


@pytest.mark.parametrize(
    ("track", "rails"),
    [
        ((1, 0, 0, 0), ((1, 0), (1, 0))),  # level: both rails down
        ((0, 1, 0, 0), ((0, 1), (0, 1))),  # alignment: both rails to the right
        ((0, 0, 1, 0), ((-0.5, 0), (0.5, 0))),  # cross-level: right rail lower
        ((0, 0, 0, 1), ((0, -0.5), (0, 0.5))),  # gauge: wider
    ],
)
def test_signs_of_the_four_kinds(track, rails):
    assert np.array_equal(rails_from_track(track), np.array(rails))
    assert np.array_equal(track_from_rails(rails), np.array(track))


def test_conversions_are_inverse():
    track = np.random.default_rng(1).normal(size=(7, 5, 4))
    assert track_from_rails(rails_from_track(track)) == pytest.approx(track, abs=1e-15)


def test_names_of_the_parameters_are_the_fmus():
    names = flatten(IrregularityParameters())
    for name in ("spectrum", "seed", "start", "rail_joint.position", "file.path", "cosine.depth"):
        assert name in names
    assert all(about.description for about, _ in names.values())
    changed = with_values(IrregularityParameters(), {"rail_joint.position": 3.0})
    assert changed.rail_joint.position == 3.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: IrregularityParameters(spectrum="german"), "must be one of none, german_low"),
        (lambda: IrregularityParameters(seed=-1), "at least 0"),
        (lambda: IrregularityParameters(seed=1.5), "whole number"),
        (lambda: IrregularityParameters(ramp_length=-1), "at least 0"),
        (
            lambda: IrregularityParameters(spectrum="german_low", shortest_wavelength=70),
            r"longest wavelength \(80 m\)",
        ),
        (
            lambda: IrregularityParameters(spectrum="german_low", shortest_wavelength=1e-3),
            "at least 0.01 m",
        ),
        (
            lambda: IrregularityParameters(spectrum="german_low", longest_wavelength=2e3),
            "at most 1000 m",
        ),
        (lambda: RailJointParameters(side="middle"), "both, left, right"),
        (lambda: RailJointParameters(repeat_distance=0.5), "at least the length 1 m"),
        (lambda: CosineParameters(length=0), "greater than 0"),
        (lambda: CosineParameters(length=5, repeat_distance=2), "at least the length 5 m"),
    ],
)
def test_wrong_parameters_are_refused(make, message):
    with pytest.raises(ParameterError, match=message):
        make()


def test_extrapolated_spectrum_is_remarked():
    inside = IrregularityParameters(spectrum="chinese_ballastless")
    assert Irregularity(inside).remarks == ()
    outside = inside.replace(shortest_wavelength=0.5)
    assert "2 to 200 m; 0.5 to 200 m extrapolate" in Irregularity(outside).remarks[0]
