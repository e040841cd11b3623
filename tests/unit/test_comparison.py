"""Runs compared in one report: what differs, by how much, over which windows; curves are theirs."""

import re
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
import rail_cosim
from charts import charts_of, values
from rail_cosim.errors import ResultsError
from rail_cosim.reporting import ReportError, compare, execute_report
from rail_cosim.reporting.comparison import sections
from rail_cosim.reporting.reading import labels
from rail_cosim.reporting.sections import Figure, Table
from synthetic import whole_run


@pytest.fixture(scope="module")
def runs():
    """Return two runs of different length, step and variables; the second has 10 kN more."""
    first = whole_run(60.0, 5000.0, macro_step=2e-4)
    second = whole_run(90.0, 10000.0, macro_step=1e-4, source="rail-cosim 0.2.0")
    second.attrs["track.fastener.vertical_stiffness"] = 80e6
    first.attrs["track.fastener.vertical_stiffness"] = 40e6
    for name in ("normal_force", "vertical_wheel_force"):
        second[name] = (second[name] + 10e3).assign_attrs(units="N")
    second["normal_force"][1000, 2, 1] = second["vertical_wheel_force"][1000, 2, 1] = 200e3
    return {"soft": first, "stiff": second.drop_vars("bogie_lateral_acceleration")}


@pytest.fixture(scope="module")
def compared(runs):
    return {section.title: section for section in sections(runs)}


def rows_of(section, part):
    return {row[0]: row[1:] for row in section.parts[part].rows}


def test_settings_versions_and_steps_stand_beside_each_other(compared):
    rows = rows_of(compared["Simulation settings and coupling residuals"], 1)
    assert rows["communication step (s)"] == ["0.0002", "0.0001"]
    assert rows["program"] == ["rail-cosim 0.1.0", "rail-cosim 0.2.0"]
    assert rows["line"] == ["HD", "HD"]  # always there
    assert "track_fmu" not in rows  # the same
    runs = rows_of(compared["Simulation settings and coupling residuals"], 0)
    assert (runs["soft"][2], runs["stiff"][2]) == ("3750", "11250")


def test_only_parameters_that_differ_are_listed(compared, runs):
    (table,) = compared["Parameters that differ"].parts
    assert table.rows == [["track.fastener.vertical_stiffness", "40000000", "80000000"]]
    (section,) = [
        s for s in sections({"a": runs["soft"], "b": runs["soft"]}) if "differ" in s.title
    ]
    assert section.remarks == ["All parameters are the same."]


def test_statistics_have_windows_and_differences(compared, runs):
    section = compared["Statistics"]
    assert "soft: whole run 0.00 to 59.98 m; evaluation window" in section.remarks[0]
    assert "stiff: whole run 0.00 to 89.99 m; evaluation window" in section.remarks[1]
    assert "not of the same length" in section.remarks[2]
    whole, window = rows_of(section, 0), rows_of(section, 1)
    soft, stiff = whole["wheel force, max (kN)"]
    largest = float(runs["soft"]["normal_force"].max()) / 1e3
    assert soft.startswith(f"{largest:.4g}, wheelset 1 left")
    assert stiff.startswith(f"200, wheelset 3 right, 8.00 m ({200.0 - largest:+.4g}, +")
    assert whole["losses of contact of a wheel"] == [
        "0, wheelset 1 left",
        "0, wheelset 1 left (no difference)",
    ]
    soft, stiff = window["wheel force, mean (kN)"]
    assert soft == "70, wheelset 1 left"
    assert re.match(r"80, wheelset 1 left \(\+(9\.99\d|10), \+14 %\)", stiff)


