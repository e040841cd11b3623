"""Filters, statistics of forces and orders, on signals known in closed form."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import ParameterError
from rail_cosim.postprocessing import (
    band_pass,
    basic_statistics,
    evaluated,
    flange_climbing,
    guiding_statistics,
    low_pass,
    moving_mean,
    order_spectrum,
    over_distance,
    passing_amplitudes,
    passing_frequencies,
    percentiles,
    static_wheel_load,
    steady_state_amplitude,
    vertical_force,
    wheel_statistics,
)
from synthetic import BAY, COUNT, LOAD, run, signal, times, wheels

SPEED = 80.0


def gain(function, frequency, rate=2000.0):
    time = times(4.0, rate)
    out = function(signal(np.sin(2.0 * np.pi * frequency * time), time))
    return float(out.sel(time=slice(2.0, None)).std()) * np.sqrt(2.0)


def test_low_pass_is_that_of_en_14363():
    """-3 dB at 20 Hz and at least 24 dB per octave beyond."""
    assert 20.0 * np.log10(gain(low_pass, 20.0)) == pytest.approx(-3.01, abs=0.02)
    assert 20.0 * np.log10(gain(low_pass, 10.0)) > -0.1
    assert 20.0 * np.log10(gain(low_pass, 80.0) / gain(low_pass, 40.0)) < -23.9


def test_band_pass_for_ride_characteristics():
    def ride(x):
        return band_pass(x, 0.4, 10.0)

    assert 20.0 * np.log10(gain(ride, 10.0)) == pytest.approx(-3.01, abs=0.05)
    assert gain(ride, 2.0) == pytest.approx(1.0, abs=0.01)
    assert gain(ride, 100.0) < 5e-4  # a decade beyond: 80 dB, and what is left of the start
    short = signal(np.ones(20), np.arange(20.0))
    with pytest.raises(ParameterError, match="less than high"):
        band_pass(short, 4.0, 1.0)
    with pytest.raises(ParameterError, match=r"cutoff = 20\.0.*sampling rate, 5 Hz"):
        low_pass(signal(np.ones(20), np.arange(20.0) / 10.0))


def test_a_constant_goes_through_from_the_first_record_on():
    time = times(1.0, 1000.0)
    constant = signal(np.full((time.size, 2), [3.0, -5.0]), time)
    np.testing.assert_allclose(low_pass(constant), constant, rtol=1e-9)


def test_moving_mean_at_changing_speed():
    """Of sin(k x): the mean over a window is known, whatever the speed."""
    time = times(3.0, 1000.0)
    way = 20.0 * time + 12.0 * time**2
    k = 2.0 * np.pi / 7.0
    data = run(time, way)
    found = moving_mean(data, signal(np.sin(k * way), time, "N"))
    x = found["distance"].to_numpy()
    assert x[0] == pytest.approx(1.0)
    assert np.diff(x) == pytest.approx(0.5)
    expected = np.sin(k * x) * np.sin(k) / k  # window of 2 m: sinc
    # Straight lines between records up to 0.09 m apart: (k dx)^2/12 low.
    np.testing.assert_allclose(found, expected, atol=(k * 0.092) ** 2 / 12.0)
    with pytest.raises(ParameterError, match=r"window = 200\.0.*at most the distance"):
        moving_mean(data, data["distance"], window=200.0)


def test_percentiles_are_numpys():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(5000, 3))
    found = percentiles(signal(values, np.arange(5000.0)))
    assert found["percentile"].to_numpy() == pytest.approx([0.15, 99.85])
    np.testing.assert_allclose(found, np.percentile(values, [0.15, 99.85], axis=0))
    # A normal distribution: 2.97 standard deviations.
    assert float(np.abs(found).mean()) == pytest.approx(2.968, abs=0.25)
    with pytest.raises(ParameterError, match="0 to 100"):
        percentiles(found.rename(percentile="time"), (101.0,))
    with pytest.raises(ParameterError, match="time or distance"):
        percentiles(found)


def rolling(duration=2.0, rate=5000.0, *, vertical=None, guiding=None):
    time = times(duration, rate)
    way = SPEED * time
    force = wheels(LOAD + 7e3 * np.sin(2.0 * np.pi * way / BAY), time)
    data = run(time, way, vertical_wheel_force=force if vertical is None else vertical(time, way))
    if guiding is not None:
        data["guiding_force"] = guiding(time, way)
    return data


def test_wheel_statistics_of_a_sine():
    found = wheel_statistics(rolling())
    assert static_wheel_load(rolling()) == LOAD
    assert found["dynamic_factor"].to_numpy() == pytest.approx(1.1, rel=1e-4)
    assert found["unloading"].to_numpy() == pytest.approx(0.1, rel=1e-3)
    assert found["mean"].to_numpy() == pytest.approx(LOAD, rel=1e-4)
    assert found["rms"].to_numpy() == pytest.approx(7e3 / np.sqrt(2.0), rel=1e-3)
    assert found["mean"].attrs["units"] == "N"
    assert found["unloading"].attrs["units"] == "1"
    # Sleepers pass at 127 Hz: nothing is left below 20 Hz.
    assert found["dynamic_factor_20_hz"].to_numpy() == pytest.approx(1.0, abs=1e-3)
    assert found.sizes == {"wheelset": 4, "side": 2}


def test_normal_force_stands_in_for_a_track_without_q():
    data = rolling().rename(vertical_wheel_force="normal_force")
    assert vertical_force(data).name == "normal_force"
    with pytest.raises(ParameterError, match="vertical_wheel_force"):
        vertical_force(data.drop_vars("normal_force"))
    with pytest.raises(ParameterError, match="guiding_force"):
        flange_climbing(data)


def test_guiding_forces_point_outwards():
    """Both wheels press to the right: that is outwards on the right rail, inwards on the left."""
    data = rolling(guiding=lambda time, way: wheels(np.full(time.size, 8e3), time))
    quotient = flange_climbing(data).mean("time")
    assert quotient.sel(side="right").to_numpy() == pytest.approx(8.0 / 70.0, rel=0.02)
    assert quotient.sel(side="left").to_numpy() == pytest.approx(-8.0 / 70.0, rel=0.02)
    found = guiding_statistics(data)
    assert found["sum_of_guiding_forces"].to_numpy() == pytest.approx(16e3)
    assert float(found["prudhomme_limit"]) == pytest.approx(10e3 + 2.0 * LOAD / 3.0)
    assert found["flange_climbing"].sel(side="right").to_numpy() == pytest.approx(8 / 70, rel=0.01)


def test_short_peaks_do_not_count_as_guiding():
    """5 ms of 40 kN: 0.4 m at 80 m/s, a fifth of the 2 m, and mostly above 20 Hz."""

    def kick(time, way):
        return wheels(np.where(np.abs(time - 1.5) < 2.5e-3, 40e3, 0.0), time)

    found = guiding_statistics(rolling(guiding=kick))
    assert found["sum_of_guiding_forces_peak"].to_numpy() == pytest.approx(80e3)
    mean = found["sum_of_guiding_forces"].to_numpy()
    assert (mean < 0.2 * 80e3).all()
    assert (mean > 0.05 * 80e3).all()


def test_a_wheel_in_the_air_guides_nothing():
    def lifting(time, way):
        return wheels(np.where(time < 1.5, LOAD, 0.0), time)

    data = rolling(vertical=lifting, guiding=lambda t, x: wheels(0.0 * t, t))
    quotient = flange_climbing(data)
    assert np.isnan(quotient.sel(time=slice(1.6, None))).all()
    assert wheel_statistics(data)["unloading"].to_numpy() == pytest.approx(1.0)
    assert np.isfinite(guiding_statistics(data)["flange_climbing"]).all()


def test_short_runs_have_no_means_over_two_metres():
    short = rolling(0.02, guiding=lambda t, x: wheels(np.full(t.size, 1e3), t))
    found = guiding_statistics(short)
    assert np.isnan(found["sum_of_guiding_forces"]).all()
    assert found["sum_of_guiding_forces_peak"].to_numpy() == pytest.approx(2e3)


def test_basic_statistics():
    found = basic_statistics(signal(np.array([1.0, -4.0, 2.0, 1.0]), np.arange(4.0)))
    values = {name: float(value) for name, value in found.items()}
    assert values["mean"] == 0.0
    assert values["peak"] == 4.0
    assert values["rms"] == pytest.approx(np.sqrt(22.0 / 4.0))
    assert (values["min"], values["max"]) == (-4.0, 2.0)


def test_evaluated_is_a_whole_number_of_slabs():
    rows = evaluated(rolling())
    way = rolling()["distance"].to_numpy()[rows]
    assert (way[-1] - way[0] + SPEED / 5000.0) / (BAY * COUNT) == pytest.approx(15, abs=0.01)


def accelerating(rate=4000.0):
    """Speed doubles; three orders of the bay and one of the slab."""
    time = times(3.0, rate)
    way = 40.0 * time + 6.7 * time**2
    angle = 2.0 * np.pi * way / BAY
    values = 5.0 + 3.0 * np.sin(angle) + 0.5 * np.cos(2.0 * angle) + 0.2 * np.sin(angle / COUNT)
    return run(time, way), signal(np.stack([values, 2.0 * values], axis=1), time)


def test_orders_at_changing_speed():
    data, values = accelerating()
    found = order_spectrum(data, values)
    lines = found.isel(channel=0)
    for order, amplitude in ((0.0, 5.0), (1.0, 3.0), (2.0, 0.5), (1.0 / COUNT, 0.2)):
        assert float(lines.sel(order=order, method="nearest")) == pytest.approx(amplitude, rel=1e-3)
    rest = lines.where(~np.isin(np.rint(lines["order"] * COUNT), [0, 1, COUNT, 2 * COUNT]))
    assert float(rest.max()) < 2e-3
    np.testing.assert_allclose(found.isel(channel=1), 2.0 * lines, rtol=1e-9)
    # A spectrum over time smears the same line over the speeds.
    time = data["time"].to_numpy()
    smeared = np.abs(np.fft.rfft(values[:, 0] - 5.0)) * 2.0 / time.size
    assert smeared.max() < 1.0


def test_passing_amplitudes_and_frequencies():
    data, values = accelerating()
    found = passing_amplitudes(data, values).isel(channel=0)
    assert found["sleeper"].to_numpy() == pytest.approx([3.0, 0.5, 0.0], abs=2e-3)
    assert found["slab"].to_numpy() == pytest.approx([0.2, 0.0, 0.0], abs=2e-3)
    sleeper, slab = passing_frequencies(data)
    assert sleeper[1] == pytest.approx(40.0 / BAY, rel=1e-3)
    assert slab[-2] == pytest.approx((40.0 + 13.4 * 3.0) / (BAY * COUNT), rel=1e-3)


def test_orders_need_their_lengths():
    data, values = accelerating()
    unknown = data.assign_attrs({"track.fastener.spacing": np.nan})
    with pytest.raises(ParameterError, match="fastener spacing"):
        order_spectrum(unknown, values)
    assert float(
        order_spectrum(unknown, values, spacing=BAY, period=BAY)
        .isel(channel=0)
        .sel(order=1.0, method="nearest")
    ) == pytest.approx(3.0, rel=2e-2)
    with pytest.raises(ParameterError, match="run a longer distance"):
        order_spectrum(data, values, period=500.0)
    standing = data.assign(distance=xr.zeros_like(data["distance"]))
    with pytest.raises(ParameterError, match="must grow"):
        over_distance(standing, values, step=0.1, start=0.0, stop=1.0)
    with pytest.raises(ParameterError, match="record more often"):
        order_spectrum(data.isel(time=slice(None, None, 100)), values[::100])


def test_steady_state_amplitude_leaves_high_frequencies_out():
    time = times(2.0, 10000.0)
    way = SPEED * time
    wave = 4.0 * np.sin(2.0 * np.pi * way / BAY) + 1.0 * np.sin(2.0 * np.pi * way / BAY * 8)
    data = run(time, way)
    found = steady_state_amplitude(data, signal(wave, time))
    assert float(found) == pytest.approx(4.0, rel=1e-2)
