"""The page of a run: what is on it, what is said of what is missing, and what is refused."""

import re

import numpy as np
import plotly.graph_objects as go
import pytest
import rail_cosim
import xarray as xr
from charts import charts_of, values
from rail_cosim.errors import ResultsError
from rail_cosim.reporting import ReportError, _sections, execute_report, page, reading
from rail_cosim.reporting.charts import POINTS, envelope, packed
from rail_cosim.reporting.schematic import drawing, geometry
from rail_cosim.reporting.sections import Figure, Table
from synthetic import LOAD, whole_run

TITLES = [
    "Summary",
    "Simulation settings",
    "Parameters that differ from the parameter set",
    "Statistics of the evaluation window",
    "Ride comfort",
    "Wheel forces",
    "Accelerations",
    "Spectra",
    "Third-octave levels",
    "Spectrogram",
    "Coupling residuals",
    "All parameters",
]


TOO_SHORT = [
    "ride comfort: the run lasts 0.75 s; the first 5 s are left to the transient of the start, and "
    "the standards average over 5 s or more: run 10 s at least, 305 s for N_MV of EN 12299"
]


@pytest.fixture(scope="module")
def whole():
    return whole_run()


@pytest.fixture(scope="module")
def whole_page(whole):
    return page(whole)


def test_all_sections_are_there_and_nothing_is_missing(whole):
    sections = _sections(whole)
    assert [section.title for section in sections] == TITLES
    assert [missing for section in sections for missing in section.missing] == TOO_SHORT


def test_every_chart_is_one_that_plotly_knows(whole_page):
    charts = charts_of(whole_page)
    assert len(charts) == 23
    for chart in charts:
        go.Figure(chart)
        assert chart["layout"]["xaxis"]["title"]["text"]
        for trace in chart["data"]:
            shown = values(trace["z"] if trace["type"] == "heatmap" else trace["y"])
            assert np.isfinite(shown).any()
            assert not np.isinf(shown).any()


def test_forces_on_the_page_are_those_of_the_run(whole, whole_page):
    charts = charts_of(whole_page)
    (force,) = [
        c
        for c in charts
        if c["layout"]["yaxis"]["title"]["text"] == "vertical wheel force Q (kN)"
        and c["layout"]["shapes"]
    ]
    assert [t["name"] for t in force["data"]][:2] == ["wheelset 1 left", "wheelset 1 right"]
    drawn = values(force["data"][0]["y"])
    assert drawn.size <= POINTS + 2
    expected = whole["vertical_wheel_force"].isel(wheelset=0, side=0).to_numpy() / 1e3
    assert drawn.max() == pytest.approx(expected.max(), rel=1e-6)
    assert drawn.min() == pytest.approx(expected.min(), rel=1e-6)
    assert values(force["data"][0]["x"])[-1] == pytest.approx(whole["distance"].to_numpy()[-1])


def test_statistics_on_the_page(whole):
    tables = {
        part.caption: part
        for section in _sections(whole)
        for part in section.parts
        if isinstance(part, Table)
    }
    (wheels,) = [table for caption, table in tables.items() if "static load" in caption]
    row = dict(zip(wheels.heads, wheels.rows[0], strict=True))
    assert row["wheel"] == "wheelset 1 left"
    assert float(row["mean (kN)"]) == pytest.approx(LOAD / 1e3, rel=1e-3)
    assert float(row["dynamic factor"]) == pytest.approx(1.0 + 5.0 * 1.1 / 70.0, abs=0.01)
    (passing,) = [table for caption, table in tables.items() if "harmonics" in caption]
    assert float(passing.rows[0][1]) == pytest.approx(5.0, rel=0.01)
    assert float(passing.rows[0][4]) == pytest.approx(0.5, rel=0.02)


