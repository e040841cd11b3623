"""The verification report without its computations: verdicts, table, page, exit status."""

import dataclasses
import math
import re

import numpy as np
import pytest
import rail_cosim.verification as verification
import xarray as xr
from rail_cosim.cli import app
from rail_cosim.errors import RailCosimError, ResultsError
from rail_cosim.verification import components, coupled
from rail_cosim.verification.page import page, write_page
from rail_cosim.verification.rows import (
    Curve,
    Row,
    Values,
    computed_text,
    deviation_text,
    from_json,
    reference_text,
    tolerance_text,
)
from typer.testing import CliRunner

GOOD = Row(
    section="Rail",
    name="mode <1>",
    unit="Hz",
    reference=100.0,
    source="a book & its table",
    tolerance=0.01,
    computed=100.9,
)
SHOWN = dataclasses.replace(GOOD, name="mode 2", tolerance=None, computed=80.0, remark="softer")
BAD = dataclasses.replace(GOOD, name="mode 3", section="Slab", computed=98.9)
LINE = Curve(plot="A plot", label="a", x_label="x (m)", y_label="y (N)", x=[0.0, 1.0], y=[1.0, 2.0])


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, "pass"),
        ({"computed": 101.1}, "FAIL"),
        ({"computed": 98.9}, "FAIL"),
        ({"computed": math.nan}, "FAIL"),
        ({"computed": math.inf}, "FAIL"),
        ({"tolerance": None, "computed": 1e9}, ""),
        ({"relative": False, "tolerance": 1.0}, "pass"),
        ({"relative": False, "tolerance": 0.8}, "FAIL"),
        ({"reference": -100.0, "computed": -100.9}, "pass"),
        ({"reference": 21.0, "computed": 21.0, "tolerance": 0.0}, "pass"),
        ({"reference": 21.0, "computed": 22.0, "tolerance": 0.0}, "FAIL"),
        ({"reference": 0.0, "computed": 1e-3, "tolerance": 0.5}, "FAIL"),
    ],
)
def test_verdicts(changes, verdict):
    assert dataclasses.replace(GOOD, **changes).verdict == verdict


