"""The master with real FMUs: two small ones, built here and run in processes of their own."""

import json
import os
import subprocess
import sys
import textwrap
import zipfile
from pathlib import Path

import described_fmus
import numpy as np
import pytest
import xarray as xr
from fmpy.ssp.ssd import find_components, read_ssd
from product import PATIENCE
from rail_cosim.builder import SSP_NAME, Recipe, build, build_one, built_fmu, source_hash
from rail_cosim.cache import VARIABLE, is_plain, plain_directory
from rail_cosim.description import read_description
from rail_cosim.errors import BuildError, FmuFileError, RailCosimError
from rail_cosim.extraction import extract
from rail_cosim.osp import OSP_NAME
from rail_cosim.ssp import write_ssp

PACKAGES = ("rail_quantities", "rail_fmi")
RECIPES = {
    "vehicle": Recipe(model="MiniVehicle", entry="mini_vehicle_fmu", packages=PACKAGES),
    "track": Recipe(model="MiniTrack", entry="mini_track_fmu", packages=PACKAGES),
}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    return {name: build_one(recipe, folder) for name, recipe in RECIPES.items()}


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Run a script in a new process with a cache of its own; return its output."""
    cache = tmp_path_factory.mktemp("cache")
    path = os.pathsep.join(filter(None, sys.path))
    environment = os.environ | {VARIABLE: str(cache), "PYTHONPATH": path}

    def call(script, *arguments, status=0):
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(script), *map(str, arguments)],
            env=environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == status, done.stderr
        return done.stdout

    return call


# Command line: all cases in one process, which also shows that runs leave nothing behind.

STEADY = ["--speed", "300", "--distance", "40", "--line", "HD"]
SHORT = ["--distance", "20"]
CASES = {
    "steady": [*STEADY, "--out", "steady.nc", "--plot", "steady.png"],
    "thinned": [*STEADY, "--out", "thinned.nc", "--record-every", "5"],
    "iterative": [*SHORT, "--out", "i.nc", "--algorithm", "iterative-gauss-seidel"],
    "order": [
        *(*SHORT, "--line", "ZX", "--vehicle", "heavy", "--speed", "200", "--out", "order.nc"),
        *("--set", "track.fastener.spacing=0.7", "--set", "vehicle.speed=50"),
    ],
    "broken": [*SHORT, "--set", "track.fails_after=0.1", "--out", "broken.nc"],
    "diverging": [*SHORT, "--set", "track.diverges_after=0.1", "--out", "diverging.nc"],
    "diverging in parallel": [
        *(*SHORT, "--set", "track.diverges_after=0.1", "--out", "parallel.nc"),
        *("--algorithm", "jacobi"),
    ],
    "stopped": [*SHORT, "--set", "track.interrupted_after=0.1", "--out", "stopped.nc"],
    "warned": [*SHORT, "--set", "vehicle.wheel.mass=50"],
    "held": [*SHORT, "--set", "track.static_wheel_load=2e6", "--out", "held.nc"],
    "misspelt": ["--set", "track.fastener.vertical_stifness=4e7"],
    "negative": ["--set", "track.fastener.vertical_stiffness=-1"],
    "no line": ["--line", "HX"],
    "slow": ["--speed", "-3"],
    "nowhere": ["--distance", "0"],
    "algorithm": ["--algorithm", "gaus-seidel"],
    "picture": ["--plot", "run.doc"],
    "same": ["--vehicle", "TRACK"],
    "no file": ["--vehicle", "nothing.fmu"],
}
RUN_CASES = """
    import json, os, sys
    from typer.testing import CliRunner
    from rail_cosim.cli import app
    vehicle, track, folder, cases = sys.argv[1:]
    os.chdir(folder)
    found = {}
    for name, arguments in json.loads(cases).items():
        arguments = [track if a == "TRACK" else vehicle if a == "heavy" else a for a in arguments]
        if "--vehicle" not in arguments:
            arguments += ["--vehicle", vehicle]
        done = CliRunner().invoke(app, ["run", "--trust", "--track", track, *arguments])
        if not isinstance(done.exception, (SystemExit, type(None))):
            raise done.exception
        found[name] = done.exit_code, done.stdout, done.stderr
    print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def ran(fmus, python, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    out = python(RUN_CASES, fmus["vehicle"], fmus["track"], folder, json.dumps(CASES))
    return folder, json.loads(out)


def dataset(ran, name):
    with xr.open_dataset(ran[0] / name, engine="h5netcdf") as data:
        return data.load()


def test_a_run_prints_the_summary_and_writes_data_and_picture(ran):
    status, out, err = ran[1]["steady"]
    assert (status, err) == (0, "")
    for expected in ("3 whole slab lengths", "132.5 Hz", "real-time factor", "energy residual"):
        assert expected in out
    data = dataset(ran, "steady.nc")
    assert data.attrs["complete"] == 1
    assert data.sizes["time"] == data.attrs["steps"] + 1 == 4801
    assert float(data["distance"][-1]) == pytest.approx(40.0, abs=300 / 3.6 * 1e-4)
    assert (ran[0] / "steady.png").stat().st_size > 10_000


def test_the_force_of_the_steady_run_is_the_load(ran):
    force = dataset(ran, "steady.nc")["normal_force"].sum("side").squeeze()
    assert float(force[0]) == pytest.approx(900.0 * 77.0, rel=1e-9)  # starts in equilibrium
    assert float(force[-2000:].mean()) == pytest.approx(900.0 * 77.0, rel=1e-3)


def test_attributes_tell_what_was_run(ran, fmus):
    about = dataset(ran, "steady.nc").attrs
    assert about["line"] == "HD"
    assert about["track.fastener.count_per_slab"] == 8
    assert about["track.coupling.input_time"] == "step_start"
    assert about["vehicle.coupling.input_time"] == "step_end"
    assert about["vehicle.static_wheel_load"] == pytest.approx(900.0 * 77.0)
    assert about["track.static_wheel_load"] == about["vehicle.static_wheel_load"]
    assert about["vehicle_guid"] == read_description(fmus["vehicle"]).guid
    assert about["macro_step"] == 1e-4
    assert about["source"].startswith("rail-cosim ")
    assert about["date"].endswith("+00:00")


def test_thinned_records_are_the_same_values(ran):
    whole, thinned = dataset(ran, "steady.nc"), dataset(ran, "thinned.nc")
    for name in ("normal_force", "axle_box_vertical_acceleration", "distance"):
        assert np.array_equal(whole[name][::5], thinned[name], equal_nan=True)


def test_iteration_runs_with_rollback_of_the_fmus(ran):
    data = dataset(ran, "i.nc")
    assert ran[1]["iterative"][0] == 0
    assert 2.0 <= data.attrs["algorithm_passes_per_step"] < 5.0
    plain = dataset(ran, "steady.nc")["normal_force"].isel(time=slice(0, 2401))
    assert float(np.abs(data["normal_force"] - plain).max()) < 20.0  # of 34650 N


def test_presets_then_options_then_settings(ran):
    about = dataset(ran, "order.nc").attrs
    assert about["track.fastener.count_per_slab"] == 9  # from ZX
    assert about["track.fastener.spacing"] == 0.7  # --set wins
    assert about["vehicle.speed"] == 50.0  # --set wins over --speed
    assert about["speed_km_h"] == pytest.approx(180.0)


def test_an_error_of_an_fmu_keeps_what_was_recorded(ran):
    status, out, err = ran[1]["broken"]
    assert status == 1
    assert "track: fmi2DoStep failed at t = 0.0999 s (status fatal): " in err
    assert "the rail is broken, 100 %;\nweld it" in err
    assert "what was recorded is in broken.nc, marked incomplete" in err
    assert "incomplete run: 999 of 2400 steps" in out
    data, whole = dataset(ran, "broken.nc"), dataset(ran, "i.nc")
    assert data.attrs["complete"] == 0
    assert "the rail is broken" in data.attrs["ended_by"]
    assert data.sizes["time"] == 1000
    assert np.array_equal(data["time"], whole["time"][:1000])


@pytest.mark.parametrize(
    ("case", "file"), [("diverging", "diverging.nc"), ("diverging in parallel", "parallel.nc")]
)
def test_a_partner_that_diverges_is_found_in_its_step(ran, case, file):
    """Whether the slaves are stepped one after the other or from the same instant."""
    status, _, err = ran[1][case]
    assert status == 1
    if case == "diverging in parallel":  # else the vehicle may refuse it first
        assert "track.wheelset[1].contact.vertical_force is 1e+30 at t = 0.1 s" in err
    data = dataset(ran, file)
    assert data.attrs["complete"] == 0
    assert data.sizes["time"] == 1000
    assert np.abs(data["normal_force"]).max() < 1e7


def test_ctrl_c_keeps_what_was_recorded(ran):
    status, _, err = ran[1]["stopped"]
    assert status == 130
    assert "stopped by the user after 1000 of 2400 steps" in err
    data = dataset(ran, "stopped.nc")
    assert data.attrs["complete"] == 0
    assert data.sizes["time"] == 1001


def test_a_warning_of_an_fmu_is_shown_once(ran):
    status, out, err = ran[1]["warned"]
    assert status == 0
    assert out.endswith("the results were not kept: give --out FILE.nc to write them\n")
    assert "not kept" not in ran[1]["steady"][1]
    assert err.count("the wheel is light, 50 % of it is air") == 1
    assert err.startswith("rail-cosim: warning: vehicle: ")


def test_an_error_held_back_at_set_up_is_told_at_once(ran):
    status, _, err = ran[1]["held"]
    assert status == 2
    assert "static_wheel_load = 2e+06 N: the rail breaks at 1e6 N, 100 %" in err
    assert not (ran[0] / "held.nc").exists()


@pytest.mark.parametrize(
    ("case", "status", "message"),
    [
        (
            "misspelt",
            2,
            "track.fastener.vertical_stifness = 4e7: there is no parameter of this name; "
            "did you mean track.fastener.vertical_stiffness",
        ),
        (
            "negative",
            2,
            "track.fastener.vertical_stiffness = -1: must be at least 0 N/m; "
            "meaning: stiffness of the support",
        ),
        ("no line", 2, "--line = 'HX': there is no parameter set in MiniTrack.fmu of this name"),
        ("slow", 2, "--speed = -3.0: must be greater than 0 km/h"),
        ("nowhere", 2, "--distance = 0.0: must be greater than 0 m"),
        ("algorithm", 2, "did you mean gauss-seidel"),
        ("picture", 2, "--plot = 'run.doc': must end in .png or .pdf or .svg"),
        ("same", 2, "there is nothing to connect"),
        ("no file", 2, "nothing.fmu: there is no such file"),
    ],
)
def test_bad_input_is_one_plain_block(ran, case, status, message):
    found, out, err = ran[1][case]
    assert found == status
    assert out == ""
    assert err.startswith("rail-cosim: error: ")
    assert message in err
    assert "Traceback" not in err


def test_the_python_interface_mirrors_the_command(fmus, python, ran):
    script = """
        import sys, rail_cosim
        data = rail_cosim.run(
            vehicle=sys.argv[1], track=sys.argv[2], line="HD", speed=300.0, distance=40.0,
            settings={"track.fails_after": 0.0},
        )
        force = data["normal_force"]
        print(force.dims, float(force[-1, 0, 0]), rail_cosim.summarise(data).window.periods)
        try:
            rail_cosim.run(vehicle=sys.argv[1], track=sys.argv[2], distance=20.0,
                           settings={"track.fails_after": 0.1})
        except rail_cosim.errors.RunError as error:
            print(error.dataset.sizes["time"], error.dataset.attrs["complete"])
    """
    expected = float(dataset(ran, "steady.nc")["normal_force"][-1, 0, 0])
    out = python(script, fmus["vehicle"], fmus["track"]).splitlines()
    assert out == [f"('time', 'wheelset', 'side') {expected} 3", "1000 0"]


def test_several_instances_each_released_once(fmus, python):
    script = """
        import sys
        from pathlib import Path
        from rail_cosim.fmu import FmuSlave
        name = "wheelset[1].vertical_displacement"
        for turn in range(3):
            with FmuSlave(Path(sys.argv[1]), "a") as a, FmuSlave(Path(sys.argv[1]), "b") as b:
                for slave, height in ((a, 1e-3), (b, 2e-3)):
                    slave.set({"wheelset[1].initial_vertical_displacement": height})
                    slave.setup(0.0, 1.0)
                    slave.enter_initialization()
                    slave.exit_initialization()
                    slave.do_step(0.0, 1e-4)
                vectors = [slave.vector([name]) for slave in (a, b)]
                for vector in vectors:
                    vector.read()
                state = a.save_state()
                a.do_step(1e-4, 1e-4)
                after = a.get([name])[name]
                a.restore_state(state)
                assert a.get([name])[name] == vectors[0].values[0] != after
                a.do_step(1e-4, 1e-4)
                assert a.get([name])[name] == after
                a.free_state(state)
                print(round(vectors[1].values[0] - vectors[0].values[0], 12))
            a.close()
    """
    assert python(script, fmus["vehicle"]).split() == ["0.001"] * 3


def test_parameters_out_of_an_fmus_own_limits_are_refused_in_its_words(fmus, python):
    script = """
        import sys
        from pathlib import Path
        from rail_cosim.errors import SlaveError
        from rail_cosim.fmu import FmuSlave
        with FmuSlave(Path(sys.argv[1]), "wheel") as slave:
            slave.set({"wheel.mass": 0.0})
            slave.setup(0.0, 1.0)
            try:
                slave.enter_initialization()
            except SlaveError as error:
                print(error)
    """
    assert "wheel.mass = 0.0: must be greater than 0 kg" in python(script, fmus["vehicle"])


# Files: description, extraction, cache, building


def test_description_of_an_fmu(fmus):
    about = read_description(fmus["track"])
    stiffness = about.variables["fastener.vertical_stiffness"]
    assert (stiffness.kind, stiffness.causality, stiffness.unit) == ("real", "parameter", "N/m")
    assert (stiffness.start, stiffness.minimum, stiffness.maximum) == (8e7, 0.0, None)
    assert about.variables["fastener.count_per_slab"].start == 8
    assert about.units["N"] == {"kg": "1", "m": "1", "s": "-2"}
    assert about.variables["coupling.input_time"].choices == {"step_start": 0, "step_end": 1}
    assert about.can_save_state


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "this is no FMU"),
        ("<fmiModelDescription fmiVersion='3.0'/>", "FMI 3.0 without co-simulation"),
        (
            "<fmiModelDescription fmiVersion='2.0'><ModelExchange/></fmiModelDescription>",
            "FMI 2.0 without co-simulation; FMI 2.0 for co-simulation is needed",
        ),
        ("<fmiModel", "this is no FMU"),
    ],
)
def test_files_that_are_no_suitable_fmu_are_refused(tmp_path, content, message):
    path = tmp_path / "Other.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        if content is not None:
            archive.writestr("modelDescription.xml", content)
    with pytest.raises(FmuFileError, match=message):
        read_description(path)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('start="0"', 'start="1,5"', "could not convert string to float: '1,5'"),
        ('valueReference="1"', 'valueReference="one"', "invalid literal"),
        ("<Real", "<Annotations", "it has no type"),
    ],
)
def test_a_variable_that_cannot_be_read_is_named(tmp_path, old, new, reason):
    def edit(text):
        return text.replace(old, new)

    path = described_fmus.fmu(tmp_path / "a.fmu", {"x": ("input", "m")}, edit=edit)
    with pytest.raises(FmuFileError, match=f"its variable 'x' cannot be read .*{reason}"):
        read_description(path)


