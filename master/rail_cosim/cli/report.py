"""``rail-cosim report``: an HTML report of a run, or a comparison of several."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rail_cosim.cli.application import app, examples, plain_errors, say, typed_command


@app.command(
    epilog=examples(
        "rail-cosim run --distance 200 --irregularity german_low --out run.nc",
        "rail-cosim report run.nc --out report.html",
        "rail-cosim report soft.nc stiff.nc --out comparison.html",
    )
)
def report(
    runs: Annotated[
        list[Path],
        typer.Argument(help="What run --out wrote; several are compared.", metavar="RUN.nc..."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            help="HTML file; RUN.html by default, comparison.html beside the first of several.",
            metavar="FILE",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Write one HTML report of a run, or compare several runs.

    Of one run: extremes of the whole run and losses of contact, simulation settings, a
    schematic of vehicle and window, statistics of the evaluation window, forces and
    accelerations versus distance travelled, spectra, third-octave levels, orders, a
    spectrogram, ride comfort, coupling residuals, parameters.

    Of several: settings and parameters that differ, statistics with their windows and
    differences from the first run, histories versus distance travelled and spectra over
    each other. Length, step and recorded variables may differ.

    Plots zoom; nothing is loaded from elsewhere. What a run does not have is said.
    """
    from rail_cosim.reporting import execute_report

    with plain_errors():
        say(str(execute_report(runs, out, typed_command())))
