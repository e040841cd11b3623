"""``rail-cosim sweep``: many."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import (
    Quiet,
    app,
    examples,
    plain_errors,
    progress,
    remark,
    say,
    show,
)
from rail_cosim.errors import RailCosimError


@app.command(
    epilog=examples(
        "rail-cosim sweep sweep.toml --out sweep.nc --plot sweep.png",
        "",
        "sweep.toml:",
        "",
        "  [run]",
        '  line = "HD"',
        "",
        "  [set]",
        "  track.fastener.vertical_damping = 10e3",
        "",
        "  [grid]",
        "  speed = { start = 80, stop = 400, step = 20 }",
        "  track.fastener.vertical_stiffness = [40e6, 140e6]",
        "",
        "  [keep]",
        '  normal_force = ["max", "min", "lift_off_time"]',
        '  axle_box_vertical_acceleration = ["peak", "dominant_frequency"]',
    )
)
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
    plot: Annotated[
        Path | None,
        typer.Option(
            help="Plot of a sweep over one or two axes: .png, .pdf or .svg.", metavar="FILE"
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run many points of any parameters and write one labelled data set.

    Each finished point is kept at once: after a stop the same command resumes
    where it was. A point that fails is in the result with the reason.

    SPEC has [grid] with axes (options of run, or parameters), or single
    [[points]]; [run] and [set] fix options and parameters; [keep] says which
    statistics of which variables; [window] over what: from and to (distance
    travelled, m) or last_slabs. Runs end when they are steady (until_steady,
    0.001) or after distance (500 m). Without [window] their last slab length is
    evaluated, and the whole run where until_steady is false, as it is with an
    irregularity unless given. Paths in SPEC are relative to its folder.

    The picture has a panel for each quantity: curves over one axis; over two a
    family of curves or a map; of the wheels the largest value (of a minimum the
    smallest).
    """
    from rail_cosim.sweeps import execute_sweep, read_specification, store_of
    from rail_cosim.tables import sweep_table

    with plain_errors():
        try:
            with progress() as terminal:
                dataset = execute_sweep(
                    read_specification(specification),
                    scheduler=scheduler,
                    workers=workers,
                    out=out,
                    store=store,
                    plot=plot,
                    reporter=terminal,
                )
        except KeyboardInterrupt:
            kept = store or store_of(out)
            remark(f"finished points are in {kept}: the same command resumes")
            raise
        show(sweep_table(dataset))
        for path in (out, plot):
            if path is not None:
                say(str(path))
        if bool((dataset["error"] != "").all()):
            raise RailCosimError("every point failed")
