"""``rail-cosim run``: one co-simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import app, plain_errors, progress, remark, show, typed_command
from rail_cosim.errors import RunError


@app.command()
def run(
    system: Annotated[
        Path | None,
        typer.Argument(
            help="An SSP package with a vehicle and a track; none: the options say which.",
            metavar="[SYSTEM.ssp]",
            show_default=False,
        ),
    ] = None,
    line: Annotated[
        str | None,
        typer.Option(help="Line: HD, ZX, paper. A parameter set of the track FMU.", metavar="NAME"),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Parameter set of the vehicle, or another vehicle FMU.", metavar="NAME|FMU"
        ),
    ] = None,
    track: Annotated[Path | None, typer.Option(help="Another track FMU.", metavar="FMU")] = None,
    speed: Annotated[float | None, typer.Option(help="Running speed.", metavar="KM/H")] = None,
    distance: Annotated[
        float, typer.Option(help="Way of the leading wheelset.", metavar="M")
    ] = 100.0,
    until_steady: Annotated[
        float | None,
        typer.Option(
            help="End when the motion is steady: the largest relative change of wheel forces and "
            "axle-box accelerations from slab to slab, 0.001 say; --distance is the largest way.",
            metavar="CHANGE",
        ),
    ] = None,
    final_speed: Annotated[
        float | None,
        typer.Option(
            help="Speed at the end of the distance: the vehicle accelerates uniformly.",
            metavar="KM/H",
        ),
    ] = None,
    irregularity: Annotated[
        str | None,
        typer.Option(
            help="Irregularity of the track: german_low, german_high, chinese_ballastless (random, "
            "see track.irregularity.seed), rail_joint (both rails, half way), or a CSV or NetCDF "
            "file by distance.",
            metavar="NAME|FILE",
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="A parameter: track.NAME=VALUE or vehicle.NAME=VALUE. Repeat for more.",
            metavar="NAME=VALUE",
        ),
    ] = None,
    macro_step: Annotated[float, typer.Option(help="Communication step.", metavar="S")] = 1e-4,
    algorithm: Annotated[
        str,
        typer.Option(help="gauss-seidel, jacobi, iterative-gauss-seidel.", metavar="NAME"),
    ] = "gauss-seidel",
    record_every: Annotated[int, typer.Option(help="Record every N-th step.", metavar="N")] = 1,
    out: Annotated[
        Path | None, typer.Option(help="NetCDF file for the results.", metavar="FILE")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Picture: .png, .pdf or .svg.", metavar="FILE")
    ] = None,
) -> None:
    """Run vehicle and track together and print a summary.

    Parameters come from the parameter sets of --line and --vehicle, or those bound
    in SYSTEM.ssp, then from --speed and --irregularity, then from --set; the last one
    wins. All in SI units but --speed.

    For example:

      rail-cosim run --speed 300 --distance 200 --irregularity german_low --plot run.png

      rail-cosim run --irregularity german_low --set track.irregularity.seed=2

      rail-cosim run --irregularity rail_joint --set track.irregularity.rail_joint.position=40

      rail-cosim run --irregularity measured.csv --out run.nc
    """
    from rail_cosim.options import RunOptions
    from rail_cosim.runner import execute

    with plain_errors():
        options = RunOptions(
            system=system,
            line=line,
            vehicle=vehicle,
            track=track,
            speed=speed,
            distance=distance,
            until_steady=until_steady,
            final_speed=final_speed,
            irregularity=irregularity,
            settings=settings or [],
            macro_step=macro_step,
            algorithm=algorithm,
            record_every=record_every,
            out=out,
            plot=plot,
            command=typed_command(),
        )
        try:
            with progress() as terminal:
                dataset = execute(options, terminal)
        except RunError as error:
            _summary(error.dataset)
            _kept(options.out)
            raise
        _summary(dataset)


def _summary(dataset) -> None:
    from rail_cosim.summary import summarise
    from rail_cosim.tables import summary_table

    if dataset is not None and dataset.sizes["time"] > 1:
        show(summary_table(summarise(dataset), dataset))


def _kept(out: Path | None) -> None:
    if out is not None:
        remark(f"what was recorded is in {out}, marked incomplete")