@pytest.mark.parametrize(
    ("row", "texts"),
    [
        (GOOD, ("100", "100.9", "+0.9 %", "1 %")),
        (dataclasses.replace(GOOD, computed=100.012345, tolerance=1e-4), ("100", "100.012", "+0.012 %", "0.01 %")),  # noqa: E501
        (dataclasses.replace(GOOD, relative=False, computed=99.5), ("100", "99.500", "-0.5", "0.01")),  # noqa: E501
        (SHOWN, ("100", "80", "-20 %", "")),
        (dataclasses.replace(GOOD, computed=math.nan), ("100", "not a number", "+nan %", "1 %")),
        (dataclasses.replace(GOOD, reference=21.0, computed=21.0, tolerance=0.0), ("21", "21", "0", "0 %")),  # noqa: E501
    ],
)  # fmt: skip
def test_texts(row, texts):
    shown = reference_text(row), computed_text(row), deviation_text(row), tolerance_text(row)
    assert shown == texts


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Return a function that runs the command with rows in place of the computations."""

    def command(*rows, out=tmp_path / "new", arguments=()):
        asked = []

        def coupled_values(reporter, *, full):
            asked.append(full)
            return Values(rows=rows[1:], curves=[LINE])

        monkeypatch.setattr(verification, "MODULES", {"track": ""})
        monkeypatch.setattr(verification, "component_values", lambda name: Values(rows=rows[:1]))
        monkeypatch.setattr(verification, "coupled_values", coupled_values)
        given = ["verify", "--out", str(out), *arguments]
        return CliRunner().invoke(app, given, env={"COLUMNS": "120"}), asked

    return command


def test_all_that_pass_give_exit_status_0(run, tmp_path):
    result, asked = run(GOOD, SHOWN)
    assert result.exit_code == 0
    assert "1 of 1 values pass; 1 more are shown and not judged" in result.stdout
    assert asked == [False]
    assert run(GOOD, arguments=["--full"])[1] == [True]
    html = (tmp_path / "new" / "verification.html").read_text(encoding="utf-8")
    assert "1 of 1 values pass</p>" in html


def test_a_failing_row_gives_exit_status_1_and_is_named(run, tmp_path):
    result, _ = run(GOOD, BAD, SHOWN)
    assert result.exit_code == 1
    assert "1 of 2 values pass" in result.stdout
    assert "FAIL: Slab: mode 3" in result.stdout
    html = (tmp_path / "new" / "verification.html").read_text(encoding="utf-8")
    assert "1 of 2 values pass, 1 fail" in html
    assert html.count('<tr class="FAIL">') == 1


def test_page_holds_every_row_with_its_source_and_no_other_file():
    html = page(Values(rows=[GOOD, SHOWN, BAD], curves=[LINE]), "rail-cosim verify --out a<b")
    assert re.findall(r"<h2>(.*?)</h2>", html) == ["Rail", "Slab", "Plots"]
    for text in (
        "mode &lt;1&gt;",
        "mode 2",
        "mode 3",
        "a book &amp; its table",
        "softer",
        "a&lt;b",
    ):
        assert text in html
    pictures = re.findall(r'src="(data:image/png;base64,[^"]+)"', html)
    assert len(pictures) == 2
    assert len(re.findall(r"(?:src|href)=", html)) == 2


def test_page_that_cannot_be_written(tmp_path):
    with pytest.raises(ResultsError, match=r"page\.html: cannot be written"):
        write_page(Values(rows=[GOOD]), tmp_path / "none" / "page.html", "")


def test_json_of_a_component_keeps_rows_and_its_missing_values():
    row = dataclasses.asdict(GOOD)
    values = from_json({"rows": [row, row | {"computed": None}], "curves": []})
    assert values.rows[0] == GOOD
    assert math.isnan(values.rows[1].computed)
    assert values.rows[1].verdict == "FAIL"


def test_a_component_that_fails_says_why(monkeypatch):
    monkeypatch.setitem(components.MODULES, "track", "slab_track.no_such_module")
    with pytest.raises(RailCosimError, match=r"python -m slab_track\.no_such_module: .*No module"):
        components.component_values("track")


def made_run(speed, amplitude, beyond=0.0, offset=0.0):
    """Ten slab lengths with a harmonic of the pitch, and one above 500 Hz."""
    time = 1e-4 * np.arange(round(50.32 / (speed / 3.6) / 1e-4) + 1)
    phase = 2.0 * np.pi * speed / 3.6 * time / 5.032
    wave = amplitude * np.sin(8 * phase) + beyond * np.sin(64 * phase)
    values = np.broadcast_to(wave[:, None, None], (time.size, 4, 2))
    dims = ("time", "wheelset", "side")
    return xr.Dataset(
        {
            "normal_force": (dims, 69210.8 + offset + values),
            "axle_box_vertical_acceleration": (dims, values / 940.5),
            "distance": ("time", speed / 3.6 * time),
        },
        coords={"time": time},
        attrs={
            "speed_km_h": speed,
            "track.fastener.spacing": 0.629,
            "track.fastener.count_per_slab": 8,
        },
    )


def test_amplitudes_are_those_up_to_500_hz():
    found = coupled.amplitudes(made_run(300.0, 1340.0, beyond=500.0), "normal_force")
    assert found == pytest.approx(np.full((4, 2), 1340.0), rel=2e-3)


def test_values_of_a_run():
    case = next(c for c in coupled.CASES if (c.speed, c.stiffness) == (300.0, 40e6))
    right = coupled.case_values(case, made_run(300.0, case.force[0]))
    by_name = {row.name.partition(",")[0]: row for row in right.rows}
    assert by_name["mean wheel force"].verdict == "pass"
    assert by_name["dominant frequency of the axle boxes"].computed == pytest.approx(132.5, abs=0.3)
    assert by_name["amplitude of wheel force 1"].verdict == "pass"
    assert by_name["amplitude of wheel force 2"].verdict == "FAIL"  # 2.8 % less is right there
    assert max(right.curves[0].x) <= 500.0
    shifted = coupled.case_values(case, made_run(300.0, case.force[0], offset=10.0))
    assert shifted.rows[0].verdict == "FAIL"
    assert shifted.rows[0].computed == pytest.approx(69.2208, rel=1e-6)


def test_slides_are_the_largest_difference_of_two_runs(monkeypatch):
    asked = []

    def execute(options, reporter):
        asked.append(options.settings)
        return made_run(300.0, 1000.0, offset=5.0 * (len(asked) - 1))

    monkeypatch.setattr(coupled, "execute", execute)
    values = coupled.slide_values(None, 25.0)
    assert values.rows[0].computed == pytest.approx(100.0 * 5.0 / 69210.8, rel=1e-4)
    assert values.rows[0].verdict == "pass"
    assert asked[0] != asked[1]
    assert all("track.contact.model=vertical" in settings for settings in asked)


def test_references_are_those_of_the_finite_element_track():
    from runs import golden_amplitudes

    for case in coupled.CASES:
        force, error = golden_amplitudes(case.speed, case.stiffness)
        assert case.force == pytest.approx(force[:2], abs=5e-3)
        assert force[2:] == pytest.approx(force[:2], rel=3e-4)
        assert error < 1e-3
