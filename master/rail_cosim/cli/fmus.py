"""``rail-cosim build`` and ``rail-cosim check``: the FMUs themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import Quiet, app, examples, plain_errors, say, show


@app.command(
    epilog=examples(
        "rail-cosim build --out build",
        "rail-cosim build --out build --line ZX --at-rest",
    )
)
def build(
    out: Annotated[Path, typer.Option(help="Directory for the four files.")] = Path("."),
    line: Annotated[
        str, typer.Option(help="Parameter set of the track in the systems.", metavar="NAME")
    ] = "HD",
    vehicle: Annotated[
        str, typer.Option(help="Parameter set of the vehicle in the systems.", metavar="NAME")
    ] = "paper",
    at_rest: Annotated[
        bool,
        typer.Option(
            "--at-rest",
            help="Find the static equilibrium too, and put it into the systems: for tools that "
            "pass nothing on before the start.",
        ),
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Build both FMUs, and the system of both for other tools.

    HighSpeedVehicle.fmu and InfiniteSlabTrack.fmu; VehicleOnSlabTrack.ssp
    has all in one; OspSystemStructure.xml is for libcosim.
    """
    from rail_cosim.builder import build as build_all

    with plain_errors():
        for path in build_all(out, line=line, vehicle=vehicle, at_rest=at_rest):
            say(str(path))


@app.command(
    epilog=examples(
        "rail-cosim check my_vehicle.fmu",
        "rail-cosim check my_vehicle.fmu --map my_names.toml --run",
    )
)
def check(
    fmu: Annotated[Path, typer.Argument(help="A vehicle or a track.", metavar="FMU")],
    run: Annotated[
        bool,
        typer.Option(
            "--run",
            help="Run it alone for some steps too. Only for FMUs that you trust: they "
            "are programs.",
        ),
    ] = False,
    names: Annotated[
        Path | None,
        typer.Option(
            "--map",
            help="Its names where they are not the contract's.",
            metavar="FILE.toml",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Say whether an FMU can be the vehicle or the track of a run.

    Terminals wheelset[i] with units and causality, wheelset_count, what is optional
    and absent, and the rules of FMI that tools rely on. Nothing is run without --run, which
    also looks at values: all finite, signs of the contract's frame, way and velocity, the
    state set back. Exit status 0 if it satisfies the contract, 1 if not, 2 if it is no FMU.
    """
    from rail_cosim.check import check_fmu, check_table, verdict

    with plain_errors():
        report = check_fmu(fmu, run=run, names=names)
    if any(report.parts.values()):
        show(check_table(report))
    say(verdict(report))
    if not report.passed:
        raise typer.Exit(1)
