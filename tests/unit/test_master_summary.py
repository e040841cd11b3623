"""Summary, table and picture on synthetic runs with known figures."""

import io
import math

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import ParameterError
from rail_cosim.plot import check_format, plot_run
from rail_cosim.summary import amplitudes, choose_range, dominant_frequency, spectrum, summarise
from rail_cosim.tables import summary_table
from rich.console import Console

BAY, COUNT, SPEED, STEP = 0.629, 8, 300.0 / 3.6, 1e-4
SLAB = BAY * COUNT
ATTRIBUTES = {
    "track.fastener.spacing": BAY,
    "track.fastener.count_per_slab": COUNT,
    "track.slab.length": 0.0,
    "track.slab.gap": 0.07,
    "complete": 1,
    "simulated_seconds": 1.2,
    "wall_clock_seconds": 0.8,
    "cpu_seconds": 0.75,
    "real_time_factor": 1.5,
    "interface_energy_residual_share": 1e-6,
    "interface_energy_residual_limit": 5e-3,
    "line": "HD",
    "speed_km_h": 300.0,
}


def made_run(distance=100.0, **attributes):
    """Wheel w (0-7): 70 kN, 400 (w + 1) N at the bays, 50 (w + 1) N at the slabs, a start-up."""
    time = np.arange(round(distance / (SPEED * STEP)) + 1) * STEP
    x = SPEED * time
    wheel = np.arange(8).reshape(4, 2) + 1.0
    phase = wheel
    angle = 2 * np.pi * x[:, None, None]
    force = 70e3 + 400.0 * wheel * np.sin(angle / BAY + phase)
    force += 50.0 * wheel * np.cos(angle / SLAB - phase)
    force += 5e3 * np.exp(-x / 2.0)[:, None, None]
    acceleration = 3.0 * wheel * np.cos(angle / BAY) + 0.5 * np.sin(angle / SLAB)
    dims = ("time", "wheelset", "side")
    return xr.Dataset(
        {
            "distance": ("time", x),
            "normal_force": (dims, force),
            "axle_box_vertical_acceleration": (dims, acceleration),
        },
        coords={"time": time, "wheelset": np.arange(1, 5), "side": ["left", "right"]},
        attrs=ATTRIBUTES | attributes,
    )


WHEEL = np.arange(8).reshape(4, 2) + 1.0


def test_amplitudes_at_the_passing_frequencies():
    found = summarise(made_run())
    assert found.range.periods == 9
    assert found.range.of == "slab"
    assert found.range.start == pytest.approx(100.0 - 9 * SLAB, abs=0.01)
    assert found.sleeper_frequency == pytest.approx(SPEED / BAY, rel=1e-9)
    assert found.slab_frequency == pytest.approx(SPEED / SLAB, rel=1e-9)
    assert found.force_sleeper == pytest.approx(400.0 * WHEEL, rel=1e-6)
    assert found.force_slab == pytest.approx(50.0 * WHEEL, rel=1e-6)
    assert found.acceleration_sleeper == pytest.approx(3.0 * WHEEL, rel=1e-6)
    assert found.acceleration_slab == pytest.approx(np.full((4, 2), 0.5), rel=1e-6)


def test_mean_and_extremes_of_the_evaluated_part():
    data = made_run()
    found = summarise(data)
    # One sample too many or too few moves the mean by amplitude / samples.
    assert found.force_mean == pytest.approx(np.full((4, 2), 70e3), abs=2.0)
    assert (found.force_max <= 70e3 + 450.0 * WHEEL + 1e-6).all()
    assert (found.force_max >= 70e3 + 0.9 * 400.0 * WHEEL).all()
    rows = found.range.rows
    force = data["normal_force"].to_numpy()[rows]
    assert np.array_equal(found.force_min, force.min(axis=0))
    acceleration = data["axle_box_vertical_acceleration"].to_numpy()[rows]
    assert np.array_equal(found.acceleration_max, np.abs(acceleration).max(axis=0))


def test_dominant_frequency_is_the_sleeper_passing_one():
    assert summarise(made_run()).dominant_frequency == pytest.approx(SPEED / BAY, abs=0.1)


@pytest.mark.parametrize("frequency", [88.3, 132.0, 250.5])
def test_dominant_frequency_of_a_noisy_sine(frequency):
    time = np.arange(6000) * STEP
    noise = np.random.default_rng(7).normal(0.0, 0.5, (6000, 4, 2))
    values = 5.0 + np.sin(2 * np.pi * frequency * time)[:, None, None] + noise
    assert dominant_frequency(time, values) == pytest.approx(frequency, abs=0.1)


def test_dominant_frequency_of_nothing_is_not_a_number():
    time = np.arange(100) * STEP
    assert math.isnan(dominant_frequency(time, np.ones((100, 4, 2))))
    assert math.isnan(dominant_frequency(time[:5], np.ones((5, 4, 2))))


