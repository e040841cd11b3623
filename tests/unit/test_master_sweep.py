"""Sweeps without FMUs: specification, statistics, the store, workers, the joined Dataset."""

import dataclasses
import math

import numpy as np
import pytest
import xarray as xr
from distributed import Client
from rail_cosim.errors import ParameterError, RailCosimError, UnknownNameError
from rail_cosim.options import RunOptions
from rail_cosim.sweeps import PointResult, Store, SweepSpecification, read_specification, run_plan
from rail_cosim.sweeps.assembly import assemble
from rail_cosim.sweeps.cluster import worker_count
from rail_cosim.sweeps.plan import FmuFile, Plan, Task
from rail_cosim.sweeps.quantities import evaluate, histories
from rail_cosim.window import WindowChoice, last_slabs

STIFFNESS = "track.fastener.vertical_stiffness"
FILE = """
[run]
line = "HD"
[set]
track.rail.mode_count = 200
track.rail.residual_compliance = false
[grid]
speed = { start = 80, stop = 400, step = 160 }
track.fastener.vertical_stiffness = [40e6, 140e6]
[keep]
normal_force = ["max"]
[history]
variables = ["normal_force"]
every = 5
"""


def written(tmp_path, text):
    path = tmp_path / "spec.toml"
    path.write_text(text)
    return path


def test_a_file_gives_axes_settings_and_options(tmp_path):
    found = read_specification(written(tmp_path, FILE))
    assert dict(found.grid) == {"speed": [80, 240, 400], STIFFNESS: [40e6, 140e6]}
    assert found.shape == (3, 2)
    points = found.all_points()
    assert points[1] == {"speed": 80, STIFFNESS: 140e6}
    options = found.options(points[5])
    assert (options.speed, options.line, options.distance) == (400, "HD", 500.0)
    assert options.until_steady == 1e-3
    assert sorted(options.settings) == [
        f"{STIFFNESS}=140000000.0",
        "track.rail.mode_count=200",
        "track.rail.residual_compliance=false",
    ]
    assert (tuple(found.history), found.history_every) == (("normal_force",), 5)


def test_single_points_and_a_fixed_distance(tmp_path):
    text = """
    [run]
    until_steady = false
    distance = 30
    [[points]]
    speed = 100
    track.slab_support.basis = "per_bay"
    [[points]]
    speed = 200
    track.slab_support.basis = "per_slab"
    """
    found = read_specification(written(tmp_path, text))
    assert found.shape == (2,)
    options = found.options(found.all_points()[1])
    assert (options.until_steady, options.distance, options.speed) == (None, 30, 200)
    assert list(options.settings) == ["track.slab_support.basis=per_slab"]


def test_a_run_on_irregular_track_is_not_to_become_steady(tmp_path):
    text = "[run]\nirregularity = 'german_low'\n{}\n[grid]\nspeed = [200]\n[window]\nfrom = 20"
    found = read_specification(written(tmp_path, text.format("")))
    assert found.options({"speed": 200}).until_steady is None
    assert found.window_choice == WindowChoice(start=20)
    far = read_specification(written(tmp_path, text.format("distance = 19")))
    with pytest.raises(ParameterError, match=r"window\.from = 20: the run ends at 19 m"):
        far.options({"speed": 200})
    wanted = read_specification(written(tmp_path, text.format("until_steady = 0.01")))
    assert wanted.options({"speed": 200}).until_steady == 0.01


