"""What the tests do with the built FMUs, to be called in a process of its own.

Each function takes and returns plain values (see :meth:`product.Product.call`).
"""

import contextlib
import io
import runpy
import sys
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmu_host import Host

SPEED = 300.0 / 3.6
SPACING = 0.629  # fasteners, m
PITCH = 8 * SPACING  # slabs, m
STEPS_PER_BAY = 75
STEP = SPACING / SPEED / STEPS_PER_BAY  # s: bays and slabs are whole numbers of steps
OFFSETS = np.array([0.0, 2.5, 17.8, 20.3])  # m, of the wheelsets behind the leading one
WHEEL_RADIUS = 0.46
LOAD = 69.21e3  # N, static, of one wheel


def simulate(path: Path, interval: float, count: int, **options: Any) -> np.ndarray:
    """Run one FMU in ``fmpy.simulate_fmu`` for ``count`` steps; return what it recorded.

    The number of rows is checked, since the interval may not divide the time.
    """
    with contextlib.redirect_stdout(io.StringIO()):  # it names every input that is not given
        result = fmpy.simulate_fmu(
            str(path), stop_time=count * interval, output_interval=interval, **options
        )
    assert len(result) == count + 1, f"{len(result) - 1} of {count} steps were made"
    return result


def rolling_inputs(count: int, *, velocities: bool = True) -> np.ndarray:
    """Return inputs of the track for wheelsets rolling on at constant height: structured array."""
    time = np.arange(count + 2) * STEP
    columns = {"time": time}
    for number, offset in enumerate(OFFSETS, start=1):
        columns[f"wheelset[{number}].longitudinal_position"] = SPEED * time - offset
        if velocities:
            columns[f"wheelset[{number}].longitudinal_velocity"] = np.full_like(time, SPEED)
            spin = np.full_like(time, -SPEED / WHEEL_RADIUS)
            columns[f"wheelset[{number}].pitch_rate"] = spin
    table = np.zeros(time.size, dtype=[(name, float) for name in columns])
    for name, column in columns.items():
        table[name] = column
    return table


class Driver:
    """An FMU stepped with inputs that are functions of time.

    The track gets wheelsets that roll on and bounce, the vehicle contact forces
    that vary, both of a ``phase``, so that no two steps and no two instances are alike.
    """

    def __init__(self, path: Path, name: str = "one", *, phase: float = 0.0) -> None:
        self.host, self.phase = Host(str(path), name), phase
        self.inputs = [v for v in self.host.about.modelVariables if v.causality == "input"]
        self.outputs = [
            v.valueReference
            for v in self.host.about.modelVariables
            if v.causality == "output" and v.type == "Real"
        ]
        wave = np.array([sum(v.name.encode()) for v in self.inputs])  # a phase for each name
        self._place = 0.7 * wave
        kinds = [self._kind(v.name) for v in self.inputs]
        self._mean, self._rate, self._swing = map(np.array, zip(*kinds, strict=True))

    def _kind(self, name: str) -> tuple[float, float, float]:
        """Return mean, rate and amplitude of an input."""
        last = name.rpartition(".")[2]
        if last == "longitudinal_position":
            return -OFFSETS[int(name[9]) - 1], SPEED, 0.0
        if name.startswith("rail_head"):
            return 0.0, 0.0, 0.0
        if ".contact." in name:
            vertical = last == "vertical_force"
            return (-2.0 * LOAD if vertical else 0.0), 0.0, 4e3 if vertical else 50.0
        return {
            "longitudinal_velocity": (SPEED, 0.0, 0.0),
            "speed_setpoint": (SPEED, 0.0, 0.0),
            "pitch_rate": (-SPEED / WHEEL_RADIUS, 0.0, 0.0),
            "vertical_displacement": (0.0, 0.0, 2e-5),
        }.get(last, (0.0, 0.0, 0.0))

    def _values(self, step: int) -> list[float]:
        t = step * STEP
        swing = self._swing * np.sin(260.0 * t + self._place + self.phase)
        return (self._mean + self._rate * t + swing).tolist()

    def _set(self, step: int) -> None:
        references = [v.valueReference for v in self.inputs]
        self.host.fmu.setReal(references, self._values(step))

    def begin(self, **parameters: Any) -> "Driver":
        """Initialise with the inputs of step 0."""
        fmu = self.host.fmu
        self.host.set(**parameters)
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        self._set(0)
        fmu.exitInitializationMode()
        return self

    def run(self, first: int, count: int) -> np.ndarray:
        """Make steps number ``first`` and on; return all real outputs, (count, outputs)."""
        rows = np.empty((count, len(self.outputs)))
        for row in range(count):
            step = first + row
            self._set(step)
            self.host.time = step * STEP
            assert self.host.step(size=STEP) is None, self.host.texts()
            rows[row] = self.host.fmu.getReal(self.outputs)
        return rows


def run_alone(path: Path, phase: float, count: int, **parameters: Any) -> np.ndarray:
    """Return the outputs of one instance in a process of its own."""
    driver = Driver(path, phase=phase).begin(**parameters)
    rows = driver.run(0, count)
    driver.host.close()
    return rows


