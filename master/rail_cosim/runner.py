"""One co-simulation of vehicle and track, from options to Dataset."""

from __future__ import annotations

import contextlib
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from rail_cosim.algorithms import GaussSeidel, make_algorithm
from rail_cosim.attributes import (
    REMARKS,
    changed_attribute,
    ended_by,
    fmu_attributes,
    parameter_attributes,
    run_attributes,
)
from rail_cosim.builder import RECIPES, built_fmu
from rail_cosim.checkpoint import INTERVAL
from rail_cosim.description import FmuDescription
from rail_cosim.errors import RunError, RunInterrupted
from rail_cosim.fmu import FmuSlave
from rail_cosim.initialisation import PASSED, POSITION, SPEED, initialise
from rail_cosim.interrupts import InterruptNote
from rail_cosim.irregularity import SPACING, check_joint, irregularity_parameters
from rail_cosim.name_map import described
from rail_cosim.options import KM_H, MACRO_STEP, RunOptions
from rail_cosim.pace import planned_time, running_speed, step_count
from rail_cosim.parameters import checked, number_of, parse_assignments
from rail_cosim.presets import preset_values
from rail_cosim.ramp import SpeedRamp
from rail_cosim.recorded import check_variables
from rail_cosim.recorder import Recorder
from rail_cosim.reporter import Quiet, Reporter
from rail_cosim.results import check_netcdf, check_writable, variable_names
from rail_cosim.run_result import RunResult
from rail_cosim.session import Session, begun_run
from rail_cosim.simulation import Outcome, Simulation
from rail_cosim.slave import Slave, Value
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.steady import SteadyState, fitted_step, slab_pitch
from rail_cosim.summary import summarise
from rail_cosim.system import SystemStructure
from rail_cosim.threads import one_thread
from rail_cosim.trust import foreign_remark
from rail_cosim.wheelsets import wheelset_parameters

if TYPE_CHECKING:
    from rail_cosim.animation import Film