def test_an_event_before_the_window_is_in_the_summary_and_drawn_with_its_peak():
    """One record of 222 kN and 165 m/s2 and 5 without contact, at 12.51 m of 600."""
    run = whole_run(600.0)
    row = int(np.searchsorted(run["distance"], 12.5))
    run["normal_force"][row, 1, 0] = run["vertical_wheel_force"][row, 1, 0] = 222.417e3
    run["normal_force"][row - 7 : row - 2, 1, 0] = 0.0
    run["axle_box_vertical_acceleration"][row, 0, 1] = -165.244
    (summary,) = [s for s in _sections(run) if s.title == "Summary"]
    (table,) = summary.parts
    assert table.rows[2][:3] == ["wheelset 2 left", "222.4", "12.51"]
    assert table.rows[2][7:] == ["1", "1", "1"]
    assert table.rows[1][5:7] == ["165.2", "12.51"]
    assert "largest wheel force 222.417 kN at 12.51 m" in summary.remarks[1]
    shown = {}
    for chart in charts_of(page(run)):
        title = chart["layout"]["yaxis"]["title"]["text"]
        peaks = [np.nanmax(np.abs(values(t["y"]))) for t in chart["data"] if "y" in t]
        shown.setdefault(title, []).append(max(peaks))
    # Over the whole run, and around the largest value.
    assert shown["vertical wheel force Q (kN)"][:2] == pytest.approx([222.417] * 2, rel=1e-6)
    assert shown["axle-box acceleration (m/s²)"][:2] == pytest.approx([165.244] * 2, rel=1e-6)


def test_round_off_is_shown_as_zero():
    """On symmetric track Y of both wheels cancels but for the last digits."""
    run = whole_run()
    noise = 1e-11 * np.sin(np.arange(run.sizes["time"]))
    run["guiding_force"][:, :, 1] = -run["guiding_force"][:, :, 0] + noise[:, None]
    run["bogie_lateral_acceleration"] = run["bogie_lateral_acceleration"] * 1e-14
    sections = {section.title: section for section in _sections(run)}
    charts = [p for s in sections.values() for p in s.parts if isinstance(p, Figure) and p.chart]
    for words in ("Track shifting force (sum of Y)", "Bogie acceleration, lateral"):
        (figure,) = [one for one in charts if one.title == words]
        assert all((values(trace["y"]) == 0.0).all() for trace in figure.chart["data"])
    tables = sections["Statistics of the evaluation window"].parts
    (table,) = [t for t in tables if t.caption.startswith("Track shifting force")]
    assert [row[1:] for row in table.rows] == [["0", "0"]] * 4
    for figure in charts:
        assert figure.chart["layout"]["yaxis"]["exponentformat"] == "power"  # no 1.5p
    run["guiding_force"][:, :, 1] += 0.01  # N: small, but there
    (section,) = [s for s in _sections(run) if s.title.startswith("Statistics")]
    (table,) = [t for t in section.parts if t.caption.startswith("Track shifting force")]
    assert [float(row[2]) for row in table.rows] == pytest.approx([1e-5] * 4, rel=1e-6)


def test_comfort_is_that_after_the_transient_of_the_start():
    steady = whole_run(1600.0, 1000.0)
    starting = steady.copy(deep=True)
    for name in ("car_body_floor_vertical_acceleration", "car_body_floor_lateral_acceleration"):
        starting[name] = starting[name] + 2.0 * np.exp(-4.0 * starting["time"])
    pages = []
    for run in (starting, steady):
        (section,) = [s for s in _sections(run) if s.title == "Ride comfort"]
        (table,) = section.parts
        assert "Evaluation window: 5 to 19.999 s" in table.caption
        assert "N_MV from 3 of the 60 blocks of 5 s" in table.caption
        pages.append(np.array([row[1:-1] for row in table.rows], dtype=float))
    assert pages[0] == pytest.approx(pages[1], rel=0.01)
    assert (pages[1] > 0.0).all()


def test_changed_parameters(whole):
    table = _sections(whole)[2].parts[0]
    assert table.rows == [["vehicle.speed", "80", "83.3"]]
    nothing = _sections(whole_run(changed_parameters="{}"))[2]
    assert nothing.parts[0].heads == ["none"]
    older = whole.copy()
    older.attrs = {k: v for k, v in whole.attrs.items() if k != "changed_parameters"}
    assert "changed_parameters" in _sections(older)[2].missing[0]


