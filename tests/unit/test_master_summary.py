"""Summary, table and picture on synthetic runs with known figures."""

import io
import math
import re

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import ParameterError
from rail_cosim.plot import check_format, plot_run
from rail_cosim.summary import amplitudes, dominant_frequency, spectrum, summarise
from rail_cosim.tables import summary_table
from rail_cosim.window import choose_window
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


def figure(summary, name):
    return summary[name].to_numpy()


WHEEL = np.arange(8).reshape(4, 2) + 1.0


def test_amplitudes_at_the_passing_frequencies():
    found = summarise(made_run())
    assert found.window.periods == 9
    assert found.window.of == "slab"
    assert found.window.start == pytest.approx(100.0 - 9 * SLAB, abs=0.01)
    assert found.fastener_passing_frequency == pytest.approx(SPEED / BAY, rel=1e-9)
    assert found.slab_passing_frequency == pytest.approx(SPEED / SLAB, rel=1e-9)
    assert figure(found, "wheel_force_fastener_passing_amplitude") == pytest.approx(
        400.0 * WHEEL, rel=1e-6
    )
    assert figure(found, "wheel_force_slab_passing_amplitude") == pytest.approx(
        50.0 * WHEEL, rel=1e-6
    )
    assert figure(found, "axle_box_acceleration_fastener_passing_amplitude") == pytest.approx(
        3.0 * WHEEL, rel=1e-6
    )
    assert figure(found, "axle_box_acceleration_slab_passing_amplitude") == pytest.approx(
        np.full((4, 2), 0.5), rel=1e-6
    )


def test_mean_and_extremes_of_the_evaluation_window():
    data = made_run()
    found = summarise(data)
    # One sample too many or too few moves the mean by amplitude / samples.
    assert figure(found, "wheel_force_mean") == pytest.approx(np.full((4, 2), 70e3), abs=2.0)
    assert (figure(found, "wheel_force_window_max") <= 70e3 + 450.0 * WHEEL + 1e-6).all()
    assert (figure(found, "wheel_force_window_max") >= 70e3 + 0.9 * 400.0 * WHEEL).all()
    rows = found.window.rows
    force = data["normal_force"].to_numpy()[rows]
    assert np.array_equal(figure(found, "wheel_force_window_min"), force.min(axis=0))
    acceleration = data["axle_box_vertical_acceleration"].to_numpy()[rows]
    peak = figure(found, "axle_box_acceleration_window_peak")
    assert np.array_equal(peak, np.abs(acceleration).max(axis=0))


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
def test_window_is_a_whole_number_of_slabs_or_bays_of_the_second_half(length, periods, of):
    x = np.arange(round(length / 0.01) + 1) * 0.01
    chosen = choose_window(x, BAY, SLAB)
    assert (chosen.periods, chosen.of) == (periods, of)
    period = SLAB if of == "slab" else BAY
    assert chosen.stop - chosen.start == pytest.approx(periods * period)
    assert len(x[chosen.rows]) == pytest.approx(periods * period / 0.01, abs=1)
    assert f"{periods} whole {of} length" in chosen.text


@pytest.mark.parametrize(("bay", "slab"), [(math.nan, math.nan), (BAY, SLAB)])
def test_window_without_a_period_is_the_second_half(bay, slab):
    chosen = choose_window(np.linspace(0.0, 1.0, 101), bay, slab)
    assert chosen.periods == 0
    assert chosen.start == pytest.approx(0.5)
    assert "whole" not in chosen.text


def test_slab_pitch_is_that_of_the_fasteners_where_a_length_is_set():
    """A shorter slab leaves a wider gap: slab.gap only derives a length that is not set."""
    data = made_run(**{"track.slab.length": 4.93, "track.slab.gap": 0.07})
    assert summarise(data).slab_passing_frequency == pytest.approx(SPEED / SLAB)


def test_short_run_has_no_slab_amplitude():
    found = summarise(made_run(distance=6.0))
    assert found.window.of == "bay"
    assert np.isnan(figure(found, "wheel_force_slab_passing_amplitude")).all()
    assert np.isfinite(figure(found, "wheel_force_fastener_passing_amplitude")).all()


def test_a_run_of_a_foreign_track_has_forces_but_no_amplitudes():
    data = made_run()
    data.attrs = {k: v for k, v in data.attrs.items() if not k.startswith("track.")}
    found = summarise(data.drop_vars("axle_box_vertical_acceleration"))
    assert np.isfinite(figure(found, "wheel_force_mean")).all()
    assert np.isnan(figure(found, "wheel_force_fastener_passing_amplitude")).all()
    assert "axle_box_acceleration_peak" not in found.data
    assert found.state == "not tested for a steady state (the slab length is not known)"
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
    assert without.window.periods == found.window.periods
    assert figure(without, "wheel_force_fastener_passing_amplitude") == pytest.approx(
        figure(found, "wheel_force_fastener_passing_amplitude"), rel=1e-6
    )
    plot_run(data.drop_vars("distance"), without, tmp_path / "run.svg")
    assert "</svg>" in (tmp_path / "run.svg").read_text()


