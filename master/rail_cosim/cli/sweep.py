"""``rail-cosim sweep``: many."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import app, plain_errors, progress, say, show
from rail_cosim.errors import RailCosimError


@app.command()
def sweep(
    specification: Annotated[
        Path, typer.Argument(help="TOML file: what to vary, fix and keep.", metavar="SPEC")
    ],
    scheduler: Annotated[
        str | None,
        typer.Option(help="A Dask scheduler; none: this machine.", metavar="ADDRESS"),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(help="Processes on this machine; one per processor.", metavar="N"),
    ] = None,
    out: Annotated[Path, typer.Option(help="NetCDF file for the result.", metavar="FILE")] = Path(
        "sweep.nc"
    ),
    store: Annotated[
        Path | None,
        typer.Option(
            help="Folder of the finished points; FILE with the ending .points.", metavar="DIR"
        ),
    ] = None,
) -> None:
    """Run many points of any parameters and write one labelled data set.

    Each finished point is kept at once: after a stop the same command goes on
    where it was. A point that fails is in the result with the reason.

    SPEC has [grid] with axes (options of run, or parameters), or single
    [[points]]; [run] and [set] fix options and parameters; [keep] says which
    statistics of which variables over the last slab length. Runs end when they
    are steady (until_steady, 0.001) or after distance (500 m). For example:

      [run]
      line = "HD"

      [set]
      track.fastener.vertical_damping = 10e3

      [grid]
      speed = { start = 80, stop = 400, step = 20 }
      track.fastener.vertical_stiffness = [40e6, 140e6]

      [keep]
      normal_force = ["max", "min", "lift_off_time"]
      axle_box_vertical_acceleration = ["peak", "dominant_frequency"]
    """
    from rail_cosim.sweeps import execute_sweep, read_specification
    from rail_cosim.tables import sweep_table

    with plain_errors():
        with progress() as terminal:
            dataset = execute_sweep(
                read_specification(specification),
                scheduler=scheduler,
                workers=workers,
                out=out,
                store=store,
                reporter=terminal,
            )
        show(sweep_table(dataset))
        say(str(out))
        if bool((dataset["error"] != "").all()):
            raise RailCosimError("every point failed")
