"""``rail-cosim bench`` and ``rail-cosim verify``: how fast and how right it is."""

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
    say,
    show,
    typed_command,
)


@app.command(
    epilog=examples(
        "rail-cosim bench",
        "rail-cosim bench --speed 400 --macro-step 5e-5 --json",
        "rail-cosim bench --reference benchmarks/article_method.py",
    )
)
def bench(
    as_json: Annotated[bool, typer.Option("--json", help="Print all figures as JSON.")] = False,
    speed: Annotated[float, typer.Option(help="km/h.")] = 300.0,
    macro_step: Annotated[float, typer.Option(help="s.")] = 1e-4,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="A parameter, as for run.", metavar="NAME=VALUE"),
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="Script to compare with: benchmarks/article_method.py of the sources."),
    ] = None,
) -> None:
    """Measure how fast the pair is, and where the time goes.

    The full contact in three dimensions on the line HD; CPU time per slab length of
    5.032 m, median of five. real_time_factor is simulated over CPU seconds: above 1
    is faster than real time.
    """
    from rail_cosim.bench import benchmark
    from rail_cosim.options import RunOptions
    from rail_cosim.tables import benchmark_table

    with plain_errors():
        options = RunOptions(
            speed=speed,
            macro_step=macro_step,
            settings=["track.contact.model=profiles", *(settings or [])],
        )
        found = benchmark(options, reference=reference)
    if as_json:
        say(found.to_json())
    else:
        show(benchmark_table(found))


@app.command(
    epilog=examples(
        "rail-cosim verify --out report",
        "rail-cosim verify --full --out report",
    )
)
def verify(
    out: Annotated[Path, typer.Option(help="Directory for the page.", metavar="DIR")] = Path("."),
    full: Annotated[
        bool, typer.Option("--full", help="With the longer runs: some minutes.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Compare the product with everything that is known, and print the table.

    Rail, slab, contact, P2 resonance, irregularities and vehicle from their own
    packages, and coupled runs of both FMUs, each beside its reference with
    source and tolerance; DIR/verification.html has it all with plots. Exit
    status 1 if a value is beyond its tolerance.
    """
    from rail_cosim.verification import PAGE, execute_verification
    from rail_cosim.verification.terminal import conclude, section_table

    with plain_errors():
        command = typed_command()
        with progress() as terminal:
            values = execute_verification(out, command, terminal, full=full)
        for title, rows in values.sections.items():
            show(section_table(title, rows))
        say(conclude(values))
        say(str(out / PAGE))
    if values.failed:
        raise typer.Exit(1)