def test_a_run_of_one_record_cannot_be_summarised():
    with pytest.raises(ValueError, match="fewer than two records"):
        summarise(made_run().isel(time=slice(0, 1)))


def table_text(found, data):
    console = Console(width=140, file=io.StringIO())
    console.print(summary_table(found, data))
    return console.file.getvalue()


def test_table_states_window_forces_frequencies_and_speed():
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


# The whole run: extremes, losses of contact, events outside the window.

JOINT = 21.0  # m; the wheels of wheelset w come there 2.5 m later each


def joint_run(distance=100.0, **attributes):
    """Each wheel hits a joint, and the leading left one leaves the rail twice."""
    data = made_run(distance, **attributes)
    x = data["distance"].to_numpy()
    for wheelset in range(4):
        hit = np.abs(x - JOINT - 2.5 * wheelset) < 0.2
        data["normal_force"][hit, wheelset] += 1e5 + 1e3 * wheelset
        data["axle_box_vertical_acceleration"][hit, wheelset, 1] -= 160.0
    data["normal_force"][2000:2007, 0, 0] = 0.0
    data["normal_force"][2010:2013, 0, 0] = -1.0
    return data


@pytest.mark.parametrize("chunk", [100, 2005, 10**6])
def test_extremes_are_those_of_all_records(monkeypatch, chunk):
    """Computed here record by record; the summary reads them part by part."""
    monkeypatch.setattr("rail_cosim.extremes.CHUNK", chunk)
    data = joint_run()
    found = summarise(data)
    assert found.window.start > 50.0
    x = data["distance"].to_numpy()
    for wheelset in range(4):
        for side in range(2):
            force = data["normal_force"].to_numpy()[:, wheelset, side].tolist()
            box = data["axle_box_vertical_acceleration"].to_numpy()[:, wheelset, side].tolist()
            for name, values, chosen in (
                ("wheel_force_max", force, max(force)),
                ("wheel_force_min", force, min(force)),
                ("axle_box_acceleration_peak", list(map(abs, box)), max(map(abs, box))),
            ):
                assert figure(found, name)[wheelset, side] == chosen
                where = figure(found, f"{name}_distance")[wheelset, side]
                assert where == x[values.index(chosen)]
    assert figure(found, "wheel_force_max").max() > 170e3


@pytest.mark.parametrize("chunk", [2003, 10**6])
def test_losses_of_contact_are_counted_and_timed(monkeypatch, chunk):
    """Seven and three records 0.1 ms apart; the first loss goes over the edge of a part."""
    monkeypatch.setattr("rail_cosim.extremes.CHUNK", chunk)
    found = summarise(joint_run())
    first = {"wheelset": 1, "side": "left"}
    assert int(found["loss_of_contact_count"].sel(first)) == 2
    assert float(found["loss_of_contact_longest"].sel(first)) == pytest.approx(7e-4)
    assert float(found["loss_of_contact_total"].sel(first)) == pytest.approx(10e-4)
    assert int(found["loss_of_contact_count"].sum()) == 2


def test_an_event_before_the_records_of_the_window_is_not_hidden(monkeypatch):
    monkeypatch.setattr("rail_cosim.window.LONGEST", 3000)
    data = joint_run()
    found = summarise(data)
    assert found.window.start > 75.0
    assert data["distance"].to_numpy()[found.window.rows][-1] == pytest.approx(100.0, abs=0.01)
    assert float(found["wheel_force_max"].max()) == float(data["normal_force"].max())


def test_a_wheel_that_is_not_a_number_has_no_extremes():
    data = joint_run()
    data["normal_force"][:, 2, 1] = math.nan
    data["normal_force"][:20, 1, 1] = math.nan
    found = summarise(data)
    assert math.isnan(figure(found, "wheel_force_max")[2, 1])
    expected = np.nanmax(data["normal_force"].to_numpy()[:, 1, 1])
    assert figure(found, "wheel_force_max")[1, 1] == expected
    assert figure(found, "loss_of_contact_count")[2, 1] == 0


def test_what_happened_outside_the_window_is_said():
    found = summarise(joint_run())
    force, least, lost, box = found.events
    # The fourth wheelset hits hardest, at 21 + 7.5 m.
    assert force.startswith("largest wheel force 17")
    assert re.search(r"at 28\.\d\d m \(wheel 4 (left|right); in the window 7", force)
    assert least.startswith("smallest wheel force -0.001 kN at 16.75 m (wheel 1 left; in the")
    assert lost == "loss of contact (wheel 1 left)"
    assert re.match(r"peak axle-box acceleration 18\d\..* right; in the window", box)