def run_three(
    paths: tuple[Path, ...], phases: tuple[float, ...], count: int, parameters: list[dict]
) -> list[list[np.ndarray]]:
    """Load three instances of each FMU, step them in turn, free them; and all that once more.

    Returns the outputs for each time and instance, all instances of the first FMU first.
    """
    rounds = []
    for turn in range(2):
        drivers = [
            Driver(path, f"{path.stem} {turn} {phase}", phase=phase).begin(**values)
            for path, values in zip(paths, parameters, strict=True)
            for phase in phases
        ]
        rows = [[driver.run(step, 1)[0] for driver in drivers] for step in range(count)]
        for driver in drivers:
            driver.host.close()
        rounds.append([np.array(column) for column in zip(*rows, strict=True)])
    return rounds


def save_and_run_twice(path: Path, before: int, count: int, **parameters: Any) -> dict[str, Any]:
    """Save the state after ``before`` steps, and run ``count`` steps from it, twice."""
    driver = Driver(path).begin(**parameters)
    driver.run(0, before)
    fmu = driver.host.fmu
    state = fmu.getFMUstate()
    data = fmu.serializeFMUstate(state)
    slides = [_slides(driver.host)]
    first = driver.run(before, count)
    slides.append(_slides(driver.host))
    fmu.setFMUstate(state)
    slides.append(_slides(driver.host))
    second = driver.run(before, count)
    fmu.freeFMUstate(state)
    driver.host.close()
    return {"data": data, "first": first, "second": second, "slides": slides}


def run_restored(
    path: Path, data: bytes, before: int, count: int, *, used: bool, **parameters: Any
) -> np.ndarray:
    """Restore a saved state in this process and run on from it.

    ``used``: in an instance that was initialised with ``parameters`` and stepped before.
    """
    driver = Driver(path, phase=1.0)
    if used:
        driver.begin(**parameters).run(0, 3)
    fmu = driver.host.fmu
    fmu.setFMUstate(fmu.deSerializeFMUstate(data))
    driver.phase = 0.0
    rows = driver.run(before, count)
    driver.host.close()
    return rows


def command_lines(cases: list[list[str]]) -> list[tuple[int, str]]:
    """Give each list of arguments to ``rail-cosim``; return exit statuses and what was said."""
    from rail_cosim.cli import main

    answers = []
    for arguments in cases:
        sys.argv = ["rail-cosim", *arguments]
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            try:
                main()
                status = 0
            except SystemExit as end:
                status = end.code
        answers.append((status, said.getvalue()))
    return answers


def _slides(host: Host) -> int:
    return host.get("window.slide_count") if "window.slide_count" in host.vars else 0


def refused_simulation(path: Path, **start_values: Any) -> tuple[str, str]:
    """Simulate in fmpy; return the text of the exception, and what is on stderr."""
    error, stderr = "", io.StringIO()
    with contextlib.redirect_stderr(stderr):
        try:
            fmpy.simulate_fmu(str(path), start_values=start_values, stop_time=0.01)
        except FMICallException as caught:
            error = str(caught)
    return error, stderr.getvalue()


def example_loads(script: Path, track: Path) -> dict[str, tuple[complex, complex]]:
    """Run the loads of an example script; return computed value and closed form of each."""
    found = runpy.run_path(str(script))
    with contextlib.redirect_stdout(io.StringIO()):
        return {name: found[name](track) for name in ("moving_load", "harmonic_load")}


STEP_SIZES = (1e-4, 1e-6, 1e-6, 1e-2, 3e-5, 1e-3, 1e-6, 5e-3, 1e-4)


def uneven_steps(path: Path) -> tuple[np.ndarray, float]:
    """Step one FMU with steps of these sizes; return its real outputs and the way of wheelset 1.

    The track's wheelsets roll on at constant height, the vehicle's forces are those at rest.
    """
    host = Host(str(path))
    names = {v.name: v for v in host.about.modelVariables}
    is_track = names["wheelset[1].longitudinal_position"].causality == "input"
    outputs = [
        v.valueReference for v in names.values() if v.causality == "output" and v.type == "Real"
    ]

    def roll(time: float) -> None:
        for number, offset in enumerate(OFFSETS, start=1):
            terminal = f"wheelset[{number}]."
            motion = {
                "longitudinal_position": SPEED * time - offset,
                "longitudinal_velocity": SPEED,
                "pitch_rate": -SPEED / WHEEL_RADIUS,
            }
            for name, value in motion.items():
                host.fmu.setReal([names[terminal + name].valueReference], [value])

    host.fmu.setupExperiment(startTime=0.0)
    host.fmu.enterInitializationMode()
    if is_track:
        roll(0.0)
    host.fmu.exitInitializationMode()
    rows = []
    for size in STEP_SIZES:
        if is_track:
            roll(host.time)
        assert host.step(size=size) is None, host.texts()
        rows.append(host.fmu.getReal(outputs))
    way = host.get("wheelset[1].longitudinal_position")
    host.close()
    return np.array(rows), way


def run_on_rigid_track(script: Path, vehicle: Path, duration: float) -> tuple:
    """Run the vehicle by an example script; return times and heights."""
    return runpy.run_path(str(script))["run"](vehicle, duration)
