"""``rail-cosim study``: the article's figures and tables, and more of their kind."""

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
    say_error,
    show,
    typed_command,
)
from rail_cosim.errors import RailCosimError, RunInterrupted


def _names(typed: str) -> list[tuple[str, str]]:
    from rail_cosim.studies import ALL, STUDIES

    known = {**STUDIES, ALL: "every study"}
    return [(name, about) for name, about in known.items() if name.startswith(typed)]


@app.command(
    epilog=examples(
        "rail-cosim study critical-speed --out studies --set vehicle.yaw_damper.damping=0",
        "rail-cosim study table3 --quick --out studies",
        "rail-cosim study contact-geometry --set track.contact.rail_profile=60E1",
        "rail-cosim study p2 --set vehicle.wheelset.mass=1500",
    )
)
def study(
    name: Annotated[
        str,
        typer.Argument(
            help="critical-speed, table3, ... (see above), or all.", autocompletion=_names
        ),
    ],
    quick: Annotated[bool, typer.Option("--quick", help="A coarser result in less time.")] = False,
    out: Annotated[Path, typer.Option(help="Directory for data and plot.", metavar="DIR")] = Path(
        "."
    ),
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="A parameter of the study's runs: track.NAME=VALUE or vehicle.NAME=VALUE. "
            "Repeat for more.",
            metavar="NAME=VALUE",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Do a study: prints its table and result, writes data (NetCDF) and plot.

    critical-speed: runs at rising speeds on smooth track, the vehicle starting
    10 mm off the middle with flanges touching, and narrows down the speed from
    which on this does not die out. To be quick it takes few modes and long steps;
    --set wins over that.

    contact-geometry: rolling-radius difference, contact angle and contact points
    of a wheelset from -8 to 8 mm, and the equivalent conicity at 3 mm.

    slide: how much a wheel force changes with the place of the slides, for several
    ways of sliding; passes below 0.01 % of the static load at 300 km/h.

    convergence: errors of wheel force and axle-box acceleration over the number of
    rail modes and of slab modes, with and without the compliance of those left out,
    and independent finite elements beside them.

    table1: moving mass, moving irregularity, sliding window and ring: how far each
    comes, what it sees of the fasteners, what it costs.

    fig05: the rail before and after a slide, by least squares and by the
    triangular solve of eq. (10).

    fig06: rail joint at the instant of a slide, sliding window and ring against a
    moving mass in a long window.

    receptance: motion of the rail heads per unit harmonic force, vertical and
    lateral, between fasteners and over one, from 2 Hz to 2 kHz.

    p2: P2 resonance for fasteners from 20 to 250 MN/m: the article's formula
    beside the eigenfrequency of a wheelset on the track.

    fig10: shape of that mode, for nominal and for winter fasteners.

    fig07, fig08, fig09, fig11, fig12, fig13, fig14, fig15, fig16, fig17, fig18,
    table3: the article's figure or table, with its own settings and with the
    converged defaults, and what its text says of it as checks. All runs are kept
    in the folder points: after a stop the same command resumes.

    all: every study, one after the other; one that fails does not end it, but
    then the exit status is 1. Ctrl-C does.
    """
    from rail_cosim.studies import ALL, STUDIES, StudyOptions, run_study

    with plain_errors():
        options = StudyOptions(
            out=out,
            quick=quick,
            settings=settings or [],
            command=typed_command(),
        )
        names = list(STUDIES) if name == ALL else [name]
        problems: dict[str, str] = {}
        for one in names:
            try:
                with progress() as terminal:
                    result = run_study(one, options, terminal)
            except RailCosimError as error:
                if name != ALL or isinstance(error, RunInterrupted):
                    raise
                problems[one] = str(error)
                say_error(f"{one}: {error}")
                continue
            show(result.table)
            say(result.conclusion)
            for path in result.files:
                say(str(path))
        if name == ALL:
            say(f"{len(names) - len(problems)} of {len(names)} studies were done")
        if problems:
            raise RailCosimError("these studies failed: " + ", ".join(problems))
