"""``rail-cosim report``: a page to look at a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import app, examples, plain_errors, say, typed_command


@app.command(
    epilog=examples(
        "rail-cosim run --distance 200 --irregularity german_low --out run.nc",
        "rail-cosim report run.nc --out report.html",
    )
)
def report(
    run: Annotated[Path, typer.Argument(help="What run --out wrote.", metavar="RUN.nc")],
    out: Annotated[
        Path | None,
        typer.Option(help="The page; RUN.html by default.", metavar="FILE", show_default=False),
    ] = None,
) -> None:
    """Write one HTML page that shows a run.

    What was run, a picture of vehicle and window, forces and accelerations over the
    way, spectra, third-octave levels, orders, a spectrogram, statistics, ride comfort,
    quality of the co-simulation, parameters. Plots zoom; nothing is loaded from
    elsewhere. What a run does not have is said on the page.
    """
    from rail_cosim.reporting import execute_report

    with plain_errors():
        say(str(execute_report(run, out, typed_command())))
