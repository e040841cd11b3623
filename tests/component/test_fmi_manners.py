"""What a tool may do with an FMU: orders of calls, step sizes, threads, folders."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from fmi_builds import PACKAGES, mass_spring_fmu, run_host, run_process
from fmu_probes import STEP_SIZES, uneven_steps
from rail_fmi.builder import build_fmu

START = "import sys, os; from fmu_host import Host; F = sys.argv[1]\n"


def run(code, *more, **keywords):
    return run_host(
        START + textwrap.dedent(code), mass_spring_fmu(), *more, **keywords
    ).splitlines()


ORDERS = {
    "all before": ["set", "setup", "enter", "exit"],
    "after the experiment": ["setup", "set", "enter", "exit"],
    "in initialization": ["setup", "enter", "set", "exit"],
    "twice": ["set", "setup", "enter", "set", "exit"],
    "with values read between": ["setup", "enter", "read", "set", "read", "exit"],
    "after a reset": ["setup", "enter", "exit", "step", "reset", "set", "setup", "enter", "exit"],
    "reset at once": ["reset", "setup", "set", "enter", "exit"],
}
ORDER = """
    host = Host(F)
    calls = {
        "set": lambda: host.set(mass=50.0, spring__stiffness=2e4, spring__law="cubic",
                                substeps=3, gravity=True, force=100.0),
        "setup": lambda: host.fmu.setupExperiment(startTime=0.0),
        "enter": host.fmu.enterInitializationMode,
        "exit": host.fmu.exitInitializationMode,
        "read": lambda: host.get("position"),
        "reset": lambda: (host.fmu.reset(), setattr(host, "time", 0.0)),
        "step": lambda: host.step(3),
    }
    for name in sys.argv[2:]:
        calls[name]()
    for _ in range(5):
        assert host.step() is None, host.texts()
    print(repr(host.get("position")), repr(host.get("velocity")), host.get("omega"))
    host.close()
"""


@pytest.mark.parametrize("order", ORDERS)
def test_any_order_of_set_up_calls_gives_the_same(order):
    assert run(ORDER, *ORDERS[order]) == run(ORDER, *ORDERS["all before"])


def test_reset_brings_start_values_back():
    """Nothing of what was set before is left."""
    lines = run("""
        fresh, used = Host(F, "fresh"), Host(F, "used")
        used.initialize(mass=50.0, force=300.0).step(4)
        used.fmu.reset()
        used.time = 0.0
        for host in (fresh, used):
            host.initialize().step(3)
            print([v for v in host.outputs() if not isinstance(v, str)], host.get("mass"))
            host.close()
    """)
    assert lines[0] == lines[1]


def test_first_inputs_can_be_kept():
    """What a tool sets before the first step is then not used; a saved state knows it too."""
    lines = run("""
        def moved(first, keep, saved=False):
            host = Host(F).initialize(force=100.0, coupling__keep_first_inputs=keep)
            if saved:
                state = host.fmu.getFMUstate()
                host.step(3)
                host.fmu.setFMUstate(state)
                host.time = 0.0
            for force in (first, 70.0, 50.0):
                host.set(force=force).step()
            found = repr(host.get("position"))
            host.close()
            return found
        print(moved(100.0, False), moved(0.0, True), moved(0.0, True, saved=True))
        print(moved(0.0, False))
    """)
    kept = lines[0].split()
    assert kept[0] == kept[1] == kept[2] != lines[1]


def test_instances_in_threads_do_not_disturb_each_other():
    lines = run("""
        from concurrent.futures import ThreadPoolExecutor
        def work(number):
            host = Host(F, f"i{number}").initialize(force=100.0 * number, mass=50.0 + number)
            for _ in range(50):
                assert host.step() is None
            found = host.get("position"), host.get("steps")
            host.close()
            return found
        alone = [work(n) for n in range(6)]
        with ThreadPoolExecutor(6) as pool:
            together = list(pool.map(work, range(6)))
        print(alone == together, len(set(alone)))
    """)
    assert lines == ["True 6"]


def test_an_instance_may_change_threads():
    lines = run("""
        import threading
        host = Host(F).initialize(force=100.0)
        def work():
            host.step()
        for _ in range(5):
            thread = threading.Thread(target=work); thread.start(); thread.join()
        print(host.get("steps"))
        host.close()
    """)
    assert lines == ["5"]


def test_log_categories():
    """Those declared can be chosen, switched off, and on again."""
    lines = run("""
        import fmpy
        host = Host(F)
        names = [c.name for c in host.about.logCategories] if hasattr(
            host.about, "logCategories") else []
        host.fmu.setDebugLogging(False, [])
        host.initialize()
        quiet = len(host.log)
        host.fmu.setDebugLogging(True, names)
        host.set(error="talk")
        assert names and host.step() is None
        print(quiet, len(host.texts(1)))
        host.close()
    """)
    assert lines == ["0 1"]


def test_no_file_is_written_outside_the_cache(tmp_path):
    """Nor into the folder the FMU was extracted to; home and working folder stay empty."""
    home, cache = tmp_path / "home", tmp_path / "cache"
    home.mkdir()
    environment = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "RAIL_COSIM_CACHE": str(cache)}
    lines = run(
        """
        os.chdir(os.environ["HOME"])
        host = Host(F)
        def files():
            return sorted(os.path.join(p, n) for p, _, ns in os.walk(host.folder) for n in ns
                          if not n.endswith(".pyc"))
        before = files()
        host.initialize().step(3)
        print(files() == before, os.listdir("."))
        host.close()
        """,
        **environment,
        PYTHONDONTWRITEBYTECODE="1",
    )
    assert lines == ["True []"]
    assert any(cache.rglob("mass_spring"))


BUNDLED_PACKAGE = """
def twice(x):
    return 2.0 * x
