"""Runs of the pair in tools that others wrote, each to be called in a process of its own."""

import contextlib
import ctypes
import importlib.util
import os
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
from product import PATIENCE

STEP = 1e-4
STEPS = 3120  # 26 m at 300 km/h

WHEELS = [(i, side) for i in (1, 2, 3, 4) for side in ("left", "right")]
OUTPUTS = {
    "track": [
        *(f"wheelset[{i}].{side}.normal_force" for i, side in WHEELS),
        *(f"wheelset[{i}].{side}.rail_vertical_displacement" for i, side in WHEELS),
    ],
    "vehicle": [
        *(f"axle_box[{i}].{side}.vertical_acceleration" for i, side in WHEELS),
        *(f"wheelset[{i}].vertical_displacement" for i in (1, 2, 3, 4)),
    ],
}
SLIDES = "window.slide_count"


def missing(tool: str) -> str:
    """Return why a tool cannot be used here, empty if it can."""
    if importlib.util.find_spec(tool) is None:
        return f"{tool} is not installed: pip install '.[tools]'"
    if tool == "ecospy":
        try:
            load_tbb()
        except OSError as error:
            return f"ecos needs libtbb.so.12: pip install tbb, or Debian's libtbb12 ({error})"
    return ""


def load_tbb() -> None:
    """Load the library that ecos is linked with: Debian's, or that of the wheel ``tbb``."""
    if sys.platform != "linux":
        return
    for place in ("libtbb.so.12", str(tbb_folder() / "libtbb.so.12")):
        try:
            ctypes.CDLL(place, mode=ctypes.RTLD_GLOBAL)
            return
        except OSError as error:
            reason = error
    raise reason


def tbb_folder() -> Path:
    return Path(sysconfig.get_path("data"), "lib")


def shared_python() -> Path | None:
    """Return the shared library of this Python, if it has one."""
    folder, name = (sysconfig.get_config_var(v) for v in ("LIBDIR", "INSTSONAME"))
    path = Path(folder or "", name or "")
    return path if ".so" in path.name and path.is_file() else None


