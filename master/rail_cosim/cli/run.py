"""``rail-cosim run``: one co-simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rail_cosim.cli.application import (
    GroupedCommand,
    Quiet,
    app,
    examples,
    given,
    plain_errors,
    progress,
    remark,
    say,
    show,
    typed_command,
)
from rail_cosim.errors import RunError, RunInterrupted

if TYPE_CHECKING:
    from rail_cosim.options import RunOptions


def _algorithms(typed: str) -> list[str]:
    from rail_cosim.algorithms import ALGORITHMS

    return [name for name in ALGORITHMS if name.startswith(typed)]


@app.command(
    cls=GroupedCommand,
    epilog=examples(
        "rail-cosim run --speed 300 --distance 200 --irregularity german_low --plot run.png",
        "rail-cosim run --set track.fastener.vertical_stiffness=140e6 --speed 170",
        "rail-cosim run --irregularity german_low --set track.irregularity.seed=2",
        "rail-cosim run --irregularity rail_joint --set track.irregularity.rail_joint.position=40",
        "rail-cosim run --irregularity measured.csv --out run.nc",
        "rail-cosim run --speed 170 --out winter.nc --write-case winter.toml",
        "rail-cosim run winter.toml --distance 200",
        "rail-cosim run --irregularity rail_joint --distance 20 --animate joint.mp4",
    ),
)
def run(
    context: typer.Context,
    system: Annotated[
        Path | None,
        typer.Argument(
            help="A run file, or an SSP package with a vehicle and a track; none: the options "
            "say what to run.",
            metavar="[CASE.toml|SYSTEM.ssp]",
            show_default=False,
        ),
    ] = None,
    line: Annotated[
        str | None,
        typer.Option(
            help="Line: HD, ZX, paper. A parameter set of the track FMU.",
            metavar="NAME",
            rich_help_panel="System",
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Parameter set of the vehicle, or another vehicle FMU.",
            metavar="NAME|FMU",
            rich_help_panel="System",
        ),
    ] = None,
    track: Annotated[
        Path | None,
        typer.Option(help="Another track FMU.", metavar="FMU", rich_help_panel="System"),
    ] = None,
    vehicle_map: Annotated[
        Path | None,
        typer.Option(
            help="Names of that vehicle FMU, where they are not those of the contract.",
            metavar="FILE.toml",
            rich_help_panel="System",
        ),
    ] = None,
    track_map: Annotated[
        Path | None,
        typer.Option(
            help="The same for the track FMU.", metavar="FILE.toml", rich_help_panel="System"
        ),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Running speed.", metavar="KM/H", rich_help_panel="Motion")
    ] = None,
    distance: Annotated[
        float,
        typer.Option(
            help="Distance travelled by the leading wheelset.",
            metavar="M",
            rich_help_panel="Motion",
        ),
    ] = 100.0,
    until_steady: Annotated[
        float | None,
        typer.Option(
            help="End when the motion is steady: the largest relative change of wheel forces and "
            "axle-box accelerations from slab to slab, e.g. 0.001; --distance is the limit.",
            metavar="CHANGE",
            rich_help_panel="Motion",
        ),
    ] = None,
    final_speed: Annotated[
        float | None,
        typer.Option(
            help="Speed at the end of the distance: the vehicle accelerates uniformly.",
            metavar="KM/H",
            rich_help_panel="Motion",
        ),
    ] = None,
    irregularity: Annotated[
        str | None,
        typer.Option(
            help="Irregularity of the track: german_low, german_high, chinese_ballastless (random, "
            "see track.irregularity.seed), rail_joint (both rails, at the first mid-span between "
            "fasteners 12 m ahead), or a CSV or NetCDF file by distance.",
            metavar="NAME|FILE",
            rich_help_panel="Irregularity",
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="A parameter: track.NAME=VALUE or vehicle.NAME=VALUE. Repeat for more.",
            metavar="NAME=VALUE",
            rich_help_panel="System",
        ),
    ] = None,
    macro_step: Annotated[
        float, typer.Option(help="Communication step.", metavar="S", rich_help_panel="Numerics")
    ] = 1e-4,
    algorithm: Annotated[
        str,
        typer.Option(
            help="gauss-seidel, jacobi, iterative-gauss-seidel.",
            metavar="NAME",
            autocompletion=_algorithms,
            rich_help_panel="Numerics",
        ),
    ] = "gauss-seidel",
    record_every: Annotated[
        int, typer.Option(help="Record every N-th step.", metavar="N", rich_help_panel="Results")
    ] = 1,
    trust: Annotated[
        bool,
        typer.Option(
            "--trust",
            help="Run FMUs that were not built here without a warning.",
            rich_help_panel="System",
        ),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            help="NetCDF file for the results.", metavar="FILE", rich_help_panel="Results"
        ),
    ] = None,
    variables: Annotated[
        list[str] | None,
        typer.Option(
            help="Variables of the results, with * and ?: normal_force,axle_box_*; none: all. "
            "The summary tells what it needs and is not recorded.",
            metavar="NAME,...",
            rich_help_panel="Results",
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            help="Plot: .png, .pdf or .svg.",
            metavar="FILE",
            rich_help_panel="Plots and animation",
        ),
    ] = None,
    animate: Annotated[
        Path | None,
        typer.Option(
            help="Animation of vehicle, rails, slabs and window: .mp4 or .gif.",
            metavar="FILE",
            rich_help_panel="Plots and animation",
        ),
    ] = None,
    slow_motion: Annotated[
        float,
        typer.Option(
            help="Seconds of the animation per second of the run.",
            metavar="TIMES",
            rich_help_panel="Plots and animation",
        ),
    ] = 50.0,
    exaggeration: Annotated[
        float | None,
        typer.Option(
            help="Of vertical displacements in the animation; none: so that the rails' largest is "
            "well seen.",
            metavar="TIMES",
            rich_help_panel="Plots and animation",
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Resume where the same command with the same --out was stopped.",
            rich_help_panel="Stop and resume",
        ),
    ] = False,
    checkpoint_interval: Annotated[
        float,
        typer.Option(
            help="Time between two checkpoints beside --out, from which --resume starts after "
            "a crash; Ctrl-C makes one too.",
            metavar="S",
            rich_help_panel="Stop and resume",
        ),
    ] = 60.0,
    case: Annotated[
        Path | None,
        typer.Option(
            "--write-case",
            help="Write a run file that says what this command says, and end.",
            metavar="FILE",
            rich_help_panel="Results",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run vehicle and track together and print a summary.

    Parameters come from the parameter sets of --line and --vehicle, or those bound
    in SYSTEM.ssp, then from --speed and --irregularity, then from --set; the last one
    wins. All in SI units but --speed.

    CASE.toml has options by their names below [run] and parameters below [set], as the
    specification of a sweep has; its paths are relative to it. What is on the
    command line wins.

    Ctrl-C ends the run after its step; what was recorded is written and marked
    incomplete, and the same command with --resume resumes there.
    """
    values = given(
        context,
        {
            "system": system,
            "line": line,
            "vehicle": vehicle,
            "track": track,
            "vehicle_map": vehicle_map,
            "track_map": track_map,
            "speed": speed,
            "distance": distance,
            "until_steady": until_steady,
            "final_speed": final_speed,
            "irregularity": irregularity,
            "settings": settings,
            "macro_step": macro_step,
            "algorithm": algorithm,
            "record_every": record_every,
            "trust": trust,
            "out": out,
            "variables": None if variables is None else split(variables),
            "plot": plot,
            "animate": animate,
            "slow_motion": slow_motion,
            "exaggeration": exaggeration,
            "resume": resume,
            "checkpoint_interval": checkpoint_interval,
        },
    )
    with plain_errors():
        options = _options(values)
        if case is not None:
            from rail_cosim.case import write_case

            write_case(case, options)
            say(str(case))
            return
        _run(options)


