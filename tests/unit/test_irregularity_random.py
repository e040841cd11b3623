"""Random irregularities: pure functions of the place, endless, smooth."""

import numpy as np
import pytest
from slab_track.irregularity import (
    Irregularity,
    IrregularityParameters,
    evaluate_into,
    track_from_rails,
)

SPACING = 0.25
GOLDEN = [[0.505904618, -1.8163827268], [-0.5139542742, -2.0722776584]]  # mm, [side][direction]


def line(**values) -> Irregularity:
    return Irregularity(IrregularityParameters(**{"spectrum": "german_low"} | values))


def test_bit_equal_in_any_order_and_from_a_fresh_object():
    x = np.concatenate((np.linspace(-50, 400, 1801), 1e6 + np.linspace(0, 300, 1201)))
    offsets, slopes = line().evaluate(x)
    order = np.random.default_rng(0).permutation(x.size)
    other = line()
    scattered = [other.evaluate(x[k : k + 1]) for k in order]
    assert np.array_equal(offsets[order], np.concatenate([o for o, _ in scattered]))
    assert np.array_equal(slopes[order], np.concatenate([s for _, s in scattered]))


def test_golden_values_of_seed_1():
    # Regenerate: Irregularity(IrregularityParameters(spectrum="german_low"))
    # .evaluate([1234.5])[0] * 1e3. They pin the meaning of a seed between versions.
    offsets, _ = line().evaluate([1234.5])
    assert offsets[0] * 1e3 == pytest.approx(np.array(GOLDEN), abs=1e-9)


def test_wheels_in_one_call_are_the_same_as_one_by_one():
    wheels = np.array([12345.0, 12342.5, 12327.5, 12325.0])
    together = line().evaluate(wheels)[0]
    assert np.array_equal(together, np.concatenate([line().evaluate([x])[0] for x in wheels]))


def test_kept_samples_have_a_fixed_size():
    irregularity = line()
    sizes = [array.nbytes for array in irregularity.data if isinstance(array, np.ndarray)]
    for start in (0.0, 1e5, 1e7):
        irregularity.evaluate(start + np.arange(0, 5000, 0.5))
    after = [array.nbytes for array in irregularity.data if isinstance(array, np.ndarray)]
    assert sizes == after
    assert sum(sizes) < 1e6


def test_a_kept_block_serves_its_own_places_only():
    irregularity = line()
    expected = line().evaluate([5000.0])[0]
    irregularity.evaluate([900.0])
    irregularity.data.kept_samples[:] = 1.0  # what is kept for 900 m must not be seen at 5 km
    assert np.array_equal(irregularity.evaluate([5000.0])[0], expected)


@pytest.mark.parametrize("values", [{"seed": 2}, {"spectrum": "german_high"}])
def test_other_seed_or_spectrum_is_another_line(values):
    x = np.arange(100.0, 5100.0, SPACING)
    one, other = line().evaluate(x)[0], line(**values).evaluate(x)[0]
    assert np.abs(one - other).max() > 1e-3
    if "seed" in values:
        for side in range(2):
            for direction in range(2):
                pair = one[:, side, direction], other[:, side, direction]
                assert abs(np.corrcoef(*pair)[0, 1]) < 0.2


def test_same_seed_scales_with_the_spectrum():
    """Low and high disturbance differ in their constants only: one line, scaled."""
    x = np.arange(100.0, 200.0, SPACING)
    low, high = (
        track_from_rails(line(spectrum=name).evaluate(x)[0])
        for name in ("german_low", "german_high")
    )
    ratio = np.sqrt([1.08e-6 / 4.032e-7, 6.125 / 2.119, 1.08e-6 / 4.032e-7, 1.032e-7 / 5.32e-8])
    assert high == pytest.approx(low * ratio, abs=1e-12)


@pytest.mark.parametrize("origin", [0.0, 1e6, 1e9, -1e6])
def test_slope_is_the_derivative_everywhere(origin):
    irregularity = line(start=-2e9)
    step = 2.0**-6 if abs(origin) > 1e7 else 2.0**-9
    x = origin + 100 + np.arange(20000) * step  # crosses blocks of all bands but the longest
    offsets, slopes = irregularity.evaluate(x)
    middle = (offsets[2:] - offsets[:-2]) / (2 * step)
    assert np.abs(middle - slopes[1:-1]).max() < (2e-5 if step > 0.01 else 3e-7)


@pytest.mark.parametrize("origin", [0.0, 1e6, 1e9])
def test_no_jump_where_kept_blocks_meet(origin):
    irregularity = line(start=-1.0)
    for spacing in 1 / irregularity.data.inverse_spacing:
        block = np.floor(origin / (32 * spacing)) + np.arange(1, 40)
        edge = 32 * spacing * block
        gap = 4 * np.spacing(np.abs(edge))
        below, above = irregularity.evaluate(edge - gap), irregularity.evaluate(edge + gap)
        assert np.abs(above[0] - below[0]).max() < 2e-2 * gap.max() + 1e-16
        assert np.abs(above[1] - below[1]).max() < 2e-1 * gap.max() + 1e-15


