"""Studies: growth rates, the search for the critical speed, what is asked for and refused."""

import numpy as np
import pytest
import xarray as xr
from rail_cosim.errors import ParameterError, RailCosimError, RunError, UnknownNameError
from rail_cosim.studies import STUDIES, StudyOptions, run_study
from rail_cosim.studies import contact_geometry as geometry
from rail_cosim.studies import critical_speed as critical
from rail_cosim.studies.critical_speed import Attempt, bracket, conclude, search
from rail_cosim.studies.decay import analyse
from typer.testing import CliRunner

TIME = np.arange(0.0, 4.0, 5e-4)


def hunting(rate, frequency=6.0, amplitude=3e-3, offset=1e-3):
    """Four wheelsets that move alike with a shift in phase, about a place off the middle."""
    phases = 2.0 * np.pi * frequency * TIME[:, None] + np.arange(4)
    return offset + amplitude * np.exp(rate * TIME)[:, None] * np.sin(phases)


@pytest.mark.parametrize("frequency", [1.5, 6.0, 11.0])
@pytest.mark.parametrize("rate", [-1.5, -0.3, 0.3])
def test_growth_rate_of_an_oscillation_is_found(rate, frequency):
    motion = analyse(TIME, hunting(rate, frequency))
    assert motion.growth_rate == pytest.approx(rate, rel=0.02, abs=0.005)
    assert motion.frequency == pytest.approx(frequency, rel=0.03)
    assert motion.decrement == pytest.approx(-rate / frequency, rel=0.05, abs=0.002)
    assert motion.verdict == ("grows" if rate > 0.0 else "decays")
    assert motion.stable is (rate < 0.0)
    if abs(rate) < 1.0:  # else it changes much within the last block
        # Half the range over the last period; its middle lies half a period before the end.
        expected = 3e-3 * np.exp(rate * (4.0 - 0.5 / frequency))
        assert motion.final_amplitude == pytest.approx(expected, rel=0.04)


def test_a_motion_that_goes_on_is_a_limit_cycle_and_not_stable():
    motion = analyse(TIME, hunting(-1e-3, amplitude=8e-3))
    assert motion.verdict == "limit cycle"
    assert not motion.stable


def test_what_has_died_out_is_stable_though_a_ripple_goes_on():
    ripple = 5e-6 * np.sin(2.0 * np.pi * 30.0 * TIME)[:, None]
    motion = analyse(TIME, hunting(-20.0, offset=0.0) + ripple)
    assert motion.stable
    assert motion.final_amplitude < 2e-5


def made(speed, rate):
    lateral = hunting(rate)
    motion = analyse(TIME, lateral)
    return Attempt(speed=speed, motion=motion, time=TIME, lateral=lateral)


def test_the_search_halves_down_to_its_resolution():
    tried = []

    def try_speed(speed):
        tried.append(speed)
        return made(speed, (speed - 437.0) / 100.0)

    attempts = search(try_speed, resolution=10.0)
    assert tried[:4] == [200.0, 300.0, 400.0, 500.0]
    low, high = bracket(attempts)
    assert low < 437.0 < high
    assert high - low <= 10.0
    assert [one.speed for one in attempts] == sorted(tried)
    assert "critical speed 43" in conclude(attempts)


def test_a_search_without_an_unstable_speed_says_up_to_where_it_looked():
    attempts = search(lambda speed: made(speed, -1.0), resolution=10.0)
    assert [one.speed for one in attempts] == list(critical.SPEEDS)
    assert conclude(attempts).startswith("no critical speed up to 600 km/h")


def test_a_search_that_starts_unstable_says_so():
    attempts = search(lambda speed: made(speed, 1.0), resolution=10.0)
    assert len(attempts) == 1
    assert conclude(attempts) == "the critical speed is below 200 km/h, the lowest speed tried"


def recorded(speed, rate, count=None):
    lateral = xr.DataArray(hunting(rate)[:count], dims=("time", "wheelset"))
    return xr.Dataset({"wheelset_lateral_displacement": lateral}, coords={"time": TIME[:count]})