def test_what_happened_inside_the_window_is_no_event_outside_it():
    data = joint_run()
    data["normal_force"][9000:9020, :, :] = 300e3
    data["normal_force"][9030:9050, :, :] = -1.0
    data["axle_box_vertical_acceleration"][9000, :, :] = 400.0
    found = summarise(data)
    assert found.events == ["loss of contact (wheel 1 left)"]
    data["normal_force"][2000:2013, 0, 0] = 70e3
    assert summarise(data).events == []


def test_the_start_of_an_ordinary_run_is_no_event():
    """A start-up of 2 kN, as far beyond the window as that of a real run."""
    data = made_run()
    data["normal_force"] -= 3e3 * np.exp(-data["distance"] / 2.0)
    assert summarise(data).events == []


def test_steady_is_what_repeats_from_slab_to_slab():
    found = summarise(made_run())
    assert found.steady
    assert found.state == f"steady (change {100 * found.change:.2g} % from slab to slab)"
    assert found.change < 1e-3


def test_a_motion_that_decays_over_the_window_is_not_steady():
    """exp(-x/20) 5 kN more: the change over the first slab of the window in closed form."""
    data = made_run().drop_vars("axle_box_vertical_acceleration")
    x = data["distance"].to_numpy()
    data["normal_force"] += 5e3 * np.exp(-x / 20.0)[:, None, None]
    found = summarise(data)
    assert not found.steady
    start = found.window.start
    now = data["normal_force"].to_numpy()[(x > start) & (x <= start + SLAB)]
    decay = 5e3 * np.exp(-x[(x > start) & (x <= start + SLAB)] / 20.0)
    change = decay * (1.0 - np.exp(SLAB / 20.0))
    expected = np.sqrt(np.mean(change**2) / np.mean((now - now.mean(axis=0)) ** 2))
    assert found.change == pytest.approx(expected, rel=1e-2)
    assert found.state == f"not steady (change {100 * expected:.2g} % from slab to slab)"


def test_a_run_that_was_asked_to_become_steady_is_judged_by_what_was_asked():
    data = made_run()
    data["normal_force"] *= 1.0 + 2e-6 * data["distance"]
    assert summarise(data).steady
    data.attrs |= {"steady": 0, "steady_tolerance": 1e-4}
    assert not summarise(data).steady
    data.attrs["steady"] = 1
    window = summarise(data).window
    assert (window.periods, window.of) == (2, "slab")
    assert window.stop - window.start == pytest.approx(2 * SLAB, abs=SPEED * STEP)


def test_a_run_at_changing_speed_is_not_called_steady():
    found = summarise(made_run(final_speed_km_h=350.0))
    assert not found.steady
    assert found.state == "not steady (the speed changes)"


def test_a_run_shorter_than_two_slabs_is_not_called_steady():
    found = summarise(made_run(distance=6.0))
    assert not found.steady
    assert "shorter than two slab lengths" in found.state


def test_every_figure_tells_its_unit_meaning_and_window(tmp_path):
    found = summarise(joint_run())
    data = found.to_dataset()
    for name, array in data.data_vars.items():
        assert array.dims == ("wheelset", "side"), name
        assert array.attrs["units"] in ("N", "m", "m/s2", "s", "1"), name
        assert array.attrs["long_name"], name
        whole = array.attrs["evaluated_over"] == "whole run, 0.00 to 100.00 m"
        window = array.attrs["evaluated_over"] == f"evaluation window, {found.window.text}"
        assert whole != window, name
    assert data["side"].to_numpy().tolist() == ["left", "right"]
    data.to_netcdf(tmp_path / "summary.nc", engine="h5netcdf")
    assert data.attrs["steady"] == 1


def test_a_summary_shows_itself():
    data = joint_run()
    text = repr(summarise(data))
    assert text == str(summarise(data))
    for expected in (
        "Whole run, distance travelled 0.00 to 100.00 m",
        "wheel 1 left: 2 times, longest 0.7 ms, total 1 ms",
        "steady (change ",
        "Outside the evaluation window:",
        "largest wheel force 17",
    ):
        assert expected in text
    assert max(map(len, text.splitlines())) <= 100


def test_no_loss_of_contact_is_said():
    assert "loss of contact  none" in str(summarise(made_run()))


def test_what_is_not_recorded_is_said():
    data = made_run()
    without = summarise(data.drop_vars("normal_force"))
    assert "loss of contact  not recorded" in str(without)
    assert "wheel_force_max" not in without.data
    nothing = summarise(data[["distance"]])
    assert "wheel forces and accelerations not recorded" in str(nothing)
