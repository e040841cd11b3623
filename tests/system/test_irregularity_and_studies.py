"""``rail-cosim run --irregularity`` and ``rail-cosim study`` with the real FMUs."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.reporting import page
from rail_cosim.sweeps.quantities import evaluate
from runs import run

# The options are tested here, not the mechanics: few modes and long steps.
COARSE = (
    "track.contact.model=profiles",
    "track.rail.motion=vertical",
    "track.rail.mode_count=100",
    "track.slab.mode_count=12",
    "track.integration.maximum_step=5e-4",
)
SETTINGS = [word for text in COARSE for word in ("--set", text)]
NEAR = ["--set", "track.irregularity.rail_joint.position=4"]
SHORT = ["--distance", 8, "--macro-step", 5e-4, *SETTINGS]


def peak(done):
    force = done["normal_force"]
    return np.abs(force - done.data.attrs["track.static_wheel_load"]).max()


def _agree(joint):
    """Summary, report and sweep statistics tell what the file has, wherever it happened."""
    force, boxes = joint["normal_force"], np.abs(joint["axle_box_vertical_acceleration"])
    assert f"{force.max() / 1e3:.3f}" in joint.out
    assert f"{boxes.max():.3f}" in joint.out
    text = page(joint.data)
    assert f'<td class="number">{force.max() / 1e3:.4g}</td>' in text
    assert f'<td class="number">{boxes.max():.4g}</td>' in text
    keep = {"normal_force": ["max", "min"], "axle_box_vertical_acceleration": ["peak"]}
    found = evaluate(joint.data, keep)
    np.testing.assert_array_equal(found["normal_force_max"], force.max(axis=0))
    np.testing.assert_array_equal(found["normal_force_min"], force.min(axis=0))
    peaks = found["axle_box_vertical_acceleration_peak"]
    np.testing.assert_array_equal(peaks, boxes.max(axis=0))


def test_a_rail_joint_and_a_spectrum_are_felt(fmus, tmp_path):
    smooth = run(fmus, tmp_path, *SHORT)
    joint = run(fmus, tmp_path, *SHORT, "--irregularity", "rail_joint", *NEAR)
    about = joint.data.attrs
    assert about["track.irregularity.rail_joint.side"] == "both"
    assert about["track.irregularity.rail_joint.position"] == 4.0
    assert peak(joint) > 2.0 * peak(smooth)
    leading = np.abs(joint["normal_force"] - smooth["normal_force"])[:, 0, 0]
    assert joint["distance"][leading.argmax()] == pytest.approx(4.0, abs=1.0)

    _agree(joint)

    seed = ["--set", "track.irregularity.seed=2", "--set", "track.irregularity.ramp_length=1"]
    random = run(fmus, tmp_path, *SHORT, "--irregularity", "german_high", *seed)
    assert random.data.attrs["track.irregularity.spectrum"] == "german_high"
    assert random.data.attrs["track.irregularity.seed"] == 2
    assert peak(random) > 2.0 * peak(smooth)


def test_an_unknown_irregularity_is_told_with_the_names(fmus):
    done = fmus.invoke("run", "--irregularity", "german_lo", status=(2,))
    assert "did you mean german_low or german_high?" in done.stderr
    assert "chinese_ballastless, rail_joint" in done.stderr


def test_wheels_set_apart_are_warned_of(fmus, tmp_path):
    short = ["--distance", 0.5, "--macro-step", 5e-4, *SETTINGS]
    radius = ["--set", "vehicle.wheelset.radius=0.43"]
    done = run(fmus, tmp_path, *short, *radius, "--line", "HD")
    assert done.data.attrs["track.contact.wheel_radius"] == 0.43
    assert "wheel_radius" not in done.err
    done = run(fmus, tmp_path, *short, *radius, "--set", "track.contact.wheel_radius=0.46")
    assert "warning: track.contact.wheel_radius = 0.46 m" in done.err
    assert "track.contact.wheel_radius = 0.46 m" in done.data.attrs["remarks"]


def test_a_start_on_a_file_is_at_rest_and_told(fmus, tmp_path):
    """Both rails are 2 mm lower from the start on, 20 m before the file, and stay so."""
    path = tmp_path / "low.csv"
    path.write_text("distance,level\n-60,2e-3\n60,2e-3\n")
    start = ["--distance", 0.5, "--macro-step", 5e-4, *SETTINGS]
    full = [*start, "--irregularity", path, "--set", "track.irregularity.ramp_length=0"]
    done, smooth = run(fmus, tmp_path, *full), run(fmus, tmp_path, *start)
    assert "The run starts on the irregularity: up to 2 mm under the wheels" in done.err
    assert "starts on the irregularity" in done.data.attrs["remarks"]
    assert done["normal_force"] == pytest.approx(smooth["normal_force"], abs=1.0)


@pytest.mark.slow
def test_critical_speed_of_the_default_pair(fmus, tmp_path):
    done = fmus.command("study", "critical-speed", "--quick", "--out", tmp_path)
    with xr.open_dataset(tmp_path / "critical_speed.nc", engine="h5netcdf") as file:
        found = file.load()
    # Between 425 and 450 km/h when this was written (single runs, the same with all modes and
    # short steps at 450 km/h).
    assert 375.0 <= found.attrs["highest_stable_speed_km_h"] <= 475.0
    assert 400.0 <= found.attrs["lowest_unstable_speed_km_h"] <= 500.0
    assert "critical speed" in done.stdout
    assert (tmp_path / "critical_speed.png").stat().st_size > 10_000


def test_table_1_is_measured_with_both_fmus(fmus, tmp_path):
    few = ["--set", "track.slab.mode_count=12", "--set", "track.rail.motion=vertical"]
    done = fmus.command("study", "table1", "--quick", "--out", tmp_path, *few)
    assert "of 9 ratings of the article are found" in " ".join(done.stdout.split())
    with xr.open_dataset(tmp_path / "table1.nc", engine="h5netcdf") as file:
        found = file.load()
    assert 15.0 < float(found["way"].sel(model="moving_mass")) < 25.0
    share = found["sleeper_amplitude"] / found["sleeper_amplitude"].sel(model="sliding")
    assert float(share.sel(model="moving_irregularity")) < 0.01
    assert float(share.sel(model="moving_mass")) == pytest.approx(1.0, abs=1e-3)
    load = found.attrs["static_wheel_load"]
    assert float(found["difference"].sel(model="moving_mass_long")) < 1e-4 * load
    assert float(found["difference"].sel(model="cyclic")) < 3e-4 * load
    assert (found["state_size"] > 10_000).all()
