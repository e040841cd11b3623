"""Third octaves against IEC 61260-1, spectra against scipy and against closed forms."""

import numpy as np
import pytest
from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing import (
    amplitude_spectrum,
    levels,
    nominal_frequencies,
    power_spectral_density,
    spectrogram,
    third_octave_bands,
    third_octaves,
)
from scipy import signal as scipy_signal
from synthetic import signal, times


def noise(duration=20.0, rate=4000.0, channels=2):
    time = times(duration, rate)
    rng = np.random.default_rng(3)
    return signal(rng.normal(size=(time.size, channels)), time)


def test_bands_are_those_of_iec_61260():
    """Exact mid-band frequencies and edges as tables of the standard print them."""
    lower, middle, upper = third_octave_bands(25.0, 1000.0)
    printed = "25.119 31.623 39.811 50.119 63.096 79.433 100 125.89 158.49 199.53 251.19"
    assert middle[:11] == pytest.approx([float(x) for x in printed.split()], rel=1e-4)
    assert lower[-1] == pytest.approx(891.25, abs=0.01)
    assert upper[-1] == pytest.approx(1122.02, abs=0.01)
    np.testing.assert_allclose(upper[:-1], lower[1:], rtol=1e-12)
    nominal = "25 31.5 40 50 63 80 100 125 160 200 250 315 400 500 630 800 1000"
    assert nominal_frequencies(middle) == pytest.approx([float(x) for x in nominal.split()])


def test_bands_of_noise_are_those_of_a_filter_bank():
    """Butterworth band-passes of sixth order between the same edges, in the time domain."""
    record = noise(duration=60.0)
    found = third_octaves(record, low=20.0, high=1000.0)
    lower, _, upper = third_octave_bands(20.0, 1000.0)
    for number, edges in enumerate(zip(lower, upper, strict=True)):
        sections = scipy_signal.butter(6, edges, "bandpass", fs=4000.0, output="sos")
        filtered = scipy_signal.sosfilt(sections, record.to_numpy(), axis=0)[4000:]
        level = 20.0 * np.log10(filtered.std(axis=0) / found[number].to_numpy())
        assert np.abs(level).max() < 0.5


def test_noise_grows_by_a_decibel_from_band_to_band():
    found = levels(third_octaves(noise(60.0, channels=8), low=20.0, high=1000.0), reference=1.0)
    mean = found.mean("channel").to_numpy()
    slope = np.polyfit(np.arange(mean.size), mean, 1)[0]
    assert slope == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("frequency", [31.623, 100.0, 794.33])
def test_a_sine_is_in_its_band(frequency):
    time = times(2.0, 5000.0)
    sine = signal(3.0 * np.sin(2.0 * np.pi * frequency * time + 0.4), time)
    found = third_octaves(sine, low=10.0, high=1000.0)
    assert float(found.sel(frequency=frequency, method="nearest")) == pytest.approx(
        3.0 / np.sqrt(2.0), rel=1e-3
    )
    assert float((found**2).sum()) == pytest.approx(4.5, rel=1e-3)
    db = float(levels(found).max())
    assert db == pytest.approx(20.0 * np.log10(3.0 / np.sqrt(2.0) / 1e-6), abs=0.01)


def test_bands_beyond_the_record_are_not_a_number():
    time = times(0.3, 1000.0)
    found = third_octaves(signal(np.sin(time), time), low=1.0, high=1000.0)
    known = np.isfinite(found.to_numpy())
    nominal = found["nominal_frequency"].to_numpy()
    assert nominal[known].min() == 31.5  # two lines of 3.33 Hz, 7.3 Hz wide
    assert nominal[known].max() == 400.0  # up to 447 Hz; half the sampling rate is 500 Hz


def test_density_is_welchs():
    record = noise()
    found = power_spectral_density(record, resolution=2.0)
    f, expected = scipy_signal.welch(record.to_numpy(), fs=4000.0, nperseg=2000, axis=0)
    np.testing.assert_allclose(found["frequency"], f)
    np.testing.assert_allclose(found.to_numpy(), expected)
    assert found.attrs["units"] == "(m/s2)2/Hz"
    power = float(found.isel(channel=0).sum()) * 2.0
    assert power == pytest.approx(float(record.isel(channel=0).var()), rel=0.02)


def test_spectrogram_is_the_density_over_time():
    """White noise whose second half is twice as strong; and a Welch density is its mean."""
    record = noise()
    record[record.sizes["time"] // 2 :] *= 2.0
    found = spectrogram(record, segment=0.25, overlap=0.5)
    assert found.dims == ("frequency", "time", "channel")
    assert found["frequency"].to_numpy()[1] == pytest.approx(4.0)
    halves = found.sel(frequency=slice(50, 1500)).mean(["frequency", "channel"])
    ratio = halves.sel(time=slice(11, 19)).mean() / halves.sel(time=slice(1, 9)).mean()
    assert float(ratio) == pytest.approx(4.0, rel=0.05)
    welch = power_spectral_density(record, resolution=4.0)
    np.testing.assert_allclose(found.mean("time").to_numpy(), welch.to_numpy(), rtol=1e-9)


def test_amplitude_of_a_line():
    time = times(1.0, 2000.0)
    found = amplitude_spectrum(signal(7.0 + 2.5 * np.cos(2.0 * np.pi * 120.0 * time), time))
    assert float(found.max()) == pytest.approx(2.5, rel=1e-6)
    assert float(found["frequency"][int(found.to_numpy().argmax())]) == pytest.approx(120.0)


def test_wrong_wishes_are_refused():
    record = noise(duration=1.0)
    with pytest.raises(ParameterError, match=r"segment = 2\.0.*record of 1 s"):
        spectrogram(record, segment=2.0)
    with pytest.raises(ParameterError, match=r"overlap = 1\.0.*less than 1"):
        spectrogram(record, overlap=1.0)
    with pytest.raises(ParameterError, match=r"resolution = 0\.1.*at least 1 Hz"):
        power_spectral_density(record, resolution=0.1)
    with pytest.raises(ParameterError, match=r"reference.*unit kg"):
        levels(signal(np.ones(9), np.arange(9.0), "kg"))
    uneven = signal(np.ones(9), np.arange(9.0) ** 2)
    with pytest.raises(ParameterError, match="equidistant"):
        power_spectral_density(uneven)
    with pytest.raises(ParameterError, match="8 records or more"):
        power_spectral_density(uneven[:3])