def run(
    system: str | Path | None = None,
    *,
    line: str | None = None,
    vehicle: str | Path | None = None,
    track: str | Path | None = None,
    vehicle_map: str | Path | None = None,
    track_map: str | Path | None = None,
    speed: float | None = None,
    distance: float = 100.0,
    until_steady: float | None = None,
    final_speed: float | None = None,
    irregularity: str | Path | None = None,
    settings: Mapping[str, Value] | None = None,
    macro_step: float = MACRO_STEP,
    algorithm: str = GaussSeidel.name,
    record_every: int = 1,
    trust: bool = False,
    out: str | Path | None = None,
    variables: Sequence[str] = (),
    plot: str | Path | None = None,
    animate: str | Path | None = None,
    slow_motion: float = 50.0,
    exaggeration: float | None = None,
    resume: bool = False,
    checkpoint_interval: float = INTERVAL,
    reporter: Reporter | None = None,
) -> RunResult:
    """Run vehicle and track and return what was recorded; mirrors ``rail-cosim run``.

    Parameters
    ----------
    system
        An SSP package with a vehicle and a track, instead of ``line``, ``vehicle`` and ``track``.
    line
        Parameter set of the track: ``HD`` (its defaults), ``ZX``, ``paper``.
    vehicle
        Parameter set of the vehicle (``paper``, its defaults, or ``manchester1``), or the path
        of another vehicle FMU.
    track
        Path of another track FMU.
    vehicle_map, track_map
        TOML files that map the names of these FMUs to those of the contract.
    speed
        Running speed in km/h; the vehicle's own unless given.
    distance
        Distance travelled by the leading wheelset in m.
    until_steady
        End the run when it is steady: the largest relative change of wheel forces and axle-box
        accelerations from slab to slab, e.g. 0.001. ``distance`` is then the largest one.
    final_speed
        Speed at the end of the distance in km/h, reached by uniform acceleration.
    irregularity
        A spectrum of the track FMU, ``rail_joint``, or a file by distance.
    settings
        Parameter values by full name: ``{"track.fastener.vertical_stiffness": 40e6}``.
    macro_step
        Communication step in s; with ``until_steady`` at most that.
    algorithm
        ``gauss-seidel``, ``jacobi`` or ``iterative-gauss-seidel``.
    record_every
        Record each step (1), each second (2), ...
    trust
        Run FMUs that were not built here without a warning.
    out
        NetCDF file for the results.
    variables
        Variables of the results, by names with the wildcards ``*`` and ``?``; empty for all.
        Time and ``distance`` are always there.
    plot
        Plot of the run: ``.png``, ``.pdf`` or ``.svg``.
    animate
        Film of the run: ``.mp4`` or ``.gif``.
    slow_motion
        Seconds of the animation per second of the run.
    exaggeration
        Factor on vertical displacements in the animation; a fitting one unless given.
    resume
        Resume where a run with the same arguments and ``out`` was stopped.
    checkpoint_interval
        Seconds of computing between two checkpoints of a run that has ``out``.
    reporter
        Told of stages, progress and warnings.

    Returns
    -------
    RunResult
        A Dataset that can plot itself: outputs of both FMUs over ``time`` (s), by ``wheelset``,
        ``side`` and ``bogie``, with ``units`` and ``long_name``; parameters, versions and coupling
        residuals are attributes.

    Raises
    ------
    RailCosimError
        Before the run, for anything that cannot be run.
    RunError
        When the run ended early: what was recorded is its ``dataset``, and is
        written to ``out`` all the same.
    """
    options = RunOptions(
        system=None if system is None else Path(system),
        line=line,
        vehicle=None if vehicle is None else str(vehicle),
        track=None if track is None else Path(track),
        vehicle_map=None if vehicle_map is None else Path(vehicle_map),
        track_map=None if track_map is None else Path(track_map),
        speed=speed,
        distance=distance,
        until_steady=until_steady,
        final_speed=final_speed,
        irregularity=None if irregularity is None else str(irregularity),
        settings=[f"{name}={value}" for name, value in (settings or {}).items()],
        macro_step=macro_step,
        algorithm=algorithm,
        record_every=record_every,
        trust=trust,
        out=None if out is None else Path(out),
        variables=variables,
        plot=None if plot is None else Path(plot),
        animate=None if animate is None else Path(animate),
        slow_motion=slow_motion,
        exaggeration=exaggeration,
        resume=resume,
        checkpoint_interval=checkpoint_interval,
        command=shlex.join(sys.argv),
    )
    return execute(options, reporter or Quiet())


def execute(options: RunOptions, reporter: Reporter) -> RunResult:
    """Run with checked options (see :func:`run`)."""
    if options.out:
        check_netcdf(options.out)
    if options.plot:
        from rail_cosim.plot import check_format

        check_format(options.plot)
        check_writable(options.plot)
    if options.animate:
        from rail_cosim.animation import check_animation

        check_animation(options.animate)
    make_algorithm(options.algorithm)
    reporter.stage("finding the FMUs")
    if options.system is not None:
        package = read_ssp(options.system)
        for remark in package.remarks:
            reporter.notice(remark)
        descriptions, presets = dict(package.descriptions), dict[str, str]()
        parameters = gather_parameters(options, descriptions, presets, package.parameters)
    else:
        descriptions, presets = find_fmus(options)
        parameters = gather_parameters(options, descriptions, presets)
    if not options.trust:
        for description in descriptions.values():
            if text := foreign_remark(description.path):
                reporter.notice(text)
    check_variables(options.variables, variable_names(descriptions.values()))
    changed = changed_attribute(descriptions, preset_values(descriptions, presets), parameters)
    film = None
    if options.animate:
        from rail_cosim.animation import PROFILES_WANTED, Film, check_track

        check_track(descriptions["track"].variables, descriptions["track"].path.name)
        film = Film(options.slow_motion)
        if PROFILES_WANTED in descriptions["track"].variables:
            parameters["track"][PROFILES_WANTED] = True
    recorded, outcome = simulate(options, descriptions, parameters, reporter, changed, film)
    dataset = RunResult.of(recorded)
    if film is not None and options.animate:
        from rail_cosim.animation import write_animation

        write_animation(film, options.animate, reporter, exaggeration=options.exaggeration)
    if options.plot and dataset.sizes["time"] > 1:
        from rail_cosim.plot import plot_run

        plot_run(dataset, summarise(dataset), options.plot)
    if isinstance(outcome.error, KeyboardInterrupt):
        raise RunInterrupted(ended_by(outcome), dataset) from outcome.error
    if outcome.error is not None:
        raise RunError(str(outcome.error), dataset) from outcome.error
    return dataset