def test_the_page_needs_nothing_from_elsewhere(whole_page):
    text = whole_page
    body = text.replace(text[text.index("<script>/**") : text.rindex("<script>")], "")
    assert not re.search(r'(?:src|href)="(?!#|data:)', body)
    assert "@import" not in body
    assert "url(" not in body


def test_names_cannot_break_out_of_the_page():
    hostile = "</script><script>alert(1)</script>"
    text = page(whole_run(command=hostile, line=hostile, **{f"track.{hostile}": hostile}))
    assert hostile not in text
    assert "&lt;/script&gt;&lt;script&gt;alert(1)" in text
    data = whole_run().rename(bogie_vertical_acceleration="other")
    assert len(charts_of(page(data))) == 21  # no chart was cut in two


@pytest.mark.parametrize(
    "name",
    [
        "axle_box_vertical_acceleration",
        "vertical_wheel_force",
        "guiding_force",
        "car_body_floor_vertical_acceleration",
        "window_start_position",
        "wheelset_longitudinal_position",
        "bogie_vertical_acceleration",
        "window_slide_residual",
        "distance",
    ],
)
def test_a_run_without_something_still_has_its_page(whole, name):
    """Another's FMU has fewer outputs; a missing distance is speed times time."""
    assert "<h2>Spectrogram</h2>" in page(whole.drop_vars(name))


def test_what_is_missing_is_said(whole):
    data = whole.drop_vars(["axle_box_vertical_acceleration", "guiding_force"])
    data = data.drop_vars(["vertical_wheel_force", "normal_force"])
    text = page(data)
    for name in ("axle_box_vertical_acceleration", "guiding_force", "vertical_wheel_force"):
        assert f"Not shown: {name}" in text
    bare = whole[["distance"]]
    bare.attrs = {}
    text = page(bare)
    assert text.count("Not shown:") > 20
    assert "wheelset_longitudinal_position: no schematic can be drawn without it" in text


def test_one_wheelset_without_bogies(whole):
    names = [n for n, v in whole.items() if {"bogie", "floor_place"} & set(v.dims)]
    single = whole.isel(wheelset=[0]).drop_vars(names)
    assert 'aria-label="1 wheelsets in a window of 80.5 m"' in page(single)


def test_values_that_are_not_numbers_do_not_stop_the_page(whole):
    data = whole.copy(deep=True)
    data["normal_force"][-50:] = np.nan
    data["guiding_force"][-50:] = np.nan
    data["vertical_wheel_force"][-50:] = np.nan
    data["axle_box_vertical_acceleration"][-50:] = np.nan
    for chart in charts_of(page(data)):
        go.Figure(chart)


def test_an_incomplete_run_says_so(whole_page):
    text = page(whole_run(complete=0, ended_by="stopped by the user after 7 of 9 steps"))
    assert "Incomplete run: it ended early: stopped by the user after 7 of 9 steps." in text
    assert "Incomplete run" not in whole_page


@pytest.mark.parametrize("records", [8, 20, 100, 700])
def test_short_runs(whole, records):
    assert "<h2>Statistics of the evaluation window</h2>" in page(whole.isel(time=slice(records)))


def test_a_long_run_is_not_a_large_page():
    """One kilometre at 288 km/h and 0.1 ms; plotly.js alone has 4.8 MB."""
    assert len(page(whole_run(1000.0, 10000.0)).encode()) < 10e6


def test_envelope_keeps_peaks_and_ends():
    x = np.arange(100000.0)
    y = np.sin(x / 500.0)
    y[54321], y[77777] = 9.0, -9.0
    way, thinned = envelope(x, y, 1000)
    assert way.size <= 1002
    assert (np.diff(way) > 0.0).all()
    assert way[thinned.argmax()] == 54321.0
    assert way[thinned.argmin()] == 77777.0
    assert (way[0], way[-1]) == (0.0, 99999.0)
    gone = y.copy()
    gone[::7] = np.nan
    assert np.nanmax(envelope(x, gone, 1000)[1]) == 9.0
    short = envelope(x[:900], y[:900], 1000)
    assert short[0].size == 900