def test_text_and_directories_are_no_fmu(tmp_path):
    (tmp_path / "text.fmu").write_text("hello")
    for path in (tmp_path / "text.fmu", tmp_path):
        with pytest.raises(FmuFileError, match=r"no FMU|not an FMU"):
            read_description(path)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_extraction_is_keyed_by_guid_and_content(cache, tmp_path):
    path = tmp_path / "a.fmu"
    places = []
    for text in ("one", "two", "one"):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(zipfile.ZipInfo("resources/a.txt"), text)
        places.append(extract(path, "{12-ab}"))
        assert (places[-1] / "resources/a.txt").read_text() == text
    assert places[0] == places[2] != places[1]
    assert places[0].name.startswith("12-ab-")
    assert sorted(cache.glob("extracted/*")) == sorted(set(places))  # no leftovers


def test_an_archive_that_points_out_of_itself_is_refused(cache, tmp_path):
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../outside.txt", "x")
    with pytest.raises(FmuFileError, match=r"'\.\./outside\.txt' points out of the archive"):
        extract(path, "{1}")
    assert not (tmp_path / "outside.txt").exists()


@pytest.mark.parametrize("name", ["Übung", "a b", "c#1", "d%20"])
def test_a_path_that_must_be_encoded_is_replaced_by_a_plain_one(tmp_path, monkeypatch, name):
    monkeypatch.setenv(VARIABLE, str(tmp_path / name))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    place = plain_directory()
    assert is_plain(place)
    assert place.parent == tmp_path
    assert place == plain_directory()