def test_the_study_writes_data_and_plot_and_passes_settings_on(tmp_path, monkeypatch):
    asked = []

    def execute(options, reporter):
        asked.append(options)
        return recorded(options.speed, (options.speed - 450.0) / 100.0)

    monkeypatch.setattr(critical, "execute", execute)
    settings = ["vehicle.yaw_damper.damping=0"]
    options = StudyOptions(out=tmp_path / "new", quick=True, settings=settings, command="typed")
    result = run_study("critical-speed", options, Silent())
    assert list(asked[0].settings) == [*critical.COARSE, *settings]
    assert asked[0].distance == pytest.approx(200.0 / 3.6 * 2.5)
    assert result.conclusion.startswith("critical speed 4")
    data, picture = result.files
    with xr.open_dataset(data, engine="h5netcdf") as file:
        found = file.load()
    assert found.attrs["highest_stable_speed_km_h"] <= 450.0
    assert found.attrs["lowest_unstable_speed_km_h"] >= 450.0
    assert found["growth_rate"].sel(speed=300.0) == pytest.approx(-1.5, rel=0.02)
    assert found["speed"].attrs["units"] == "km/h"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert result.table.row_count == found.sizes["speed"]


class Silent:
    def stage(self, text):
        pass

    progress = notice = stage


def test_a_derailment_is_unstable_and_any_other_failure_an_error(tmp_path, monkeypatch):
    def execute(options, reporter):
        far = 5.0 if options.speed > 250.0 else -3.0
        if options.speed > 250.0:
            raise RunError("a wheel left its rail", recorded(0.0, far, 1500))
        return recorded(options.speed, far)

    monkeypatch.setattr(critical, "execute", execute)
    options = StudyOptions(out=tmp_path, quick=True)
    one = critical.attempt(300.0, options, Silent())
    assert one.verdict == "derails"
    assert not one.stable
    assert run_study("critical-speed", options, Silent()).conclusion.startswith("critical speed 2")

    def broken(options, reporter):
        raise RunError("no convergence", recorded(0.0, -1.0, 1500))

    monkeypatch.setattr(critical, "execute", broken)
    with pytest.raises(RunError, match="no convergence"):
        critical.attempt(300.0, options, Silent())


def test_the_speed_cannot_be_set_in_a_study_of_speeds(tmp_path):
    options = StudyOptions(out=tmp_path, settings=["vehicle.speed=80"])
    with pytest.raises(ParameterError, match=r"vehicle\.speed = 80: the study sets the speed"):
        run_study("critical-speed", options, Silent())


def test_an_unknown_study_is_refused_with_all_there_are(tmp_path):
    message = rf"did you mean critical-speed\? \(there are {', '.join(STUDIES)}\)"
    with pytest.raises(UnknownNameError, match=message):
        run_study("critical-sped", StudyOptions(out=tmp_path), Silent())


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_is_in_the_help(name):
    from rail_cosim.cli import app

    assert name in CliRunner().invoke(app, ["study", "--help"]).stdout


def test_contact_geometry_from_the_track_package(tmp_path):
    settings = ["track.contact.rail_profile=60E1", "track.rail.gauge_measurement_depth=0.014"]
    options = StudyOptions(out=tmp_path, quick=True, settings=settings)
    result = run_study("contact-geometry", options, Silent())
    with xr.open_dataset(result.files[0], engine="h5netcdf") as file:
        table = file.load()
    assert table.attrs["rail"] == "60E1"
    assert table.attrs["depth"] == 0.014
    y = table["lateral_displacement"].to_numpy()
    assert (y[0], y[-1]) == (-8e-3, 8e-3)
    # Both sides are alike: mirrored, the right wheel is the left one.
    for name in ("contact_angle", "wheel_position", "rail_position"):
        left, right = (table[name].sel(side=side).to_numpy() for side in ("left", "right"))
        assert left == pytest.approx(right[::-1], abs=1e-6)
    difference = table["rolling_radius_difference"].to_numpy()
    assert (np.diff(difference) > 0.0).all()
    assert f"{table.attrs['equivalent_conicity']:.4f}" in result.conclusion
    assert result.files[1].read_bytes().startswith(b"\x89PNG")


def test_a_conicity_that_is_not_defined_is_explained():
    about = {"equivalent_conicity": float("nan"), "conicity_amplitude": 3e-3}
    why = "no kinematic motion"
    said = geometry.conclude(about | {"equivalent_conicity_not_defined": why})
    assert said == f"equivalent conicity at 3 mm: not defined: {why}"


def test_contact_geometry_refuses_what_it_does_not_take(tmp_path):
    options = StudyOptions(out=tmp_path, settings=["track.fastener.spacing=0.6"])
    with pytest.raises(UnknownNameError, match="no parameter for this study of this name"):
        geometry.as_arguments(options)
    with pytest.raises(ParameterError, match="there is no value"):
        geometry.as_arguments(StudyOptions(out=tmp_path, settings=["track.rail.gauge"]))
    options = StudyOptions(out=tmp_path, quick=True, settings=["track.contact.rail_profile=60E9"])
    with pytest.raises(RailCosimError, match=r"contact\.rail_profile = '60E9'.*did you mean 60E1"):
        run_study("contact-geometry", options, Silent())
