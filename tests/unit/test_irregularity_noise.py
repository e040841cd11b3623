"""White noise by number, and the filtered sum written out beside the compiled loops."""

import itertools

import numpy as np
import pytest
from scipy.interpolate import BSpline
from slab_track.irregularity import Irregularity, IrregularityParameters, track_from_rails
from slab_track.irregularity.bands import design_bands
from slab_track.irregularity.noise import white_noise

COUNT = 20_000


def numbers(key, first=0, count=COUNT):
    """Return numbers of the stream of a (seed, band, channel)."""
    out = np.empty(count)
    white_noise(*key, first, out)
    return out


def correlation(one, other):
    return float(np.mean(one * other))


@pytest.fixture(scope="module")
def reference():
    return numbers((1, 0, 0))


def test_mean_variance_and_kurtosis(reference):
    """Sum of four uniform numbers: kurtosis 3 - 1.2 / 4."""
    assert reference.mean() == pytest.approx(0.0, abs=4 / COUNT**0.5)
    assert reference.var() == pytest.approx(1.0, abs=0.04)
    assert (reference**4).mean() == pytest.approx(2.7, abs=0.12)
    assert np.abs(reference).max() < 3.4641017  # sqrt(12)


def test_no_period_at_any_power_of_two(reference):
    for bit in range(63):
        later = numbers((1, 0, 0), first=1 << bit, count=2000)
        overlap = reference[: later.size]
        assert abs(correlation(overlap, later)) < 0.1, bit


def test_neighbours_and_negative_numbers_are_uncorrelated(reference):
    for lag in range(1, 40):
        assert abs(np.mean(reference[lag:] * reference[:-lag])) < 4.5 / COUNT**0.5
    before = numbers((1, 0, 0), first=-COUNT)
    assert abs(correlation(reference, before)) < 4 / COUNT**0.5
    assert abs(correlation(reference, before[::-1])) < 4 / COUNT**0.5


def test_streams_of_seeds_bands_and_channels_are_independent():
    keys = list(itertools.product(range(20), range(10), range(4)))
    assert len({tuple(numbers(key, count=4)) for key in keys}) == 800
    streams = [numbers(key, count=2000) for key in itertools.islice(keys, 40)]
    cross = np.array(streams) @ np.array(streams).T / 2000 - np.eye(40)
    assert np.abs(cross).max() < 0.12


@pytest.mark.parametrize("x", [-123.4, 0.0, 777.77, 1e6 + 0.3])
def test_is_the_sum_of_splines_over_filtered_noise(x):
    parameters = IrregularityParameters(spectrum="german_high", seed=5, start=-1e3)
    bands = design_bands(parameters.spectrum_function, *parameters.band, (1.0,) * 4)
    spline = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False)
    expected = np.zeros(4)
    for j, band in enumerate(bands):
        cell = int(np.floor(x / band.spacing))
        half = band.kernels.shape[1] // 2
        for channel, kernel in enumerate(band.kernels):
            for n in range(cell - 1, cell + 3):
                noise = numbers((5, j, channel), n - half, 2 * half + 1)
                weight = np.nan_to_num(spline(x / band.spacing - n))
                expected[channel] += weight * (kernel @ noise)
    track = track_from_rails(Irregularity(parameters).evaluate([x])[0])[0]
    assert track == pytest.approx(expected, abs=1e-11)