def test_an_fmu_in_a_directory_with_umlauts_runs(fmus, python, tmp_path):
    folder = tmp_path / "Gleis #1 übung"
    folder.mkdir()
    path = folder / fmus["track"].name
    path.write_bytes(fmus["track"].read_bytes())
    script = """
        import os, sys
        from pathlib import Path
        os.environ["RAIL_COSIM_CACHE"] = str(Path(sys.argv[1]).parent / "cache")
        from rail_cosim.fmu import FmuSlave
        with FmuSlave(Path(sys.argv[1]), "track") as slave:
            print(slave.get(["fastener.spacing"]))
    """
    assert python(script, path).strip() == "{'fastener.spacing': 0.629}"


def test_no_place_for_the_cache_is_an_error_with_the_remedy(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "file" / "cache"))
    with pytest.raises(RailCosimError, match=f"set {VARIABLE} to a directory"):
        plain_directory()


def made_module(folder: Path, text: str) -> Recipe:
    package = folder / "made_package"
    package.mkdir(exist_ok=True)
    (package / "__init__.py").write_text(text)
    (folder / "made_entry.py").write_text("")
    return Recipe(model="Made", entry="made_entry", packages=("made_package",))


def test_an_fmu_is_built_anew_only_when_its_sources_change(cache, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    built = []

    def build(recipe, folder):
        built.append(recipe.model)
        path = folder / f"{recipe.model}.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("a", str(len(built)) * 100)
        return path

    monkeypatch.setattr("rail_cosim.builder.build_one", build)
    recipe = made_module(tmp_path, "a = 1")
    first = built_fmu(recipe)
    assert built_fmu(recipe) == first
    assert len(built) == 1
    made_module(tmp_path, "a = 2")
    assert built_fmu(recipe) != first
    made_module(tmp_path, "a = 1")
    assert built_fmu(recipe) == first
    assert len(built) == 2
    content = first.read_bytes()
    for damaged in (b"", content[:-30], content[:40] + b"?" + content[41:]):
        first.write_bytes(damaged)
        assert built_fmu(recipe) == first
        with zipfile.ZipFile(first) as archive:
            assert archive.testzip() is None
    assert len(built) == 5
    assert "made_package" not in sys.modules


def test_build_makes_both_fmus_and_the_system(cache, tmp_path, monkeypatch):
    monkeypatch.setattr("rail_cosim.builder.RECIPES", RECIPES)
    files = build(tmp_path / "out")
    expected = ["MiniVehicle.fmu", "MiniTrack.fmu", SSP_NAME, OSP_NAME]
    assert [path.name for path in files] == expected
    ssd = read_ssd(files[2])
    assert {c.name for c in find_components(ssd.system)} == {"vehicle", "track"}
    first = [path.read_bytes() for path in files]
    assert [path.read_bytes() for path in build(tmp_path / "out")] == first


def test_the_master_loads_nothing_that_an_fmu_carries(python):
    script = """
        import sys
        import rail_cosim.builder, rail_cosim.cli, rail_cosim.runner
        carried = ("rail_fmi", "rail_quantities", "rail_vehicle", "slab_track", "pythonfmu")
        print([name for name in carried if name in sys.modules])
    """
    assert python(script).strip() == "[]"


def test_a_module_that_is_not_installed_is_named():
    recipe = Recipe(model="None", entry="no_such_entry", packages=())
    with pytest.raises(BuildError, match="the module no_such_entry is not installed"):
        source_hash(recipe)


def test_a_failed_build_gives_the_reason(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "made_entry.py").write_text("raise RuntimeError('the mould is broken')")
    recipe = Recipe(model="Made", entry="made_entry", packages=PACKAGES)
    with pytest.raises(BuildError, match=r"Made\.fmu could not be built: .*the mould is broken"):
        build_one(recipe, tmp_path / "out")


def test_a_package_with_foreign_fmus_runs_as_its_parts_do(fmus, ran, python, tmp_path):
    """Other component names; the line's values are bound in the package."""
    write_ssp(
        tmp_path / "Pair.ssp", {"Rad": fmus["vehicle"], "Gleis": fmus["track"]}, {"Gleis": "HD"}
    )
    script = """
        import sys, rail_cosim
        data = rail_cosim.run(sys.argv[1], speed=300, distance=40, out=sys.argv[2])
        print(data.attrs["track.fastener.count_per_slab"])
    """
    assert python(script, tmp_path / "Pair.ssp", tmp_path / "ssp.nc").split() == ["8"]
    with xr.open_dataset(tmp_path / "ssp.nc", engine="h5netcdf") as found:
        expected = dataset(ran, "steady.nc")
        assert (found["normal_force"] == expected["normal_force"]).all()
        assert found.sizes["time"] == expected.sizes["time"]
