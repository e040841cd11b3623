"""``rail-cosim run``: the article's nominal case, HD line, 300 km/h, 100 m, end to end."""

import fmpy
import numpy as np
import pytest
from product import Product
from rail_cosim import summarise
from runs import golden_amplitudes, run

LOAD = 69.21e3  # N, static: (44039 + 2 * 2439 + 4 * 1881) kg * 9.81 m/s2 / 8
SPACING, PITCH = 0.629, 8 * 0.629
SPEED = 300.0 / 3.6
PASSING = SPEED / SPACING  # 132.5 Hz

WITHOUT_SLIDES = [
    "--set=track.window.method=moving_mass",
    "--set=track.window.slab_count=20",
]


@pytest.fixture(scope="module")
def nominal(fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("nominal")
    options = ["--line", "HD", "--speed", 300, "--distance", 100, "--plot", folder / "run.png"]
    return run(fmus, folder, *options)


def test_mean_force_is_the_static_load(nominal):
    evaluated = summarise(nominal.data)
    assert evaluated["wheel_force_mean"].to_numpy() == pytest.approx(LOAD, rel=1e-3)
    assert evaluated.steady
    assert evaluated.events == []
    assert nominal["normal_force"].mean(axis=0) == pytest.approx(LOAD, rel=1e-3)


def test_it_starts_in_equilibrium(nominal):
    """Each wheelset at its own static height, so each wheel carries the static load."""
    # Tilted by the contact angle: the normal force is a little more than the load.
    assert nominal["normal_force"][0] == pytest.approx(LOAD, rel=1e-3)
    assert np.abs(nominal["axle_box_vertical_acceleration"][0]).max() < 1e-2


def test_left_and_right_are_equal(nominal):
    force = nominal["normal_force"]
    assert np.abs(force[..., 0] - force[..., 1]).max() < 1e-3 * LOAD


def test_passing_frequency_leads_the_axle_box_spectrum(nominal):
    time, boxes = nominal["time"], nominal["axle_box_vertical_acceleration"]
    late = boxes[len(time) // 2 :].reshape(-1, 8)
    lines = np.abs(np.fft.rfft(late * np.hanning(len(late))[:, None], axis=0)) ** 2
    frequencies = np.fft.rfftfreq(len(late), time[1] - time[0])
    resolution = frequencies[1]
    assert frequencies[lines.sum(axis=1).argmax()] == pytest.approx(PASSING, abs=resolution)
    assert summarise(nominal.data).dominant_frequency == pytest.approx(PASSING, abs=0.5)
    assert "132.5 Hz in the axle-box accelerations" in nominal.out


def test_amplitudes_are_those_of_the_finite_element_track(nominal):
    expected, error = golden_amplitudes(300.0, 40e6)
    found = nominal.amplitude("normal_force", PITCH)
    assert found == pytest.approx(expected[:, None].repeat(2, axis=1), rel=0.01 + error)


def test_printed_summary_is_that_of_the_file(nominal):
    evaluated = summarise(nominal.data)
    assert "9 whole slab lengths" in nominal.out
    assert evaluated.state in nominal.out
    for name, table in (("wheel_force_max", 0), ("wheel_force_mean", 1)):
        for number, row in enumerate(evaluated[name].to_numpy(), start=1):
            for side, force in zip(("left", "right"), row, strict=True):
                lines = [t for t in nominal.out.splitlines() if f" {number} {side} " in t]
                assert f" {force / 1e3:.3f} " in lines[table]
    assert "loss of contact" in nominal.out
    assert "real-time factor" in nominal.out
    assert "Traceback" not in nominal.err


def test_the_way_is_covered_and_the_window_follows(nominal):
    assert nominal["distance"][-1] == pytest.approx(100.0, abs=SPEED * 1e-4)
    assert nominal["distance"][-1] > 60.0
    assert len(nominal.slides) >= 11
    assert len(nominal.slides) == pytest.approx(100.0 / PITCH, abs=1.0)
    assert nominal.slides == pytest.approx(PITCH, abs=1e-9)
    assert nominal["window_slide_count"][-1] == len(nominal.slides)


def test_no_trace_of_the_slides_in_the_wheel_force(nominal, fmus, tmp_path):
    """Against the same run in a longer window that stays where it is."""
    staying = run(fmus, tmp_path, "--line", "HD", "--speed", 300, "--distance", 25, *WITHOUT_SLIDES)
    rows = staying.data.sizes["time"]
    assert len(staying.slides) == 0
    assert np.ptp(nominal["window_start_position"][:rows]) == pytest.approx(5 * PITCH, abs=1e-9)
    difference = nominal["normal_force"][:rows] - staying["normal_force"]
    assert np.abs(difference).max() < 1e-4 * LOAD


def test_slide_residual_is_small_against_the_deflection(nominal):
    deflection = np.abs(nominal["rail_vertical_displacement"]).max()
    residual = nominal["window_slide_residual"]
    assert residual[0] == 0.0
    assert 0.0 < residual.max() < 1e-3 * deflection


CONTENT = {
    "normal_force": (("time", "wheelset", "side"), "N"),
    "axle_box_vertical_acceleration": (("time", "wheelset", "side"), "m/s2"),
    "wheelset_vertical_displacement": (("time", "wheelset"), "m"),
    "rail_vertical_displacement": (("time", "wheelset", "side"), "m"),
    "bogie_vertical_acceleration": (("time", "bogie"), "m/s2"),
    "car_body_vertical_acceleration": (("time",), "m/s2"),
    "distance": (("time",), "m"),
    "primary_suspension_vertical_deflection": (("time", "wheelset", "side"), "m"),
    "secondary_suspension_vertical_deflection": (("time", "bogie", "side"), "m"),
    "window_start_position": (("time",), "m"),
}


def test_file_has_the_variables_with_dimensions_and_units(nominal):
    data = nominal.data
    found = {name: (data[name].dims, data[name].attrs["units"]) for name in CONTENT}
    assert found == CONTENT
    sizes = {"time": 12001, "wheelset": 4, "side": 2, "bogie": 2}
    assert {name: data.sizes[name] for name in sizes} == sizes
    assert data["side"].values.tolist() == ["left", "right"]
    assert data["wheelset"].values.tolist() == [1, 2, 3, 4]
    assert nominal["time"] == pytest.approx(1e-4 * np.arange(12001), abs=1e-12)


def test_each_variable_says_its_unit_and_meaning(nominal):
    for name, variable in nominal.data.variables.items():
        if name in nominal.data.dims and name != "time":
            continue
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
        assert np.isfinite(variable).all(), name


def test_file_says_how_it_was_made(nominal, fmus: Product):
    about = nominal.data.attrs
    assert about["complete"] == 1
    assert about["ended_by"] == ""
    assert about["steps"] == about["steps_planned"] == 12000
    assert about["macro_step"] == 1e-4
    assert about["algorithm"] == "gauss-seidel"
    assert about["line"] == "HD"
    assert about["speed_km_h"] == pytest.approx(300.0)
    assert about["command"].startswith("rail-cosim run --line HD --speed 300 --distance 100")
    assert about["source"].startswith("rail-cosim ")
    assert 0.0 < about["interface_energy_residual_share"] < about["interface_energy_residual_limit"]
    for name in ("track", "vehicle"):
        description = fmpy.read_model_description(str(getattr(fmus, name)))
        assert about[f"{name}_guid"] == description.guid
        parameters = [v.name for v in description.modelVariables if v.causality == "parameter"]
        assert [p for p in parameters if f"{name}.{p}" not in about] == []


def test_picture_is_written(nominal):
    picture = (nominal.folder / "run.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 50_000
