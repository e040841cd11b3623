"""Studies of the sliding window: places, differences and verdicts, without running anything."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.studies import fig06, slide
from rail_cosim.studies.base import StudyOptions


def test_joint_lies_where_the_window_of_the_track_slides():
    from slab_track import TrackParameters
    from slab_track.window import place_window

    x = fig06.joint_position(13, 12.0)
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
