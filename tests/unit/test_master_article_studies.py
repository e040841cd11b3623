"""Studies of the article's figures on made-up sweeps: what is asked, checked, drawn and written."""

import json

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import RailCosimError
from rail_cosim.studies import (
    StudyOptions,
    article,
    fig11,
    fig16,
    fig17,
    run_study,
    table3,
    zx_line,
)
from rail_cosim.studies.article import BAY, STIFFNESS, p2_frequency
from rail_cosim.sweeps.quantities import NAMES as STATISTIC_NAMES

STEP = 5.032 / (200 / 3.6) / 900
WHOLE = ("bogie_vertical_acceleration", "car_body_vertical_acceleration")
PNG = b"\x89PNG"


class Quietly:
    def stage(self, text):
        pass

    def progress(self, done, planned):
        pass

    def notice(self, text):
        pass


def made(specification, *, error="", resonance=None):
    """Results of a sweep in which the acceleration has its peak at the speed of Table 3."""
    axes = {name: np.array(values) for name, values in specification.grid.items()}
    shape = (*specification.shape, 4, 2)
    dims = (*axes, "wheelset", "side")
    base = xr.DataArray(np.ones(shape), dims=dims, coords=axes)
    speed = xr.DataArray(axes["speed"].astype(float), dims="speed", coords={"speed": axes["speed"]})
    at = resonance(base) if resonance else 200.0
    peak = base * 10.0 / (1.0 + ((speed - at) / 30.0) ** 2)
    data = xr.Dataset(coords=axes)
    for variable, statistics in specification.keep.items():
        for statistic in statistics:
            assert statistic in STATISTIC_NAMES
            data[f"{variable}_{statistic}"] = (peak * 7e3 + 7e4) if "force" in variable else peak
    time = STEP * np.arange(12001)
    for variable in specification.history:
        wave = 5.0 * np.sin(2 * np.pi * 200 / 3.6 / 0.629 * time)
        if variable == "distance":
            wave = axes["speed"][0] / 3.6 * time
        elif variable not in WHOLE:
            wave = np.broadcast_to(wave[:, None, None], (len(time), 4, 2))
        more = dims[-2:] if wave.ndim == 3 else ()
        histories = np.broadcast_to(wave, (*specification.shape, *wave.shape))
        data[f"{variable}_history"] = ((*axes, "record", *more), histories)
        times = np.broadcast_to(time, (*specification.shape, len(time)))
        data["time_history"] = ((*axes, "record"), times)
    data["steady"] = (tuple(axes), np.ones(specification.shape))
    texts = np.full(specification.shape, error, dtype=object)
    return data.assign(error=(tuple(axes), texts), remarks=(tuple(axes), np.full_like(texts, "")))


@pytest.fixture
def asked(monkeypatch):
    """Replace the sweeps; return what was asked of them."""
    seen = []

    def execute(specification, **options):
        seen.append((specification, options))
        return made(specification, **execute.more)

    execute.more = {}
    monkeypatch.setattr(article, "execute_sweep", execute)
    seen.append(execute)
    return seen


NAMES = ["fig08", "fig11", "fig12", "fig13", "fig14", "fig15", "table3", "fig09"]
NAMES += ["fig07", "fig16", "fig17", "fig18"]


@pytest.mark.parametrize("name", NAMES)
def test_a_study_writes_data_with_its_checks_and_a_picture(name, asked, tmp_path):
    options = StudyOptions(out=tmp_path, quick=True, settings=["track.rail.area=8e-3"])
    result = run_study(name, options, Quietly())
    specification, more = asked[1]
    assert list(specification.grid["line"]) == ["paper", "HD"]
    assert specification.settings["track.contact.model"] == "vertical"
    assert specification.settings["track.rail.area"] == "8e-3"
    assert more["store"] == tmp_path / "points"
    assert [path.name for path in result.files] == [f"{name}.nc", f"{name}.png"]
    assert result.files[1].read_bytes().startswith(PNG)
    with xr.open_dataset(result.files[0], engine="h5netcdf") as data:
        assert data["setting"].to_numpy().tolist() == ["paper", "converged"]
        checks = json.loads(data.attrs["checks"])
    assert result.table.row_count == len(checks)
    for check in checks:
        assert set(check["passed"]) == {"paper", "converged"}
    assert "statements hold with the paper settings" in result.conclusion


