"""``python -m slab_track.verification``, ``rail_vehicle.verification``, and the whole report."""

import json
import re
import subprocess
import sys
from html import unescape

import numpy as np
import pytest
from rail_cosim.builder import child_environment
from rail_cosim.verification.rows import from_json
from slab_track.contact import kalker
from slab_track.verification.kalker_table import kalker_table
from slab_track.verification.rail import critical_speed


@pytest.fixture(scope="module", params=["slab_track", "rail_vehicle"])
def printed(request):
    done = subprocess.run(
        [sys.executable, "-m", f"{request.param}.verification"],
        capture_output=True,
        text=True,
        check=True,
        env=child_environment(),
    )
    return request.param, json.loads(done.stdout)


SECTIONS = {
    "slab_track": ["Rail", "Slab", "Contact", "P2 resonance", "Irregularities"],
    "rail_vehicle": ["Vehicle"],
}


def test_components_print_rows_that_pass(printed):
    package, content = printed
    values = from_json(content)
    assert list(values.sections) == SECTIONS[package]
    assert values.failed == []
    assert values.judged >= len(values.rows) - 2
    for row in values.rows:
        assert len(row.source) > 20, row.name
        assert row.unit, row.name
    names = [(row.section, row.name) for row in values.rows]
    assert len(set(names)) == len(names)


def test_values_follow_the_parameters():
    """The rows are computed: on a lighter rail the waves are faster."""
    from rail_quantities import with_values
    from slab_track import HD

    lighter = with_values(HD, {"rail.density": 0.25 * 7860.0})
    assert critical_speed(lighter) == pytest.approx(2.0 * critical_speed(HD), rel=1e-9)


def test_a_wrong_digit_in_kalkers_coefficients_fails(monkeypatch):
    from slab_track.verification.contact import contact_rows

    kalker._spline.cache_clear()
    wrong = [*kalker._C22_LONG]
    wrong[4] = (4.37, 4.91, 5.56)
    monkeypatch.setattr(kalker, "_C22_LONG", wrong)
    try:
        (row,) = [row for row in contact_rows() if row.name.startswith("Kalker")]
    finally:
        kalker._spline.cache_clear()
    assert row.computed == pytest.approx(0.01 / 4.90, rel=1e-6)
    assert row.computed > row.tolerance


def test_kalkers_table_is_whole():
    table = kalker_table()
    assert table.coefficients.shape == (19, 3, 3)
    assert np.all(np.diff(table.axis_ratio) > 0.0)
    assert np.all(np.diff(table.coefficients, axis=1) > 0.0)  # all rise with Poisson's ratio


def test_report_of_the_real_fmus(fmus, tmp_path):
    done = fmus.command("verify", "--out", tmp_path)
    html = (tmp_path / "verification.html").read_text(encoding="utf-8")
    (passed, judged) = map(int, re.search(r"(\d+) of (\d+) values pass", done.stdout).groups())
    assert passed == judged > 80
    shown = int(re.search(r"(\d+) more are shown", done.stdout)[1])
    assert len(re.findall(r'<tr class="(?:pass|)">', html)) == judged + shown
    text = unescape(html)
    for name in (
        "start of the shear branch",
        "slab of line ZX, bending mode 4",
        "equivalent conicity, S1002 on 60E1",
        "german_high, alignment, rms",
        "bogie bounce, 9 MN/m per box",
        "dominant frequency of the axle boxes, 200 km/h, pads 140 MN/m",
        "amplitude of axle-box acceleration 2, 300 km/h, pads 40 MN/m",
        "mean wheel force, 300 km/h, contact on profiles",
        "disturbance by window shifts, 300 km/h, 25 m, % of the static load",
    ):
        assert f"<td>{name}</td>" in text
    assert len(re.findall(r'src="data:image/png;base64,', html)) == 5