def test_numbers_travel_exactly_in_32_bits():
    array = np.arange(6.0).reshape(2, 3) / 7.0
    sent = packed(array)
    assert sent["shape"] == "2, 3"
    np.testing.assert_array_equal(values(sent).reshape(2, 3), array.astype("f4"))


def test_schematic_is_to_scale(whole):
    svg = drawing(geometry(whole))
    circles = [float(x) for x in re.findall(r'<circle cx="([\d.]+)"', svg)]
    scale = 1000.0 / (16 * 5.032)
    assert np.diff(circles) == pytest.approx(np.array([-2.5, -15.3, -2.5]) * scale, abs=0.11)
    assert circles[0] == pytest.approx(40.256 * scale, abs=0.1)
    assert svg.count("<rect") > 16 + 128


def test_files_that_are_no_runs_are_refused(tmp_path):
    def refused(name, match):
        with pytest.raises(ReportError, match=match) as caught:
            execute_report([tmp_path / name], None, "")
        assert caught.value.exit_status == 2
        assert "\n" not in str(caught.value)

    refused("none.nc", "there is no such file")
    refused("", "it is a directory")
    (tmp_path / "text.nc").write_text("no NetCDF")
    refused("text.nc", "is not a NetCDF file that can be read")
    (tmp_path / "empty.nc").touch()
    refused("empty.nc", "is not a NetCDF file that can be read")
    sweep = xr.Dataset({"error": ("speed", ["", "x"]), "normal_force_max": ("speed", [1.0, 2.0])})
    sweep.to_netcdf(tmp_path / "sweep.nc", engine="h5netcdf")
    refused("sweep.nc", "result of a sweep, not of a run")
    xr.Dataset({"a": ("b", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    refused("other.nc", "no dimension time")
    few = whole_run().isel(time=slice(3))
    few.to_netcdf(tmp_path / "few.nc", engine="h5netcdf")
    refused("few.nc", "3 records, too few")


def test_a_very_long_run_is_reported_in_parts(monkeypatch, tmp_path, whole):
    monkeypatch.setattr(reading, "MOST_RECORDS", 3000)
    whole.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with pytest.raises(ReportError, match=r"3750 records, more than 3000.*isel\(time"):
        execute_report([tmp_path / "run.nc"], None, "")
    rail_cosim.report(whole.isel(time=slice(2000, None)), tmp_path / "part.html")


def test_a_file_gives_the_same_page_as_the_data_set(tmp_path, whole, whole_page):
    """Only what is shown is read from a file: nothing that is shown may be left out."""
    whole.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    assert charts_of(page(reading.open_run(tmp_path / "run.nc"))) == charts_of(whole_page)
    again = _sections(reading.open_run(tmp_path / "run.nc"))
    assert [missing for section in again for missing in section.missing] == TOO_SHORT


def test_page_beside_the_run_and_through_python(tmp_path, whole):
    whole.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    written = execute_report([tmp_path / "run.nc"], None, "rail-cosim report run.nc")
    assert written == tmp_path / "run.html"
    assert "rail-cosim report run.nc; rail-cosim" in written.read_text()
    with pytest.raises(ResultsError, match="is the run itself"):
        execute_report([tmp_path / "run.nc"], tmp_path / "run.nc", "")
    made = rail_cosim.report(whole, tmp_path / "new" / "page.html")
    assert made.stat().st_size > 5e6
    with pytest.raises(ResultsError, match="cannot be written"):
        rail_cosim.report(whole, tmp_path)


def test_figures_have_titles(whole):
    for section in _sections(whole):
        for part in section.parts:
            if isinstance(part, Figure):
                assert part.title
                assert bool(part.svg) != bool(part.chart)
