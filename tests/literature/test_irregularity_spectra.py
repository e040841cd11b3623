"""Spectra of the generated irregularities against the published formulas."""

import numpy as np
import pytest
from scipy import signal, stats
from slab_track.irregularity import (
    SPECTRA,
    Irregularity,
    IrregularityParameters,
    band_rms,
    track_from_rails,
)
from slab_track.irregularity.bands import design_bands, realised_density

SEGMENT = 4096
SEGMENTS = 150


@pytest.mark.parametrize(
    ("name", "millimetres"),
    [
        ("german_low", (2.07, 1.50, None, None)),
        ("german_high", (3.39, 2.56, None, None)),
        ("chinese_ballastless", (1.22, 0.67, 0.52, 0.34)),
    ],
)
def test_published_root_mean_squares(name, millimetres):
    """Bands of 1 to 80 m (German) and 2 to 200 m (Chinese)."""
    spectrum = SPECTRA[name]
    for channel, expected in enumerate(millimetres):
        if expected is not None:
            rms = 1e3 * band_rms(spectrum, channel, *spectrum.band)
            assert rms == pytest.approx(expected, abs=0.0051)


def test_german_formulas_at_one_wavenumber():
    """Worked by hand at Omega = 0.5 rad/m, low disturbance."""
    at = np.array([0.5])
    shape = 0.67996516 / ((0.25 + 0.00042436) * (0.25 + 0.67996516))
    long_waves = 0.25 / (0.25 + 0.191844)
    density = SPECTRA["german_low"].density
    assert density(0, at)[0] == pytest.approx(4.032e-7 * shape, rel=1e-12)
    assert density(1, at)[0] == pytest.approx(2.119e-7 * shape, rel=1e-12)
    assert density(2, at)[0] == pytest.approx(4 * 4.032e-7 * shape * long_waves, rel=1e-12)
    assert density(3, at)[0] == pytest.approx(5.32e-8 * shape * long_waves, rel=1e-12)


@pytest.mark.parametrize("channel", range(4))
def test_chinese_pieces_meet_at_their_breaks(channel):
    """The fit's pieces meet within 0.4 %: a wrong digit in a table would not."""
    breaks = ((0.0187, 0.0474, 0.1533), (0.0450, 0.1234), (0.0258, 0.1163), (0.1090, 0.2938))
    density = SPECTRA["chinese_ballastless"].density
    for f in breaks[channel]:
        below, above = density(channel, 2 * np.pi * f * np.array([1 - 1e-9, 1 + 1e-9]))
        assert above == pytest.approx(below, rel=0.005)


@pytest.mark.parametrize("name", SPECTRA)
@pytest.mark.parametrize("channel", range(4))
def test_filters_realise_the_formula_without_statistics(name, channel):
    """In the band within 1.5 %; outside next to nothing."""
    spectrum = SPECTRA[name]
    shortest, longest = spectrum.band
    bands = design_bands(spectrum, shortest, longest, (1.0, 1.0, 1.0, 1.0))
    inside = 2 * np.pi / np.geomspace(longest / 1.06, shortest * 1.06, 400)
    ratio = realised_density(bands, channel, inside) / spectrum.density(channel, inside)
    assert ratio == pytest.approx(1.0, abs=0.015)
    longer = 2 * np.pi / np.geomspace(1.2 * longest, 20 * longest, 50)
    shorter = 2 * np.pi / (shortest / np.linspace(1.2, 8, 100))
    for outside, most in ((longer, 1e-5), (shorter, 5e-3)):
        realised = realised_density(bands, channel, outside)
        assert np.max(realised / spectrum.density(channel, outside)) < most
    # The splines' images beyond the shortest wavelength are nothing beside the band itself.
    edge = spectrum.density(channel, np.array([2 * np.pi / shortest]))
    assert np.max(realised_density(bands, channel, shorter) / edge) < 1e-5
    every = 2 * np.pi / np.geomspace(longest * 1.1, shortest / 1.1, 4000)
    rms = np.sqrt(np.trapezoid(realised_density(bands, channel, every), every))
    assert rms == pytest.approx(band_rms(spectrum, channel, shortest, longest), rel=1e-3)


@pytest.mark.parametrize(
    ("name", "values", "origin"),
    [
        ("german_low", {}, 0.0),
        pytest.param("german_low", {}, 1e6, marks=pytest.mark.slow),
        pytest.param("german_high", {"seed": 99}, 0.0, marks=pytest.mark.slow),
        ("chinese_ballastless", {}, 1e6),
        ("german_low", {"shortest_wavelength": 0.3, "longest_wavelength": 30.0}, 0.0),
    ],
)
def test_welch_estimate_lies_in_its_confidence_interval(name, values, origin):
    """Hann window, half overlap; interval of the chi-squared distribution (Welch 1967)."""
    parameters = IrregularityParameters(spectrum=name, start=-100.0, **values)
    shortest, longest = parameters.band
    step = shortest / 4
    x = origin + step * np.arange(SEGMENT * SEGMENTS)
    channels = track_from_rails(Irregularity(parameters).evaluate(x)[0])
    frequency, estimate = signal.welch(channels, 1 / step, "hann", SEGMENT, detrend=False, axis=0)
    inside = (frequency > 1.06 / longest) & (frequency < 1 / (1.06 * shortest))
    wavenumber = 2 * np.pi * frequency[inside]
    for channel in range(4):
        density = SPECTRA[name].density(channel, wavenumber)
        ratio = estimate[inside, channel] / (2 * np.pi) / density
        _check_ratio(ratio, wavenumber)


def _check_ratio(ratio, wavenumber):
    # Half-overlapping Hann segments are correlated: 2 K / (1 + 2/36) degrees of freedom.
    freedom = 2 * (2 * SEGMENTS - 1) / (1 + 2 / 36)
    low, high = stats.chi2.ppf([0.025, 0.975], freedom) / freedom
    assert np.mean((ratio < low) | (ratio > high)) < 0.09  # 0.05 plus neighbours' correlation
    # Third octaves: the mean of n lines (half of them independent) against four deviations.
    edges = np.arange(np.log2(wavenumber[0]), np.log2(wavenumber[-1]), 1 / 3)
    octave = np.digitize(np.log2(wavenumber), edges)
    for k in np.unique(octave):
        lines = ratio[octave == k]
        spread = np.sqrt(2 / freedom * 2 / lines.size)
        assert lines.mean() == pytest.approx(1.0, abs=4 * spread + 0.01)


def test_rails_of_the_german_track_are_independent_at_short_wavelengths():
    """S_c = 4 S_v there: mean and difference of two rails with equal, independent spectra."""
    parameters = IrregularityParameters(spectrum="german_low", start=-100.0)
    x = 0.25 * np.arange(SEGMENT * 40)
    rails = Irregularity(parameters).evaluate(x)[0][:, :, 0]
    frequency, coherence = signal.coherence(rails[:, 0], rails[:, 1], 4.0, nperseg=1024)
    short = (frequency > 1 / 3) & (frequency < 1 / 1.1)
    long = (frequency > 1 / 70) & (frequency < 1 / 40)
    assert coherence[short].mean() < 0.02
    assert coherence[long].min() > 0.5