REFUSED = {
    "no TOML": ("[grid", "is no TOML file"),
    "nothing to vary": ("[run]\nspeed = 100", "needs axes or single points"),
    "unknown section": ("[grids]\nspeed = [1]", r"grids.*did you mean grid"),
    "unknown axis": ("[grid]\nsped = [1]", r"sped.*did you mean speed"),
    "unknown option": ("[run]\nlines = 'HD'\n[grid]\nspeed = [1]", r"run\.lines.*mean line"),
    "no list": ("[grid]\nspeed = 3", "must be a list"),
    "a broken range": ("[grid]\nspeed = {start = 1, stop = 2, step = 0.3}", "whole number of step"),
    "no step": ("[grid]\nspeed = {start = 1, stop = 2, step = 0}", "whole number of steps"),
    "a value twice": ("[grid]\nspeed = [1, 1]", "must be different values"),
    "an axis without values": ("[grid]\nspeed = []", "at least one"),
    "fixed and varied": ("[run]\nspeed = 3\n[grid]\nspeed = [1]", "axis and fixed at once"),
    "points that differ": (
        "[[points]]\nspeed = 1\n[[points]]\nline = 'HD'",
        "every point must give the same axes: speed",
    ),
    "unknown statistic": (
        "[grid]\nspeed = [1]\n[keep]\nnormal_force = ['maximum']",
        r"keep\.normal_force = 'maximum': .*max",
    ),
    "unknown percentile": ("[grid]\nspeed = [1]\n[keep]\nnormal_force = ['p101']", "p101.*p99.85"),
    "unknown window": ("[grid]\nspeed = [1]\n[window]\nstart = 3", r"window\.start.*from"),
    "a periodic statistic of the whole run": (
        "[run]\nuntil_steady = false\n[grid]\nspeed = [1]\n[keep]\nnormal_force = ['slab_peak']",
        r"keep\.normal_force = 'slab_peak': .* choose last_slabs = 1 below \[window\]",
    ),
    "unknown entry": ("[grid]\nspeed = [1]\n[history]\nall = 3", r"history\.all"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_specification_without_sense_is_refused(tmp_path, case):
    text, message = REFUSED[case]
    with pytest.raises(ParameterError, match=message):
        read_specification(written(tmp_path, text))


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        read_specification(tmp_path / "none.toml")


# Statistics

BAY, COUNT, SPEED, STEP = 0.625, 8, 50.0, 1e-3  # a pitch is 100 records


def made_run(records=350):
    """Wheels 1 and 2 with a bay's wave that grows from slab to slab; the second lifts off."""
    time = STEP * np.arange(1, records + 1)
    x = SPEED * time
    size = np.ceil((x - 1e-9) / (BAY * COUNT))[:, None, None] * np.array([1.0, 3.0])[:, None]
    force = 2.5 + size * np.sin(2 * np.pi * x / BAY)[:, None, None]
    about = {"units": "N", "long_name": "normal force"}
    return xr.Dataset(
        {
            "distance": ("time", x),
            "normal_force": (("time", "wheelset", "side"), force, about),
        },
        coords={"time": time, "wheelset": [1, 2], "side": ["left"]},
        attrs={"track.fastener.spacing": BAY, "track.fastener.count_per_slab": COUNT},
    )


LAST_SLAB = WindowChoice(last_slabs=1)


def test_statistics_of_a_steady_run_are_those_of_the_last_slab():
    """Records 251 to 350: half in the third slab, half in the fourth."""
    run = made_run()
    assert last_slabs(run).rows == slice(250, 350)
    statistics = ["max", "min", "mean", "half_range", "rms", "peak", "dominant_frequency"]
    run.attrs["steady"] = 1
    found = evaluate(run, {"normal_force": statistics})
    crest = np.sin(2 * np.pi * 3 / 12.5)  # nearest record to the crest: 12.5 records a bay

    def left(name):
        return found[f"normal_force_{name}"].sel(side="left").to_numpy()

    sizes = np.array([1.0, 3.0])
    assert left("max") == pytest.approx(2.5 + 4.0 * sizes * crest, rel=0.01)
    assert left("half_range") == pytest.approx(4.0 * sizes, rel=0.01)
    assert left("mean") == pytest.approx(2.5, abs=1e-9)
    assert left("rms") == pytest.approx(sizes * math.sqrt((9 + 16) / 4), rel=1e-9)
    assert left("peak") == pytest.approx(np.maximum(left("max"), -left("min")))
    assert left("dominant_frequency") == pytest.approx(SPEED / BAY)
    assert found["normal_force_max"].attrs["units"] == "N"
    assert found["normal_force_dominant_frequency"].attrs["units"] == "Hz"


def kept(run, statistic, choice=None):
    found = evaluate(run, {"normal_force": [statistic]}, choice)
    return found[f"normal_force_{statistic}"]


def test_statistics_of_another_run_are_those_of_the_whole():
    run = made_run()
    run["normal_force"][7, 1, 0] = 99.0
    largest = kept(run, "max")
    np.testing.assert_array_equal(largest, run["normal_force"].to_numpy().max(axis=0))
    assert float(largest.max()) == 99.0
    assert largest.attrs["evaluation_window"] == "whole run"
    steady = kept(run.assign_attrs(steady=0), "max")
    assert steady.attrs["evaluation_window"] == "last slab length"
    assert float(steady.max()) < 20.0


@pytest.mark.parametrize(
    ("entries", "rows", "words"),
    [
        ({"from": 5.0}, slice(99, 350), "distance travelled 5 m to the end"),
        ({"to": 5.0}, slice(0, 100), "distance travelled 0 m to 5 m"),
        ({"from": 5.01, "to": 10.0}, slice(100, 200), "distance travelled 5.01 m to 10 m"),
        ({"last_slabs": 3}, slice(50, 350), "last 3 slab lengths"),
        ({"to": 17.55}, slice(0, 350), "distance travelled 0 m to 17.55 m"),  # a step beyond
    ],
)
def test_a_window_is_chosen_by_distance_or_by_slabs(entries, rows, words):
    run = made_run()
    found = kept(run, "rms", WindowChoice.of(entries))
    expected = run["normal_force"].to_numpy()[rows].std(axis=0)
    np.testing.assert_allclose(found.to_numpy(), expected, rtol=1e-12)
    assert found.attrs["evaluation_window"] == words


BAD_WINDOWS = {
    "unknown": ({"start": 3}, r"window\.start = 3: .*from, to, last_slabs"),
    "order": ({"from": 5, "to": 5}, r"window\.from = 5: must be less than window\.to = 5 m"),
    "negative": ({"from": -1}, r"window\.from = -1: must be at least 0 m"),
    "text": ({"to": "5 m"}, r"window\.to = '5 m': must be a number"),
    "both": ({"from": 3, "last_slabs": 1}, r"window\.from = 3: .*last_slabs.*give one of them"),
    "no slab": ({"last_slabs": 0}, r"window\.last_slabs = 0: must be at least 1"),
    "part of a slab": ({"last_slabs": 1.5}, r"window\.last_slabs = 1\.5: must be a whole"),
    "too far": ({"to": 18.0}, r"window\.to = 18\.0: the run ends at 17\.\d+ m; .*longer distance"),
    "beyond": ({"from": 20}, r"window\.from = 20: the run ends at 17\.\d+ m"),
    "nothing": ({"from": 9.99, "to": 9.999}, r"window\.from = 9\.99: there are 0 records"),
    "too many": ({"last_slabs": 4}, r"last_slabs = 4: the run has 3 whole slab lengths"),
}


@pytest.mark.parametrize("case", BAD_WINDOWS)
def test_a_window_that_makes_no_sense_is_refused(case):
    entries, message = BAD_WINDOWS[case]
    with pytest.raises(ParameterError, match=message):
        kept(made_run(), "max", WindowChoice.of(entries))


def test_percentiles_by_name():
    run = made_run()
    for name, percent in (("p50", 50), ("p99.85", 99.85), ("p0.15", 0.15)):
        expected = np.percentile(run["normal_force"].to_numpy(), percent, axis=0)
        np.testing.assert_allclose(kept(run, name).to_numpy(), expected, rtol=1e-12)
    assert "99.85 % percentile" in kept(run, "p99.85").attrs["long_name"]


def test_percentile_of_en_14363_is_that_of_the_filtered_signal():
    """The wave of 80 Hz goes through a low-pass of 20 Hz as by 4^-4; the mean remains."""
    run = made_run(2000)
    run["normal_force"][:] = 2.5 + np.sin(2 * np.pi * 80.0 * run["time"].to_numpy())[:, None, None]
    found = kept(run, "p99.85_20_hz", WindowChoice(start=50.0)).to_numpy()
    assert found == pytest.approx(2.5 + 4.0**-4, abs=1e-3)
    assert kept(run, "p99.85", WindowChoice(start=50.0)).to_numpy() == pytest.approx(3.5, abs=0.01)


def test_what_is_periodic_is_not_taken_from_any_window():
    for statistic in ("slab_peak", "half_range_500_hz"):
        with pytest.raises(ParameterError, match=f"{statistic}.*whole slab lengths; choose last_s"):
            kept(made_run(), statistic)
    two = kept(made_run(), "slab_peak", WindowChoice(last_slabs=2))
    assert two.to_numpy().max() > 0.5  # the wave grows from slab to slab


def test_lift_off_is_the_time_without_force():
    found = evaluate(made_run(), {"normal_force": ["lift_off_time"]}, LAST_SLAB)
    force = made_run()["normal_force"].to_numpy()[250:, :, 0]
    expected = [np.sum(force[:, wheel] <= 0.0) * STEP for wheel in (0, 1)]
    assert 0.0 < expected[0] < expected[1]
    assert found["normal_force_lift_off_time"].to_numpy()[:, 0] == pytest.approx(expected)


def test_histories_are_records_with_their_time():
    run = made_run()
    found = histories(run, ["normal_force"], 7)
    assert found["normal_force_history"].dims == ("record", "wheelset", "side")
    np.testing.assert_array_equal(found["normal_force_history"], run["normal_force"][::7])
    np.testing.assert_array_equal(found["time_history"], run["time"][::7])
    assert found["time_history"].dims == ("record",)


def test_a_run_shorter_than_a_slab_gives_its_second_half():
    assert last_slabs(made_run(80)).rows == slice(40, 80)


def test_what_a_run_does_not_have_is_refused():
    with pytest.raises(UnknownNameError, match="did you mean normal_force"):
        evaluate(made_run(), {"normal_forc": ["max"]})


# Workers and store, with a stand-in for the runs

SPEEDS, STIFFNESSES = (100, 200, 300), (40e6, 140e6)
FMUS = {name: FmuFile(name=f"{name}.fmu", identity=name) for name in ("track", "vehicle")}


def made_plan(**more):
    specification = SweepSpecification(grid={"speed": SPEEDS, STIFFNESS: STIFFNESSES}, **more)
    tasks = [
        Task(
            options=specification.options(point),
            parameters={"track": {"stiffness": point[STIFFNESS]}, "vehicle": {"s": point["speed"]}},
            fmus=FMUS,
            keep={},
            history=(),
            history_every=1,
        )
        for point in specification.all_points()
    ]
    about = {"speed": ("km/h", "running speed"), STIFFNESS: ("N/m", "stiffness")}
    return Plan(specification=specification, tasks=tasks, files={}, about=about)


def stand_in(task):
    speed, stiffness = task.options.speed, task.parameters["track"]["stiffness"]
    if speed == 200 and stiffness == 140e6:
        return PointResult(data=xr.Dataset(), error="the vehicle left the rails")
    values = speed + stiffness * np.array([1e-6, 2e-6])
    data = {"force": ("wheelset", values, {"units": "N"})}
    remarks = ("loose bolts",) if speed == 100 else ()
    return PointResult(data=xr.Dataset(data, coords={"wheelset": [1, 2]}), remarks=remarks)


class Notes:
    def __init__(self):
        self.notices, self.done = [], []

    def stage(self, text):
        pass

    def progress(self, done, planned):
        self.done.append((done, planned))

    def notice(self, text):
        self.notices.append(text)


@pytest.fixture(scope="module")
def client():
    with Client(
        processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None
    ) as client:
        yield client


def times(folder):
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.nc")}


def test_results_are_in_the_order_of_the_points_and_labelled(tmp_path, client):
    plan, notes = made_plan(), Notes()
    found = run_plan(plan, Store(tmp_path), notes, scheduler=client, evaluate=stand_in)
    data = assemble(plan, found)
    assert data["force"].dims == ("speed", STIFFNESS, "wheelset")
    for speed in SPEEDS:
        for stiffness in STIFFNESSES:
            at = data.sel({"speed": speed, STIFFNESS: stiffness})
            failed = speed == 200 and stiffness == 140e6
            expected = np.full(2, np.nan) if failed else speed + stiffness * np.array([1, 2]) * 1e-6
            np.testing.assert_array_equal(at["force"], expected)
            assert str(at["error"].item()) == ("the vehicle left the rails" if failed else "")
    assert data["speed"].attrs == {"units": "km/h", "long_name": "running speed"}
    assert data["force"].attrs["units"] == "N"
    assert notes.notices == ["loose bolts"]
    assert notes.done == [(i, 6) for i in range(7)]


def test_nothing_is_run_twice_and_the_result_is_the_same(tmp_path, client):
    plan = made_plan()
    first = run_plan(plan, Store(tmp_path), Notes(), scheduler=client, evaluate=stand_in)
    before = times(tmp_path)
    assert len(before) == 6
    (tmp_path / f"{plan.tasks[2].key}.nc").unlink()
    (tmp_path / f"{plan.tasks[4].key}.nc").write_bytes(b"damaged")
    second = run_plan(plan, Store(tmp_path), Notes(), scheduler=client, evaluate=stand_in)
    after = times(tmp_path)
    changed = {name for name in after if after[name] != before[name]}
    assert changed == {f"{plan.tasks[i].key}.nc" for i in (2, 4)}
    assert assemble(plan, second).identical(assemble(plan, first))


def test_all_in_the_store_needs_no_workers(tmp_path, client):
    plan = made_plan()
    run_plan(plan, Store(tmp_path), Notes(), scheduler=client, evaluate=stand_in)
    nowhere = "tcp://127.0.0.1:1"
    again = run_plan(plan, Store(tmp_path), Notes(), scheduler=nowhere, evaluate=stand_in)
    assert [result.error for result in again].count("") == 5


@pytest.mark.parametrize("engine", [None, "h5netcdf"])
def test_the_store_gives_back_what_it_was_given(engine, tmp_path):
    """Also from HDF5 files, as stores of earlier versions have them."""
    about = {"units": "m/s²", "long_name": "acceleration"}
    data = xr.Dataset(
        {"peak": (("wheelset", "side"), np.array([[1.5, np.nan]]), about), "steady": ((), 1)},
        coords={"wheelset": [1], "side": ["left", "right"]},
    )
    result = PointResult(data=data, error="Weiche ≠ gerade", remarks=("a", "b, c"))
    store = Store(tmp_path)
    store.save("key", result)
    if engine:
        with xr.open_dataset(store.path("key"), engine="scipy") as file:
            old = file.load()
        old.to_netcdf(store.path("key"), engine=engine)
    found = store.load("key")
    assert found.data.identical(data)
    assert (found.error, found.remarks) == (result.error, result.remarks)
    store.path("bad").write_bytes(b"CDF but no more")
    assert store.load("bad") is None


def crashing(task):
    if task.options.speed == 300:
        raise MemoryError("no more")
    return stand_in(task)


def test_a_point_that_breaks_the_worker_is_reported_but_not_kept(tmp_path, client):
    plan = made_plan()
    found = run_plan(plan, Store(tmp_path), Notes(), scheduler=client, evaluate=crashing)
    assert [result.error for result in found[4:]] == ["no result (MemoryError: no more)"] * 2
    assert len(times(tmp_path)) == 4
    again = run_plan(plan, Store(tmp_path), Notes(), scheduler=client, evaluate=stand_in)
    assert again[5].error == ""


def test_histories_of_different_length_end_in_nothing():
    plan = dataclasses.replace(
        made_plan(),
        specification=SweepSpecification(grid={"speed": [1, 2]}),
        about={"speed": ("km/h", "speed")},
    )
    histories = [xr.Dataset({"force_history": ("record", np.arange(1.0, n))}) for n in (4, 6)]
    data = assemble(plan, [PointResult(data=one) for one in histories])
    expected = [[1, 2, 3, np.nan, np.nan], [1, 2, 3, 4, 5]]
    np.testing.assert_array_equal(data["force_history"], expected)


def test_single_points_are_coordinates_of_one_dimension():
    points = [{"speed": 100.0, "line": "HD"}, {"speed": 90.0, "line": "ZX"}]
    specification = SweepSpecification(points=points)
    plan = dataclasses.replace(
        made_plan(),
        specification=specification,
        about={"speed": ("km/h", "speed"), "line": ("1", "line")},
    )
    found = [PointResult(data=xr.Dataset({"force": ((), v)})) for v in (1.0, 2.0)]
    data = assemble(plan, found)
    assert data["force"].dims == ("point",)
    assert data["line"].to_numpy().tolist() == ["HD", "ZX"]


KEYED = {
    "options": RunOptions(distance=70.0),
    "parameters": {"track": {"stiffness": 41e6}, "vehicle": {}},
    "fmus": FMUS | {"track": FmuFile(name="track.fmu", identity="rebuilt")},
    "keep": {"normal_force": ["min"]},
    "history": ("normal_force",),
    "window": WindowChoice(last_slabs=2),
}


@pytest.mark.parametrize("field", KEYED)
def test_the_key_says_all_that_the_result_depends_on(field):
    task = made_plan().tasks[0]
    assert dataclasses.replace(task).key == task.key
    assert dataclasses.replace(task, **{field: KEYED[field]}).key != task.key


def test_a_changed_file_is_another_point(tmp_path):
    profile = tmp_path / "wheel.txt"
    parameters = {"track": {"contact.wheel_profile": str(profile)}, "vehicle": {}}
    keys = []
    for text in ("0 0", "0 1"):
        profile.write_text(text)
        keys.append(dataclasses.replace(made_plan().tasks[0], parameters=parameters).key)
    assert keys[0] != keys[1]


def test_workers_are_no_more_than_points():
    assert worker_count(8, 3) == 3
    with pytest.raises(ParameterError, match="--workers = 0: must be at least 1"):
        worker_count(0, 3)


def test_a_scheduler_that_does_not_answer_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr("rail_cosim.sweeps.cluster._CONNECT", "0.5s")
    with pytest.raises(RailCosimError, match=r"tcp://127\.0\.0\.1:1.*no Dask scheduler"):
        run_plan(made_plan(), Store(tmp_path), Notes(), scheduler="tcp://127.0.0.1:1")


def test_the_slab_part_is_what_does_not_repeat_from_bay_to_bay():
    run = made_run()
    x = run["distance"].to_numpy()
    bays = 5.0 * np.sin(2 * np.pi * x / BAY) + 2.0 * np.cos(4 * np.pi * x / BAY)
    slab = 0.7 * np.cos(2 * np.pi * 3 * x / (BAY * COUNT))
    run["normal_force"][:] = (4.0 + bays + slab)[:, None, None]
    found = evaluate(run, {"normal_force": ["slab_peak"]}, LAST_SLAB)["normal_force_slab_peak"]
    assert found.to_numpy() == pytest.approx(0.7, rel=0.01)
    assert found.attrs["units"] == "N"
    del run.attrs["track.fastener.spacing"]
    with pytest.raises(ParameterError, match="fastener spacing"):
        evaluate(run, {"normal_force": ["slab_peak"]}, LAST_SLAB)