def test_amplitude_of_a_line_of_the_spectrum():
    time = np.arange(1000) * 1e-3
    frequencies, lines = spectrum(time, 2.0 + 3.0 * np.sin(2 * np.pi * 50.0 * time))
    assert lines[np.argmin(np.abs(frequencies - 50.0))] == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize(
    ("length", "periods", "of"), [(100.0, 9, "slab"), (10.2, 1, "slab"), (6.0, 4, "bay")]
)
def test_range_is_a_whole_number_of_slabs_or_bays_of_the_second_half(length, periods, of):
    x = np.arange(round(length / 0.01) + 1) * 0.01
    chosen = choose_range(x, BAY, SLAB)
    assert (chosen.periods, chosen.of) == (periods, of)
    period = SLAB if of == "slab" else BAY
    assert chosen.stop - chosen.start == pytest.approx(periods * period)
    assert len(x[chosen.rows]) == pytest.approx(periods * period / 0.01, abs=1)
    assert f"{periods} whole {of} length" in chosen.text


@pytest.mark.parametrize(("bay", "slab"), [(math.nan, math.nan), (BAY, SLAB)])
def test_range_without_a_period_is_the_second_half(bay, slab):
    chosen = choose_range(np.linspace(0.0, 1.0, 101), bay, slab)
    assert chosen.periods == 0
    assert chosen.start == pytest.approx(0.5)
    assert "whole" not in chosen.text


def test_slab_pitch_is_that_of_the_fasteners_where_a_length_is_set():
    """A shorter slab leaves a wider gap: slab.gap only derives a length that is not set."""
    data = made_run(**{"track.slab.length": 4.93, "track.slab.gap": 0.07})
    assert summarise(data).slab_frequency == pytest.approx(SPEED / SLAB)


def test_short_run_has_no_slab_amplitude():
    found = summarise(made_run(distance=6.0))
    assert found.range.of == "bay"
    assert np.isnan(found.force_slab).all()
    assert np.isfinite(found.force_sleeper).all()


def test_a_run_of_a_foreign_track_has_forces_but_no_amplitudes():
    data = made_run()
    data.attrs = {k: v for k, v in data.attrs.items() if not k.startswith("track.")}
    found = summarise(data.drop_vars("axle_box_vertical_acceleration"))
    assert np.isfinite(found.force_mean).all()
    assert np.isnan(found.force_sleeper).all()
    assert np.isnan(found.acceleration_max).all()
    assert " nan" not in table_text(found, data)


def test_a_wheel_without_a_record_is_left_out():
    x = np.linspace(0.0, SLAB, 1001)
    values = np.tile(2.0 * np.sin(2 * np.pi * x / BAY)[:, None, None], (1, 2, 1))
    values[3, 1] = np.nan
    found = amplitudes(x, values, [BAY])[0]
    assert found[0, 0] == pytest.approx(2.0)
    assert np.isnan(found[1, 0])
    time = x / SPEED
    assert dominant_frequency(time, values) == pytest.approx(SPEED / BAY, rel=0.01)


def test_a_vehicle_without_its_position_has_run_speed_times_time(tmp_path):
    data = made_run()
    found, without = summarise(data), summarise(data.drop_vars("distance"))
    assert without.range.periods == found.range.periods
    assert without.force_sleeper == pytest.approx(found.force_sleeper, rel=1e-6)
    plot_run(data.drop_vars("distance"), without, tmp_path / "run.svg")
    assert "</svg>" in (tmp_path / "run.svg").read_text()


def test_a_run_of_one_record_cannot_be_summarised():
    with pytest.raises(ValueError, match="fewer than two records"):
        summarise(made_run().isel(time=slice(0, 1)))


def table_text(found, data):
    console = Console(width=140, file=io.StringIO())
    console.print(summary_table(found, data))
    return console.file.getvalue()


def test_table_states_range_forces_frequencies_and_speed():
    data = made_run()
    text = table_text(summarise(data), data)
    for expected in ("9 whole slab lengths", "132.5 Hz", "16.6 Hz", "4 right", "3.200", "0.400"):
        assert expected in text
    assert "1.50: 1.200 s in 0.800 s (processor 0.750 s)" in text
    assert "incomplete" not in text


def test_table_of_an_incomplete_run_says_so():
    data = made_run(complete=0, steps=999, steps_planned=2400)
    assert "incomplete run: 999 of 2400 steps" in table_text(summarise(data), data)


@pytest.mark.parametrize(("ending", "magic"), [(".png", b"\x89PNG"), (".pdf", b"%PDF")])
def test_picture_is_drawn(tmp_path, ending, magic):
    data = made_run()
    path = tmp_path / f"run{ending}"
    plot_run(data, summarise(data), path)
    assert path.read_bytes().startswith(magic)


def test_picture_in_an_unknown_format_is_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"run\.docx': must end in \.png or \.pdf or \.svg"):
        check_format(tmp_path / "run.docx")
