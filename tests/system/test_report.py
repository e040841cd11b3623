"""A run, and the page that shows it, by the command line."""

import json
import re

import pytest
import xarray as xr


@pytest.fixture(scope="module")
def run(fmus, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "run.nc"
    settings = ["--set", "track.fastener.vertical_stiffness=60e6"]
    arguments = ["--line", "HD", "--speed", 290, "--distance", 14, "--out", path]
    fmus.invoke("run", *arguments, *settings)
    return path


def test_run_records_what_differs_from_the_parameter_set(run):
    about = xr.load_dataset(run, engine="h5netcdf").attrs
    found = json.loads(about["changed_parameters"])
    speed = found.pop("vehicle.speed")
    assert speed == pytest.approx(300.0 / 3.6)
    assert found == {"track.fastener.vertical_stiffness": 40e6}


def test_page_of_a_run(fmus, run, tmp_path):
    page = tmp_path / "page.html"
    assert fmus.command("report", run, "--out", page).stdout.strip() == str(page)
    text = page.read_text()
    assert "<title>Run: line HD, 290 km/h</title>" in text
    assert '<td class="long">60000000</td><td class="long">40000000</td>' in text
    # All that the report shows is among the outputs of both FMUs; comfort needs a longer run.
    assert re.findall("Not shown: (.*?):", text) == ["ride comfort"]


def test_refusal_is_one_line(fmus, tmp_path):
    (tmp_path / "no.nc").write_text("x")
    said = fmus.command("report", tmp_path / "no.nc", status=(2,)).stderr
    assert said.startswith("rail-cosim: error: ")
    assert "is not a NetCDF file" in said
    assert said.count("\n") == 1