def find_fmus(
    options: RunOptions,
) -> tuple[dict[str, FmuDescription], dict[str, str]]:
    """Return the descriptions of ``track`` and ``vehicle``, and the presets asked for."""
    presets = {"track": options.line} if options.line else {}
    files: dict[str, Path | None] = {"track": options.track, "vehicle": None}
    maps = {"track": options.track_map, "vehicle": options.vehicle_map}
    if options.vehicle and (options.vehicle.endswith(".fmu") or Path(options.vehicle).is_file()):
        files["vehicle"] = Path(options.vehicle)
    elif options.vehicle:
        presets["vehicle"] = options.vehicle
    found = {name: file or built_fmu(RECIPES[name]) for name, file in files.items()}
    return {name: described(file, maps[name]) for name, file in found.items()}, presets


def gather_parameters(
    options: RunOptions,
    descriptions: Mapping[str, FmuDescription],
    presets: Mapping[str, str],
    bound: Mapping[str, Mapping[str, str]] | None = None,
) -> dict[str, dict[str, Value]]:
    """Return all values to set, checked: presets, bound values, then options, then settings.

    ``bound`` are values that came with the FMUs, in an SSP package.

    What the vehicle tells the track (:data:`rail_cosim.initialisation.PASSED`) is not taken
    from the track's preset, nor from what is bound to it. The track's ``wheelset_count`` is that
    of the vehicle.

    Raises
    ------
    ParameterError
        For a name or value that is not right.
    StructureError
        If the vehicle's wheelsets do not fit the track's terminals.
    """
    known = {name: description.variables for name, description in descriptions.items()}
    values: dict[str, dict[str, Value]] = {name: {} for name in known}
    values.update(preset_values(descriptions, presets))
    for name, given in (bound or {}).items():
        values[name].update(checked(name, known[name], given))
    for source, target in PASSED.items():
        if source in known["vehicle"]:
            values["track"].pop(target, None)
    if options.speed is not None:
        speed = {SPEED: options.speed * KM_H}
        values["vehicle"].update(checked("vehicle", known["vehicle"], speed))
    settings = {
        name: checked(name, known[name], given)
        for name, given in parse_assignments(list(options.settings), known).items()
    }
    values["vehicle"].update(settings["vehicle"])
    start = number_of(POSITION, values["vehicle"], known["vehicle"])
    if options.irregularity is not None:
        spacing = number_of(SPACING, values["track"] | settings["track"], known["track"])
        found = irregularity_parameters(
            options.irregularity, known["track"], start=start, spacing=spacing
        )
        values["track"].update(checked("track", known["track"], found))
    values["track"].update(settings["track"])
    check_joint(known["track"], values["track"], start=start, distance=options.distance)
    values["track"].update(wheelset_parameters(known["vehicle"], known["track"], values))
    return values


