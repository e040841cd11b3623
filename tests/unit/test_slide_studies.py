"""Studies of the sliding window: places, differences and verdicts, without running anything."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.studies import fig05, fig06, slide
from rail_cosim.studies.base import StudyOptions
from rail_cosim.studies.track_frequency import TrackTable


def test_joint_lies_where_the_window_of_the_track_slides():
    from slab_track import TrackParameters
    from slab_track.window import place_window

    x = fig06.joint_position(12.0)
    assert 12.0 <= x < 17.1
    places = np.array([0.0, -2.5, -17.8, -20.3])
    p = TrackParameters()
    before, after = (place_window(p, places + x + d) for d in (-1e-6, 1e-6))
    assert after - before == pytest.approx(p.pitch)


def test_fig06_judges_peak_and_history(tmp_path):
    way = np.linspace(0.0, 1.0, 50)
    base = np.full((50, 4, 2), 70e3)
    base[20] = 200e3
    late, high = base.copy(), base.copy()
    late[40, 3, 1] += 50.0  # 0.07 % of the load, far from the peak
    high[20] += 100.0  # 0.05 % of the peak
    forces = {"moving_mass": base, "same": base.copy(), "late": late, "high": high}
    dataset = fig06.as_dataset(forces, way, 15.0, StudyOptions(out=tmp_path))
    assert dataset["difference"].max("distance").to_numpy() == pytest.approx([0, 0, 50, 100])
    _, conclusion = fig06.report(dataset)
    assert conclusion.endswith("beyond it: late, high")


def test_slide_passes_below_its_limits_only():
    assert slide.passes("default", 6.9, 70e3) == "pass"
    assert slide.passes("default", 7.1, 70e3) == "FAIL"
    assert slide.passes("ring", 7e3, 70e3) == ""
    found = {"default": xr.DataArray([0.0, 9.0], dims="distance", coords={"distance": [0.0, 1.0]})}
    assert slide.conclude(found, 70e3).endswith("FAIL")


def _fields(way_growth):
    place = np.linspace(0.0, 65.0, 11)
    target = np.array([np.sin(place), 10.0 * np.sin(place)])
    after = np.array([target * (1.0 + growth) for growth in way_growth])
    columns = {
        "place": place,
        "target": target,
        "after": after,
        "condition_number": np.ones(4),
        "rotation_condition_number": np.ones(4),
        "wheel_force_jump": np.zeros(4),
    }
    return TrackTable({}, {}, columns)


@pytest.mark.parametrize(
    ("growth", "verdicts"),
    [
        ((0.01, 0.0, 1e9, np.nan), "pass; the triangular solve diverges: pass"),
        ((3.0, 0.0, 1e9, 0.0), "FAIL; the triangular solve diverges: pass"),
        ((0.0, 0.0, 0.5, 0.0), "pass; the triangular solve diverges: FAIL"),
    ],
)
def test_fig05_tells_a_field_that_diverges(growth, verdicts, tmp_path):
    found = {"paper": _fields(growth), "default": _fields((0.0, 0.0, 0.0, 0.0))}
    dataset = fig05.as_dataset(found, StudyOptions(out=tmp_path))
    table, conclusion = fig05.report(dataset)
    assert table.row_count == 8
    assert f"least squares does not diverge: {verdicts}" in conclusion
    assert dataset["deflection_jump"].sel(setting="paper").to_numpy()[0] == pytest.approx(
        growth[0] * np.abs(np.sin(dataset["place"])).max()
    )


def test_conditions_of_eq_10_at_the_sample_points():
    """Sines at the middle of segments are orthogonal, but the last cosine vanishes there."""
    from slab_track import HD
    from slab_track.rail import vertical_modes
    from slab_track.slide_study import way_points

    length, count = HD.window_length, HD.rail_mode_count
    waves = vertical_modes(HD.rail, length).waves
    condition = {
        name: np.linalg.cond(waves.shapes(way_points(name, length, count, 394)))
        for name in fig05.WAYS
    }
    assert condition["least_squares"] == pytest.approx(1.0, abs=1e-9)
    assert condition["middle"] == pytest.approx(np.sqrt(2.0), abs=1e-9)
    middle = way_points("middle", length, count, 394)
    assert np.max(np.abs(waves.rotation_shapes(middle)[-1])) < 1e-9  # the rotation's is singular
    assert condition["hinges"] > 1e10
    assert condition["end_left_out"] > 1e10