def test_table_3_passes_where_the_speeds_are_the_stated_ones_and_not_elsewhere(asked, tmp_path):
    def resonance(data):
        bays = xr.DataArray(list(table3.STATED), dims=BAY, coords={BAY: list(table3.STATED)})
        stated = bays * 0 + [speed for speed, _ in table3.STATED.values()]
        shift = xr.DataArray([0.0, 5.0], dims="line", coords={"line": data["line"]})
        return stated + shift

    asked[0].more = {"resonance": resonance}
    result = run_study("table3", StudyOptions(out=tmp_path), Quietly())
    assert result.conclusion.startswith(
        "20 of 20 statements hold with the paper settings; 2 of 20 statements hold"
    )


def test_a_failed_point_ends_the_study(asked, tmp_path):
    asked[0].more = {"error": "the wheel broke"}
    with pytest.raises(RailCosimError, match=r"points of the study failed.*the wheel broke"):
        run_study("fig11", StudyOptions(out=tmp_path, quick=True), Quietly())
    assert not (tmp_path / "fig11.png").exists()


def test_the_resonance_frequency_is_that_of_the_article():
    """Its text: 51.4 and 83.1 Hz, which its formula gives with a bay of 0.60 m."""
    assert p2_frequency(40e6, bay=0.60) == pytest.approx(51.4, abs=0.06)
    assert p2_frequency(140e6, bay=0.60) == pytest.approx(83.1, abs=0.06)
    assert fig11.resonance(140e6) == pytest.approx(3.6 * 81.62 * 0.629, rel=1e-3)


def test_rising_and_falling():
    assert article.rises([1.0, 2.0, 3.0]) == 1.0
    assert article.rises([1.0, 1.0, 3.0]) == 0.0
    assert article.falls([3.0, 3.0, 1.0]) == 1.0
    assert article.falls([3.0, 3.0]) == 0.0
    assert article.falls([3.0, 4.0, 1.0]) == 0.0


def test_quick_is_coarser_and_the_given_settings_win(asked, tmp_path):
    for quick in (False, True):
        run_study("fig11", StudyOptions(out=tmp_path, quick=quick), Quietly())
    (whole, _), (coarse, _) = asked[1:]
    assert len(coarse.grid["speed"]) < len(whole.grid["speed"])
    assert set(coarse.grid[STIFFNESS]) <= set(whole.grid[STIFFNESS])
    assert whole.run["macro_step"] < coarse.run["macro_step"]


def test_the_ridge_of_the_spectrogram_follows_the_slabs():
    """A chirp at v(t)/5.67 m, as a vehicle that speeds up makes it."""
    time = 2e-3 * np.arange(3001)
    way = 83.0 * time + 0.5 * 2.0 * time**2
    wave = 1e-4 * np.sin(2.0 * np.pi * way / zx_line.PITCH)
    one = xr.Dataset(
        {
            f"{fig16.SPRING}_history": (("record", "wheelset", "side"), wave[:, None, None]),
            "distance_history": ("record", way),
            "time_history": ("record", time),
        }
    )
    found, passing = fig16.ridge(one)
    assert found == pytest.approx(passing, abs=0.13)  # lines are 0.25 Hz apart
    _, speed, _, amplitudes = fig16.spectrogram(one)
    assert speed[-1] - speed[0] > 5.0
    assert amplitudes.max() == pytest.approx(1e-4, rel=0.1)


def test_a_dip_at_a_joint_is_told_from_what_repeats_with_the_bays():
    way = np.linspace(0.0, 4 * zx_line.PITCH, 4 * 900 + 1)
    bays = 1e3 * np.cos(2.0 * np.pi * way / zx_line.BAY)
    off = (way + 0.5 * zx_line.PITCH) % zx_line.PITCH - 0.5 * zx_line.PITCH

    def dip(force):
        values = (("record", "wheelset", "side"), force[:, None, None])
        distance = ("record", way)
        return fig17.dip(xr.Dataset({"normal_force_history": values, "distance_history": distance}))

    assert dip(7e4 + bays) == pytest.approx(0.0, abs=1e-6)
    hollow = -3e3 * np.exp(-((off / 0.9) ** 2))
    # Each ninth harmonic, the bays' own, is taken out of the hollow too: next to nothing of it.
    assert dip(7e4 + bays + hollow) == pytest.approx(3e3, rel=0.02)
    assert dip(7e4 + bays - hollow) < 100.0