def relative_difference(values: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest difference, the start included, by the largest value."""
    rows = len(values)
    assert STEPS <= rows <= STEPS + 1, rows
    return float(np.abs(values - expected[:rows]).max() / np.abs(expected).max())


def start_values(ssp: Path) -> dict[str, dict[str, str]]:
    """Return the values of the sets ``start`` in a package, as text by component and name."""
    pattern = re.compile(r'name="([^"]+)">\s*<ssv:Real value="([^"]+)"')
    with zipfile.ZipFile(ssp) as archive:
        return {
            name: dict(pattern.findall(archive.read(f"resources/{name}-start.ssv").decode()))
            for name in OUTPUTS
        }


def run_ecospy(ssp: Path) -> dict[str, np.ndarray]:
    """Run the package in ecos, driven from Python; return all outputs looked at."""
    load_tbb()
    from ecospy import EcosSimulation

    found = {name: np.empty(STEPS + 1) for names in OUTPUTS.values() for name in names}
    with EcosSimulation(STEP, ssp_path=str(ssp)) as simulation:
        assert simulation.init(parameter_set="start")
        for row in range(STEPS + 1):
            if row:
                simulation.step()
            for component, names in OUTPUTS.items():
                for name in names:
                    found[name][row] = simulation.get_real(f"{component}::{name}")
        found[SLIDES] = np.array([simulation.get_integer(f"track::{SLIDES}")])
        simulation.terminate()
    return found


def run_ecos_command(ssp: Path, folder: Path) -> dict[str, np.ndarray]:
    """Run the package in the command ``ecos``, a compiled host; return its CSV."""
    # Found without being imported: an import would load ecos and with it libtbb into this process.
    package = Path(importlib.util.find_spec("ecospy").origin).parent
    program = folder / "ecos"
    # The wheel's copy is not marked as executable.
    program.write_bytes((package / "binaries" / "ecos").read_bytes())
    program.chmod(0o755)
    environment = os.environ | {
        "LD_PRELOAD": str(shared_python()),
        "LD_LIBRARY_PATH": str(tbb_folder()),
        "PYTHONHOME": sys.base_prefix,
        "PYTHONPATH": sysconfig.get_path("purelib"),
    }
    options = ["--stepSize", STEP, "--stopTime", STEPS * STEP, "--parameterSet", "start"]
    done = subprocess.run(
        [program, "simulate", "--path", str(ssp), *map(str, options)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, f"exit status {done.returncode}\n{done.stdout}\n{done.stderr}"
    return read_ecos_csv(folder / f"{ssp.stem}.csv")


def read_ecos_csv(path: Path) -> dict[str, np.ndarray]:
    """Return the columns looked at; a head is ``component::name[TYPE]``."""
    with path.open() as file:
        heads = [re.sub(r"\[[A-Z]+\]$", "", head.strip()) for head in file.readline().split(",")]
    wanted = [f"{c}::{name}" for c, names in OUTPUTS.items() for name in names]
    columns = [heads.index(name) for name in [*wanted, f"track::{SLIDES}"]]
    table = np.loadtxt(path, delimiter=",", skiprows=1, usecols=columns, unpack=True)
    names = [name.partition("::")[2] for name in wanted]
    return dict(zip([*names, SLIDES], table, strict=True))


def run_libcosim(folder: Path) -> dict[str, np.ndarray]:
    """Run the folder's ``OspSystemStructure.xml`` in libcosim.

    Its observers see the values after each step: row 0 are those of the start.
    """
    import fmpy
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    models = {"track": "InfiniteSlabTrack", "vehicle": "HighSpeedVehicle"}
    execution = CosimExecution.from_osp_config_file(str(folder))
    series, last = CosimObserver.create_time_series(STEPS + 10), CosimObserver.create_last_value()
    assert execution.add_observer(series)
    assert execution.add_observer(last)
    places, slides = {}, None
    for component, names in OUTPUTS.items():
        slave = execution.slave_index_from_instance_name(component)
        about = fmpy.read_model_description(str(folder / f"{models[component]}.fmu"))
        numbers = {v.name: v.valueReference for v in about.modelVariables}
        if SLIDES in numbers:
            slides = slave, [numbers[SLIDES]]
        for name in names:
            places[name] = slave, numbers[name]
            assert series.start_time_series(*places[name], CosimVariableType.REAL)
    assert execution.step(STEPS)
    found = {}
    for name, (slave, number) in places.items():
        _, steps, samples = series.time_series_real_samples(slave, number, 0, STEPS + 10)
        found[name] = np.array(samples)[: len(steps)]
    found[SLIDES] = np.array(last.last_integer_values(*slides))
    return found


def make_container(folder: Path, ssp: Path, fmus: tuple[Path, ...]) -> Path:
    """Make one FMU of the vehicle and the track with fmucontainer, linked by equal names."""
    for path in fmus:
        (folder / path.name).write_bytes(path.read_bytes())
    rows = ["rule;from_fmu;from_port;to_fmu;to_port"]
    rows += [f"FMU;{path.name};;;" for path in fmus]  # the vehicle first: it starts first
    models = {"track": "InfiniteSlabTrack.fmu", "vehicle": "HighSpeedVehicle.fmu"}
    for component, values in start_values(ssp).items():
        rows += [f"START;{models[component]};{name};{v};" for name, v in values.items()]
    (folder / "Pair.csv").write_text("\n".join(rows) + "\n")
    done = subprocess.run(
        [
            *(sys.executable, "-m", "fmu_manipulation_toolbox.cli.fmucontainer"),
            *("-container", f"Pair.csv:{STEP}", "-no-auto-input"),
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, f"exit status {done.returncode}\n{done.stdout}\n{done.stderr}"
    return folder / "Pair.fmu"


def run_one_fmu(path: Path) -> dict[str, np.ndarray]:
    """Run a container in ``fmpy.simulate_fmu``; outputs linked inside are not seen outside."""
    import fmpy

    shown = {v.name for v in fmpy.read_model_description(str(path)).modelVariables}
    names = [name for group in OUTPUTS.values() for name in group if name in shown]
    assert len(names) >= 24, names  # all but the wheelsets' heights
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=STEPS * STEP,
        output_interval=STEP,
        step_size=STEP,
        output=[*names, SLIDES],
    )
    return {name: found[name] for name in [*names, SLIDES]}


def run_fmpy_ssp(ssp: Path) -> dict[str, np.ndarray]:
    """Run the package in fmpy's ``simulate_ssp``, whose rows begin after the first step."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import read_ssv

    start = read_ssv(str(ssp), resource="resources/system-start.ssv")
    end = (STEPS - 0.5) * STEP  # it steps until a sum of steps is there
    rows = simulate_ssp(str(ssp), stop_time=end, step_size=STEP, parameter_set=start)
    return {name: rows[f"{c}.{name}"] for c, names in OUTPUTS.items() for name in names}


def refusal_of_fmpy_ssp(ssp: Path) -> str:
    """Run the package in ``simulate_ssp`` without a set; return what the track said."""
    from fmpy.fmi1 import FMICallException
    from fmpy.ssp import simulation

    make_step, said = simulation.do_step, []

    def step(component, time, step_size):
        try:
            make_step(component, time, step_size)
        except FMICallException:
            number = component.variables["status.message"].valueReference
            said.append(component.fmu.getString([number])[0].decode())
            raise

    simulation.do_step = step
    with contextlib.suppress(FMICallException):
        simulation.simulate_ssp(str(ssp), stop_time=10 * STEP, step_size=STEP)
    return said[0] if said else ""