def split(texts: list[str]) -> list[str]:
    """Return the names in texts separated by commas."""
    return [name.strip() for text in texts for name in text.split(",")]


def _options(values: dict[str, Any]) -> RunOptions:
    """Return the options from a run file, if there is one, and those that were typed."""
    from rail_cosim.case import ENDING, read_case
    from rail_cosim.options import RunOptions
    from rail_cosim.toml_files import assignments

    case: dict[str, Any] = {"settings": {}}
    if "system" in values and values["system"].suffix.lower() == ENDING:
        case = read_case(values.pop("system"))
    settings = [*assignments(case["settings"]), *values.get("settings", [])]
    return RunOptions(**case | values | {"settings": settings, "command": typed_command()})


def _run(options: RunOptions) -> None:
    from rail_cosim.runner import execute

    try:
        with progress() as terminal:
            dataset = execute(options, terminal)
    except RunError as error:
        _summary(error.dataset)
        _kept(options.out, error)
        raise
    _summary(dataset)
    if options.out is None:
        say("the results were not kept: give --out FILE.nc to write them")


def _summary(dataset) -> None:
    from rail_cosim.summary import summarise
    from rail_cosim.tables import summary_table

    if dataset is not None and dataset.sizes["time"] > 1:
        show(summary_table(summarise(dataset), dataset))


def _kept(out: Path | None, error: RunError) -> None:
    from rail_cosim.checkpoint import checkpoint_path

    if out is not None:
        remark(f"what was recorded is in {out}, marked incomplete")
        if isinstance(error, RunInterrupted) and checkpoint_path(out).exists():
            remark("the same command with --resume resumes there")