def test_a_thousand_kilometres_away_is_as_good_as_here():
    """Second differences show rounding of the place first: compare their spread."""
    irregularity = line(start=-10.0, ramp_length=1.0)
    step = 2.0**-4
    x = np.arange(0.0, 20000.0, step)
    spreads = []
    for origin in (0.0, 1e6):
        level = track_from_rails(irregularity.evaluate(x + origin)[0])[:, 0]
        spreads.append([level.std(), np.diff(level, 2).std() / step**2])
    assert spreads[1] == pytest.approx(spreads[0], rel=0.05)


def test_fine_wavelengths_stay_clean_a_thousand_kilometres_away():
    """Rounding of x (1e-10 m at 1000 km) times the slope is the most that may show."""
    irregularity = line(shortest_wavelength=0.02, start=-1.0)
    step = 2.0**-12
    x = 1e6 + np.arange(4096) * step
    slopes = irregularity.evaluate(x)[1]
    second = np.diff(slopes, 3, axis=0)  # a kink of the slope would stand out
    assert np.abs(second).max() < 50 * second.std()


def test_does_not_repeat():
    """No stretch of 100 km looks like another part of it: correlation at all lags is noise."""
    x = np.arange(0.0, 100_000.0, 0.5)
    level = track_from_rails(line(start=-100).evaluate(x)[0])[:, 0]
    spectrum = np.abs(np.fft.rfft(level - level.mean(), 2 * level.size)) ** 2
    correlation = np.fft.irfft(spectrum)[: level.size // 2]
    correlation /= correlation[0]
    beyond = correlation[int(2000 / 0.5) :]
    assert np.abs(beyond).max() < 0.12


@pytest.fixture(scope="module")
def long_stretch():
    """Return the four kinds every 4 m over 240 km."""
    x = np.arange(0.0, 240_000.0, 4.0)
    return track_from_rails(line(start=-100).evaluate(x)[0])


def test_kinds_are_independent(long_stretch):
    off_diagonal = np.corrcoef(long_stretch.T) - np.eye(4)
    assert np.abs(off_diagonal).max() < 0.05


def test_values_are_gaussian_with_mean_zero(long_stretch):
    normed = long_stretch / long_stretch.std(axis=0)
    assert np.abs(normed.mean(axis=0)).max() < 0.02
    assert np.abs((normed**3).mean(axis=0)).max() < 0.1
    assert np.abs((normed**4).mean(axis=0) - 3).max() < 0.2
    assert np.abs(normed).max() > 3.8  # the tails are there


def test_smooth_track_before_start_and_smooth_fade_in():
    irregularity = line(start=100.0, ramp_length=30.0)
    offsets, slopes = irregularity.evaluate(np.linspace(-500.0, 100.0, 1001))
    assert not offsets.any()
    assert not slopes.any()
    full = line(start=-1000.0, ramp_length=1.0)
    beyond = np.linspace(130.0, 300.0, 500)
    assert np.array_equal(irregularity.evaluate(beyond)[0], full.evaluate(beyond)[0])
    step = 2.0**-8
    x = np.arange(99.0, 132.0, step)
    offsets, slopes = irregularity.evaluate(x)
    middle = (offsets[2:] - offsets[:-2]) / (2 * step)
    assert np.abs(middle - slopes[1:-1]).max() < 1e-6
    assert np.abs(np.diff(slopes, axis=0)).max() < 1e-2 * step


@pytest.mark.parametrize("kind", range(4))
def test_factors_switch_single_kinds(kind):
    names = ["level_factor", "alignment_factor", "cross_level_factor", "gauge_factor"]
    x = np.arange(100.0, 300.0, SPACING)
    both = {name: 0.0 for name in names} | {names[kind]: 2.0}
    single = track_from_rails(line(**both).evaluate(x)[0])
    every = track_from_rails(line().evaluate(x)[0])
    expected = np.zeros_like(every)
    expected[:, kind] = 2 * every[:, kind]
    assert single == pytest.approx(expected, abs=1e-15)


def test_place_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="must be a number between"):
        line().evaluate([0.0, np.nan])
    with pytest.raises(ValueError, match="must be a number between"):
        line().evaluate([1e13])
    with pytest.raises(ValueError, match=r"shape \(n,\)"):
        line().evaluate([[1.0, 2.0]])


def test_compiled_loop_gives_not_a_number_for_a_place_that_is_none():
    offsets, slopes = np.zeros((2, 2, 2)), np.zeros((2, 2, 2))
    evaluate_into(np.array([np.inf, 50.0]), line().data, offsets, slopes)
    assert np.isnan(offsets[0]).all()
    assert np.isnan(slopes[0]).all()
    assert np.isfinite(offsets[1]).all()
