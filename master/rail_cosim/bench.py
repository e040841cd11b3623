"""How fast the pair is, and where the time goes (``rail-cosim bench``).

CPU time of this process, so that other work on the machine counts little; medians of
five slab lengths. Times inside the FMUs are those of ``fmi2DoStep``.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import statistics
import subprocess
import sys
import time as clock
from collections.abc import Callable, Mapping
from pathlib import Path

from rail_cosim.algorithms import make_algorithm
from rail_cosim.errors import ParameterError
from rail_cosim.fmu import FmuSlave
from rail_cosim.initialisation import initialise
from rail_cosim.options import RunOptions
from rail_cosim.pace import running_speed, step_count
from rail_cosim.recorder import Recorder
from rail_cosim.runner import find_fmus, gather_parameters
from rail_cosim.simulation import Simulation
from rail_cosim.slave import Value
from rail_cosim.system import SystemStructure
from rail_cosim.threads import one_thread

REPETITIONS = 5
_WARM_UP = 200
_ALGORITHM = "gauss-seidel"
_COST = "slab_track.cost"
_SHARE = "slide_share"  # there of the track's time, here of the pair's


@dataclasses.dataclass(frozen=True, kw_only=True)
class Benchmark:
    """CPU times of a pair; seconds but for the microseconds per macro step.

    Attributes
    ----------
    slab_length
        Distance that ``seconds_per_slab_length`` are for, m.
    seconds_per_slab_length
        Median of five, recording included.
    real_time_factor
        Simulated seconds over CPU seconds: above 1 is faster than real time.
    microseconds_per_step
        Of a macro step: total; do_step of track and vehicle; the other FMI calls (set and get)
        of both; recording (copying into the record); the rest, which is the master's. The
        calls are timed one by one from Python, the total is that of steps in compiled code:
        so the parts may add up to a little more.
    track_microseconds_per_step
        Of the track's step, from its own package: rails, slabs, contact geometry, FASTSIM,
        forces (wheels and rails solved together), slide, Python around them; and of one slide,
        ``slide_each``. None for another track.
    slide_share
        Part of the slide in the computing time of the pair (1); None for another track.
    load, setup
        Loading of both FMUs, and initialisation up to the first step: compiling or loading
        the compiled code, operators, static equilibrium.
    reference_seconds_per_slab_length, ratio
        The article's method in numpy, and how many times as long it takes; None without it.
    """

    speed_km_h: float
    macro_step: float
    slab_length: float
    seconds_per_slab_length: float
    real_time_factor: float
    microseconds_per_step: dict[str, float]
    track_microseconds_per_step: dict[str, float] | None
    slide_share: float | None
    load: float
    setup: float
    reference_seconds_per_slab_length: float | None
    ratio: float | None

    def to_json(self) -> str:
        """Return all figures as JSON."""
        return json.dumps(dataclasses.asdict(self), indent=2)


def benchmark(
    options: RunOptions, *, reference: Path | None = None, slab_length: float = 5.032
) -> Benchmark:
    """Measure the pair that ``options`` describe.

    Parameters
    ----------
    reference
        Script that prints its ``seconds_per_slab_length`` as JSON; run in the same minute.
    slab_length
        Distance per repetition, m.

    Raises
    ------
    RailCosimError
        What :func:`rail_cosim.run` raises, and for a reference that cannot be run.
    """
    if reference is not None and not reference.is_file():
        raise ParameterError("--reference", str(reference), "is no file")
    begin = clock.process_time()
    descriptions, presets = find_fmus(options)
    parameters = gather_parameters(options, descriptions, presets)
    algorithm = make_algorithm(_ALGORITHM)
    with contextlib.ExitStack() as stack:
        stack.enter_context(one_thread())
        slaves = [
            stack.enter_context(FmuSlave(descriptions[name].path, name, description=description))
            for name, description in descriptions.items()
        ]
        loaded = clock.process_time()
        system = SystemStructure(slaves)
        initialise(
            system,
            parameters=parameters,
            input_times=algorithm.input_times([slave.name for slave in slaves]),
            stop_time=3600.0,
        )
        ready = clock.process_time()
        speed, step = running_speed(system), options.macro_step
        simulation = Simulation(
            system, algorithm, Recorder(system.ports, every=options.record_every), step_size=step
        )
        steps, done = step_count(slab_length, speed, step), _WARM_UP
        _must(simulation.run(done))
        seconds = []
        for _ in range(REPETITIONS):
            done += steps
            outcome = simulation.run(done)
            _must(outcome)
            seconds.append(outcome.cpu)
        parts = _parts(system, done * step, step, steps)
    median = statistics.median(seconds)
    parts["total"] = 1e6 * median / steps
    parts["master"] = max(0.0, 2.0 * parts["total"] - sum(parts.values()))
    within = None if options.track else _within_track(parameters["track"], 3.6 * speed, step)
    other = None if reference is None else _reference(reference)
    return Benchmark(
        speed_km_h=3.6 * speed,
        macro_step=step,
        slab_length=slab_length,
        seconds_per_slab_length=median,
        real_time_factor=steps * step / median,
        microseconds_per_step={name: round(value, 2) for name, value in parts.items()},
        track_microseconds_per_step=within,
        slide_share=None if within is None else within["slide"] / parts["total"],
        load=loaded - begin,
        setup=ready - loaded,
        reference_seconds_per_slab_length=other,
        ratio=None if other is None else other / median,
    )


def _must(outcome) -> None:
    if outcome.error is not None:
        raise outcome.error


def _parts(system: SystemStructure, time: float, step: float, count: int) -> dict[str, float]:
    """Microseconds per macro step of the calls, median of ``count`` steps each."""
    times: dict[str, list[float]] = {}
    recorder = Recorder(system.ports)

    def timed(name: str, work: Callable[..., object], *arguments: float) -> None:
        begin = clock.perf_counter()
        work(*arguments)
        times.setdefault(name, []).append(clock.perf_counter() - begin)

    for _ in range(count):
        for port in system.ports:
            name = port.slave.name
            timed(f"{name}_set_get", port.set_inputs)
            timed(name, port.slave.do_step, time, step)
            timed(f"{name}_set_get", port.read_all)
        time += step
        timed("recording", recorder.record, time)
    # Two calls under one name: their median times two.
    return {
        name: 1e6 * statistics.median(values) * len(values) / count
        for name, values in times.items()
    }


def _within_track(
    parameters: Mapping[str, Value], speed: float, step: float
) -> dict[str, float] | None:
    """Return what the parts of the track's step cost, measured by its package in its own process.

    Parameters that only the FMU has, such as ``coupling.input_time``, are left out.
    """
    command = [sys.executable, "-m", _COST, "--json", "--speed", repr(speed), "--step", repr(step)]
    for name, value in parameters.items():
        if not name.startswith("coupling."):
            command += ["--track", f"{name}={value}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return None
    return {name: value for name, value in json.loads(done.stdout).items() if name != _SHARE}


def _reference(script: Path) -> float:
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, check=False
    )
    try:
        return float(json.loads(done.stdout)["seconds_per_slab_length"])
    except (ValueError, KeyError) as error:
        message = f"gave no seconds_per_slab_length: {done.stderr.strip()[-300:]}"
        raise ParameterError("--reference", str(script), message) from error