"""
BUNDLED_ENTRY = """
from rail_fmi import RailSlave, Variable
from keeps_code import twice

class Keeping(RailSlave):
    MODEL_NAME = "Keeping"

    def declare(self):
        return [Variable("u", causality="input"), Variable("y", causality="output")]

    def step(self, time, step_size):
        self.reals[1] = twice(self.reals[0])
"""
LOCKED = """
    import pathlib, shutil, tempfile
    import fmpy
    extract = fmpy.extract
    def files(folder):
        return [pathlib.Path(folder), *pathlib.Path(folder).rglob("*")]
    def locked(path, folder):
        extract(path, folder)
        for item in files(folder):
            item.chmod(0o555 if item.is_dir() else 0o444)
        tempfile.tempdir = sys.argv[3]
    fmpy.extract = locked
    tempfile.tempdir = sys.argv[2]
    host = Host(F)
    try:
        open(os.path.join(host.folder, "resources", "new"), "w")
    except PermissionError:
        print("locked", " " in host.folder)
    host.initialize(u=3.0)
    print(host.step(), host.get("y"))
    for item in files(host.folder):
        item.chmod(0o755)
    host.close()
"""


@pytest.fixture(scope="module")
def keeping_fmu(tmp_path_factory):
    """Build an FMU with a package of its own."""
    folder = tmp_path_factory.mktemp("keeping")
    (folder / "keeps_code").mkdir()
    (folder / "keeps_code" / "__init__.py").write_text(BUNDLED_PACKAGE)
    script = folder / "keeping_fmu.py"
    script.write_text(BUNDLED_ENTRY)
    sys.path.insert(0, str(folder))
    try:
        return build_fmu(script, (*PACKAGES[:2], "keeps_code"), folder / "out")
    finally:
        sys.path.remove(str(folder))


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
@pytest.mark.parametrize("writable", ["cache", "nothing"])
def test_folder_with_spaces_and_read_only_resources(keeping_fmu, tmp_path, writable):
    """Also where home and cache are read-only, as for a service: then from the FMU's own folder."""
    place, cache, other = (tmp_path / n for n in ("with spaces", "cache", "temporary"))
    for folder in (place, cache, other):
        folder.mkdir()
    if writable != "cache":
        cache.chmod(0o555)
    home = {"HOME": str(cache), "XDG_CACHE_HOME": str(cache), "RAIL_COSIM_CACHE": str(cache)}
    code = START + textwrap.dedent(LOCKED)
    out = run_host(code, keeping_fmu, place, other, bound=True, **home)
    assert out.splitlines() == ["locked True", "None 6.0"]
    assert bool(list(cache.rglob("keeps_code"))) == (writable == "cache")
    assert not any(other.iterdir())


def test_a_missing_library_is_named_with_its_remedy(tmp_path):
    code = "import fmpy, sys, tempfile; from fmu_host import Host; Host(sys.argv[1])"
    package = tmp_path / "wants_scipy"
    package.mkdir()
    (package / "__init__.py").write_text("import scipy\n")
    script = tmp_path / "wanting_fmu.py"
    script.write_text(
        "from rail_fmi import RailSlave, Variable\nimport wants_scipy\n\n\n"
        "class Wanting(RailSlave):\n    MODEL_NAME = 'Wanting'\n\n    def declare(self):\n"
        "        return [Variable('y', causality='output')]\n"
    )
    sys.path.insert(0, str(tmp_path))
    try:
        fmu = build_fmu(script, (*PACKAGES[:2], "wants_scipy"), tmp_path / "out")
    finally:
        sys.path.remove(str(tmp_path))
    library = tmp_path / "blocked" / "scipy"
    library.mkdir(parents=True)
    (library / "__init__.py").write_text('raise ModuleNotFoundError("No module named scipy")\n')
    done = run_process(code, fmu, paths=(library.parent,))
    assert done.returncode != 0
    assert "the FMU needs a Python library that cannot be imported" in done.stderr
    assert "No module named scipy" in done.stderr
    assert "-m pip install -r" in done.stderr


def test_deploy_finds_the_requirements(tmp_path):
    """Here they are all installed, so nothing is fetched."""
    command = [sys.executable, "-m", "pythonfmu", "deploy", "-f", str(mass_spring_fmu())]
    done = subprocess.run(
        command, capture_output=True, text=True, env=os.environ | {"PIP_NO_INDEX": "1"}
    )
    assert done.returncode == 0, done.stderr
    for library in ("numpy", "scipy"):
        assert f"Requirement already satisfied: {library}" in done.stdout


@pytest.mark.parametrize("name", ["vehicle", "track"])
def test_step_sizes_may_change_from_tiny_to_large(fmus, name):
    """From 1 us to 10 ms: all is finite, and way is speed times time."""
    rows, way = fmus.call(uneven_steps, getattr(fmus, name))
    assert np.isfinite(rows).all()
    assert np.ptp(rows[:, 0]) > 0.0
    if name == "vehicle":
        assert way == pytest.approx(300.0 / 3.6 * sum(STEP_SIZES), rel=1e-9)
