"""The result of a run: a Dataset whose plots show its data, with words and units."""

import pickle

import matplotlib
import numpy as np
import pytest
import rail_cosim
import xarray as xr
from matplotlib.figure import Figure
from rail_cosim import RunResult, open_result
from rail_cosim.errors import ParameterError
from rail_cosim.reporting import ReportError
from synthetic import BAY, whole_run

matplotlib.use("agg")


@pytest.fixture(scope="module")
def result():
    run = whole_run()
    for name in ("rail_vertical_displacement", "wheelset_vertical_displacement"):
        run[name] = 1e-9 * run["normal_force"].assign_attrs(units="N")
        run[name].attrs["units"] = "m"
    run["wheelset_vertical_displacement"] = run["wheelset_vertical_displacement"].isel(side=0)
    run["normal_force"][123, 1, 0] = 222e3
    return RunResult.of(run)


@pytest.fixture
def ax():
    return Figure().subplots()


HISTORIES = {
    "plot_wheel_force": ("normal_force", "wheel force", "kN", 1e-3, 4),
    "plot_lateral_wheel_force": ("guiding_force", "lateral wheel force Y", "kN", 1e-3, 4),
    "plot_axle_box_acceleration": (
        "axle_box_vertical_acceleration",
        "axle-box acceleration",
        "m/s²",
        1.0,
        4,
    ),
    "plot_rail_deflection": ("rail_vertical_displacement", "rail deflection", "mm", 1e3, 4),
    "plot_wheelset_displacement": (
        "wheelset_vertical_displacement",
        "wheelset displacement",
        "mm",
        1e3,
        4,
    ),
    "plot_bogie_acceleration": ("bogie_vertical_acceleration", "bogie", "m/s²", 1.0, 2),
    "plot_car_body_acceleration": ("car_body_vertical_acceleration", "car body", "m/s²", 1.0, 1),
}


@pytest.mark.parametrize("method", HISTORIES)
def test_a_history_is_that_of_the_data(result, ax, method):
    variable, words, unit, factor, count = HISTORIES[method]
    assert getattr(result, method)(ax=ax) is ax
    assert words in ax.get_ylabel()
    assert ax.get_ylabel().endswith(f"({unit})")
    assert ax.get_xlabel() == "distance travelled (m)"
    lines = ax.get_lines()
    assert len(lines) == count
    data = result[variable]
    first = data.isel({d: 0 for d in data.dims if d != "time"})
    np.testing.assert_allclose(lines[0].get_ydata(), first * factor, rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(lines[0].get_xdata(), result["distance"])


def test_options_choose_wheel_side_and_abscissa(result, ax):
    result.plot_wheel_force(wheelset=2, side="both", versus="time", ax=ax)
    left, right = ax.get_lines()
    assert [line.get_label() for line in (left, right)] == ["wheelset 2 left", "wheelset 2 right"]
    assert (left.get_ydata().max(), ax.get_xlabel()) == (222.0, "time (s)")
    assert right.get_ydata().max() < 80.0
    np.testing.assert_array_equal(left.get_xdata(), result["time"])


def test_a_sum_of_round_off_is_zero(result, ax):
    opposite = result.copy()
    sign = xr.DataArray([1.0, -1.0 - 1e-14], dims="side")
    opposite["guiding_force"] = opposite["guiding_force"] * sign
    opposite.plot_track_shifting_force(ax=ax)
    assert all((line.get_ydata() == 0.0).all() for line in ax.get_lines())
    result.plot_track_shifting_force(ax=(other := Figure().subplots()))
    y = result["guiding_force"].isel(wheelset=0).sum("side") / 1e3
    assert other.get_lines()[0].get_ydata() == pytest.approx(y.to_numpy())


def test_spectrum_states_its_window_and_the_passing_frequencies(result, ax):
    result.plot_spectrum(ax=ax)
    assert "whole slab lengths" in ax.get_title("left")
    *spectra, fastener, slab = ax.get_lines()
    frequency, amplitude = spectra[0].get_data()
    assert len(spectra) == 4
    assert amplitude.max() == pytest.approx(3.0, rel=0.16)
    assert frequency[amplitude.argmax()] == pytest.approx(80.0 / BAY, abs=2.0)
    assert fastener.get_xdata()[0] == pytest.approx(80.0 / BAY, rel=1e-3)
    assert slab.get_xdata()[0] == pytest.approx(10.0 / BAY, rel=1e-3)
    result.plot_spectrum("normal_force", window=(10.0, 50.0), ax=(other := Figure().subplots()))
    assert "10.00 to 50.00 m" in other.get_title("left")
    assert other.get_ylabel() == "amplitude (kN)"


def test_what_cannot_be_plotted_is_refused(result, ax):
    with pytest.raises(ParameterError, match=r"versus = 'way': must be distance or time"):
        result.plot_wheel_force(versus="way", ax=ax)
    with pytest.raises(ParameterError, match=r"side = 'middle': must be left, right or both"):
        result.plot_wheel_force(side="middle", ax=ax)
    with pytest.raises(ParameterError, match=r"wheelset = 5: must be from 1 to 4"):
        result.plot_wheel_force(wheelset=5, ax=ax)
    with pytest.raises(ParameterError, match=r"wheelset = 1: bogie.* is not of a wheelset"):
        result.plot_bogie_acceleration(wheelset=1, ax=ax)
    with pytest.raises(ParameterError, match=r"normal_forc'.*did you mean normal_force"):
        result.plot_history("normal_forc", ax=ax)
    with pytest.raises(ParameterError, match=r"guiding_force"):
        RunResult.of(result.drop_vars("guiding_force")).plot_track_shifting_force(ax=ax)


def test_it_stays_a_data_set_and_a_result(result):
    assert isinstance(result, xr.Dataset)
    part = result.isel(time=slice(100, 200))
    assert isinstance(part, RunResult)
    assert part.attrs == result.attrs
    again = pickle.loads(pickle.dumps(part))
    assert isinstance(again, RunResult)
    xr.testing.assert_identical(again, part)


def test_a_file_opens_as_a_result(tmp_path, result, ax):
    result.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with open_result(tmp_path / "run.nc") as found:
        assert isinstance(found, RunResult)
        found.plot_wheel_force(ax=ax)
        assert ax.get_lines()[1].get_ydata().max() == 222.0
        assert rail_cosim.summarise(found).window.stop == pytest.approx(60.0, abs=0.1)
    (tmp_path / "run.nc").unlink()  # closed
    with pytest.raises(ReportError, match="there is no such file"):
        open_result(tmp_path / "run.nc")


def test_without_axes_a_new_figure_is_made(result):
    from matplotlib import pyplot

    found = result.plot_rail_deflection()
    assert pyplot.fignum_exists(found.figure.number)
    pyplot.close(found.figure)