def test_curves_are_those_of_the_runs_by_distance(compared, runs):
    figures = [part for part in compared["Histories"].parts if isinstance(part, Figure)]
    chart = figures[0].chart
    assert figures[0].title == "Vertical wheel force Q"
    go.Figure(chart)
    shown = [trace for trace in chart["data"] if trace["visible"]]
    assert [trace["name"] for trace in shown] == ["soft", "stiff"]
    # The channel with the largest value is shown first, the others by the menu.
    (menu,) = chart["layout"]["updatemenus"]
    assert menu["buttons"][menu["active"]]["label"] == "wheelset 3 right"
    assert len(menu["buttons"]) == 8
    for trace, run in zip(shown, runs.values(), strict=True):
        force = run["vertical_wheel_force"].isel(wheelset=2, side=1)
        assert values(trace["y"]).max() == pytest.approx(float(force.max()) / 1e3, rel=1e-6)
        assert values(trace["x"])[-1] == pytest.approx(float(run["distance"][-1]), rel=1e-6)
    first = menu["buttons"][0]["args"][0]["visible"]
    chosen = [t for t, there in zip(chart["data"], first, strict=True) if there]
    assert [t["name"] for t in chosen] == ["soft", "stiff"]
    assert values(chosen[1]["y"]).max() < 90.0  # wheelset 1 left


def test_spectra_lie_over_each_other(compared):
    (chart,) = [
        p.chart for p in compared["Spectra"].parts if p.title == "Spectrum: axle-box acceleration"
    ]
    shown = [trace for trace in chart["data"] if trace["visible"]]
    for trace in shown:
        peak = values(trace["x"])[values(trace["y"]).argmax()]
        assert peak == pytest.approx(80.0 / 0.629, abs=4.0)


def test_a_variable_of_one_run_only_is_drawn_and_the_other_named(compared):
    section = compared["Histories"]
    (figure,) = [p for p in section.parts if p.title == "Bogie acceleration, lateral"]
    assert {trace["name"] for trace in figure.chart["data"]} == {"soft"}
    assert any(text.startswith("stiff: bogie_lateral_acceleration") for text in section.missing)
    # Neither has it: said once.
    assert sum("rail_vertical_displacement" in text for text in section.missing) == 1


def test_labels_tell_files_apart():
    paths = [Path(one) for one in ("/a/run.nc", "/b/run.nc", "/b/c/other.nc", "/b/run.nc")]
    assert labels(paths) == ["a/run", "b/run", "other", "b/run (2)"]
    assert labels([Path("/x/y.nc")]) == ["y"]
    assert len(set(labels([Path("/x/y.nc")] * 3))) == 3


def test_files_are_compared_beside_the_first(tmp_path, runs):
    for name, run in runs.items():
        (tmp_path / name).mkdir()
        run.to_netcdf(tmp_path / name / "run.nc", engine="h5netcdf")
    paths = [tmp_path / name / "run.nc" for name in runs]
    written = execute_report(paths, None, "rail-cosim report")
    assert written == tmp_path / "soft" / "comparison.html"
    text = written.read_text()
    assert "<title>Comparison: soft/run, stiff/run</title>" in text
    assert len(charts_of(text)) == len(charts_of(compare(runs)))
    with pytest.raises(ResultsError, match="is the run itself"):
        execute_report(paths, paths[1], "")
    (tmp_path / "no.nc").write_text("x")
    with pytest.raises(ReportError, match=r"no\.nc"):
        execute_report([paths[0], tmp_path / "no.nc"], None, "")


def test_comparison_through_python(tmp_path, runs):
    made = rail_cosim.report(runs, tmp_path / "c.html")
    assert "Comparison: soft, stiff" in made.read_text()
    with pytest.raises(ReportError, match="bad: has no dimension time"):
        rail_cosim.report({"soft": runs["soft"], "bad": runs["soft"].isel(time=0)}, made)


def test_an_incomplete_run_is_named(runs):
    stopped = runs["stiff"].assign_attrs(complete=0, ended_by="stopped by the user")
    section = sections({"soft": runs["soft"], "stopped": stopped})[0]
    assert section.remarks == ["stopped is an incomplete run: stopped by the user."]
    assert all(isinstance(part, Table) for part in section.parts)
    assert np.all([len(part.rows) > 0 for part in section.parts])