def simulate(
    options: RunOptions,
    descriptions: Mapping[str, FmuDescription],
    parameters: Mapping[str, Mapping[str, Value]],
    reporter: Reporter,
    attributes: Mapping[str, object] | None = None,
    film: Film | None = None,
) -> tuple[xr.Dataset, Outcome]:
    """Run two FMUs with checked parameters; write the results; return them, and how it ended.

    ``attributes`` are more for the Dataset; ``film`` takes down what an animation is drawn from.

    Raises
    ------
    RailCosimError
        If it cannot start; what happens in a step is in the outcome.
    """
    algorithm = make_algorithm(options.algorithm)
    begun = begun_run(options)
    with contextlib.ExitStack() as stack:
        stack.enter_context(one_thread())
        note = stack.enter_context(InterruptNote())
        reporter.stage("loading the FMUs")
        slaves: list[FmuSlave] = []
        for name in ("track", "vehicle"):  # Gauss-Seidel steps the track first
            description = descriptions[name]
            slaves.append(
                stack.enter_context(FmuSlave(description.path, name, description=description))
            )
            note.check()
        system = SystemStructure(slaves)
        reporter.stage("finding the static equilibrium")
        remarks = initialise(
            system,
            parameters=parameters,
            input_times=algorithm.input_times([slave.name for slave in slaves]),
            stop_time=planned_time(options, parameters, descriptions["vehicle"]),
        )
        remarks += _warnings(slaves)
        for remark in remarks:
            reporter.notice(remark)
        speed = running_speed(system)
        session = Session(options, system, {slave.name: slave for slave in slaves}, begun)
        simulation = Simulation(
            system,
            algorithm,
            session.recorder,
            step_size=(step_size := _step_size(options, system, speed)),
            driver=(ramp := _ramp(options, system, speed)),
            stop=_stop_rule(options, system, session.recorder, speed, step_size),
            observer=film,
        )
        session.go_on(simulation)
        whole = step_count(options.distance, speed, step_size)
        steps = whole if ramp is None else ramp.step_count(step_size)
        if film is not None:
            film.begin(
                system["track"],
                system["vehicle"],
                wheelsets=_wheelsets(system),
                step_size=step_size,
                steps=steps,
            )
        # Read now: after an error the FMUs answer no more.
        fixed = {k: v for slave in slaves for k, v in parameter_attributes(slave).items()}
        reporter.stage("stepping")
        outcome = simulation.run(steps, note=note, progress=reporter.progress, watch=session)
        for remark in (later := _warnings(slaves)):
            reporter.notice(remark)
        about = {
            **run_attributes(outcome, algorithm, options.command),
            "line": options.line or "",
            "speed_km_h": speed / KM_H,
            REMARKS: "\n".join([*remarks, *later]),
            **({} if ramp is None else {"final_speed_km_h": options.final_speed}),
            **{k: v for slave in slaves for k, v in fmu_attributes(slave).items()},
            **fixed,
            **(attributes or {}),
        }
        if options.out:
            reporter.stage(f"writing {options.out}")
        return session.finish(simulation, outcome, about), outcome


def _wheelsets(system: SystemStructure) -> int:
    return sum(c.name.endswith("].vertical_displacement") for c in system.connections)


def _stop_rule(
    options: RunOptions,
    system: SystemStructure,
    recorder: Recorder,
    speed: float,
    step_size: float,
) -> SteadyState | None:
    if options.until_steady is None:
        return None
    return SteadyState(
        system, recorder, tolerance=options.until_steady, speed=speed, step_size=step_size
    )


def _ramp(options: RunOptions, system: SystemStructure, speed: float) -> SpeedRamp | None:
    if options.final_speed is None:
        return None
    return SpeedRamp(
        system["vehicle"],
        start=speed,
        end=options.final_speed * KM_H,
        distance=options.distance,
    )


def _step_size(options: RunOptions, system: SystemStructure, speed: float) -> float:
    """Return the macro step (s), shortened where the run is to end when it is steady."""
    if options.until_steady is None:
        return options.macro_step
    pitch = slab_pitch(system["track"])
    return fitted_step(pitch, speed, options.macro_step, options.record_every)


def _warnings(slaves: Sequence[Slave]) -> list[str]:
    """Return what the FMUs have warned of since they were asked last."""
    return [f"{slave.name}: {text}" for slave in slaves for text in slave.take_warnings()]
