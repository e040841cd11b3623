"""The command ``rail-cosim``.

Exit status: 0 all right, 1 the run failed, 2 the command or a parameter is
wrong, 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import contextlib
import shlex
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rail_cosim import version
from rail_cosim.errors import RailCosimError, RunError

app = typer.Typer(
    name="rail-cosim",
    help="Co-simulation of a high-speed railway vehicle on an endless slab track.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
_DRAW_EVERY = 0.2  # s
_out = Console()
_err = Console(stderr=True)


@contextlib.contextmanager
def _plain_errors() -> Iterator[None]:
    """Turn errors into one block of text and an exit status."""
    try:
        yield
    except RailCosimError as error:
        _say_error(str(error))
        raise typer.Exit(error.exit_status) from error
    except KeyboardInterrupt as error:
        _say_error("stopped by the user")
        raise typer.Exit(130) from error


def _say_error(text: str) -> None:
    # No markup and no wrapping: names in brackets and long paths stay as they are.
    _err.print(f"rail-cosim: error: {text}", markup=False, highlight=False, soft_wrap=True)


class _Terminal:
    """Reporter with a progress bar on standard error, if that is a terminal."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar
        self._task = bar.add_task("starting", total=None)
        self._drawn = 0.0

    def stage(self, text: str) -> None:
        """Show what is being done."""
        self._bar.update(self._task, description=text, refresh=True)

    def progress(self, done: int, planned: int) -> None:
        """Move the bar, a few times a second at most: drawing takes time from the run."""
        now = time.monotonic()
        if now - self._drawn >= _DRAW_EVERY or done == planned:
            self._drawn = now
            self._bar.update(self._task, completed=done, total=planned)
            self._bar.refresh()

    def notice(self, text: str) -> None:
        """Print a warning."""
        self._bar.console.print(
            f"rail-cosim: warning: {text}", markup=False, highlight=False, soft_wrap=True
        )


@contextlib.contextmanager
def _progress() -> Iterator[_Terminal]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    quiet = not _err.is_terminal
    # Refreshed by hand: a thread of its own would take time from the slaves.
    with Progress(*columns, console=_err, transient=True, auto_refresh=False, disable=quiet) as bar:
        yield _Terminal(bar)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"rail-cosim {version()}")
        raise typer.Exit


@app.callback()
def _common(
    show: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    pass


@app.command()
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
) -> None:
    """Build HighSpeedVehicle.fmu, InfiniteSlabTrack.fmu, and the system of both for other tools.

    VehicleOnSlabTrack.ssp has all in one; OspSystemStructure.xml is for libcosim.
    """
    from rail_cosim.builder import build as build_all

    with _plain_errors():
        for path in build_all(out, line=line, vehicle=vehicle, at_rest=at_rest):
            print(path)


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

    with _plain_errors():
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
            command=shlex.join(["rail-cosim", *sys.argv[1:]]),
        )
        try:
            with _progress() as terminal:
                dataset = execute(options, terminal)
        except RunError as error:
            _summary(error.dataset)
            _kept(options.out)
            raise
        _summary(dataset)


@app.command()
def check(
    fmu: Annotated[Path, typer.Argument(help="A vehicle or a track.", metavar="FMU")],
) -> None:
    """Say whether an FMU can be the vehicle or the track of a run.

    Terminals wheelset[i] with units and causality, wheelset_count, what is optional
    and absent, and the rules of FMI that tools rely on. Nothing is run. Exit status 0
    if it satisfies the contract, 1 if not, 2 if it is no FMU.
    """
    from rail_cosim.check import check_fmu, check_table, verdict

    with _plain_errors():
        report = check_fmu(fmu)
    if report.contract or report.manners:
        _out.print(check_table(report))
    _out.print(verdict(report), markup=False, highlight=False, soft_wrap=True)
    if not report.passed:
        raise typer.Exit(1)


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

    with _plain_errors():
        with _progress() as terminal:
            dataset = execute_sweep(
                read_specification(specification),
                scheduler=scheduler,
                workers=workers,
                out=out,
                store=store,
                reporter=terminal,
            )
        _out.print(sweep_table(dataset))
        print(out)
        if bool((dataset["error"] != "").all()):
            raise RailCosimError("every point failed")


@app.command()
def study(
    name: Annotated[str, typer.Argument(help="critical-speed, table3, ... (see below), or all.")],
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
    in the folder points: after a stop the same command goes on where it was.

    all: every study, one after the other; one that fails does not end it, but
    then the exit status is 1.

    For example:

      rail-cosim study critical-speed --out studies --set vehicle.yaw_damper.damping=0

      rail-cosim study table3 --quick --out studies

      rail-cosim study contact-geometry --set track.contact.rail_profile=60E1

      rail-cosim study p2 --set vehicle.wheelset.mass=1500
    """
    from rail_cosim.studies import ALL, STUDIES, StudyOptions, run_study

    with _plain_errors():
        options = StudyOptions(
            out=out,
            quick=quick,
            settings=settings or [],
            command=shlex.join(["rail-cosim", *sys.argv[1:]]),
        )
        names = list(STUDIES) if name == ALL else [name]
        problems: dict[str, str] = {}
        for one in names:
            try:
                with _progress() as terminal:
                    result = run_study(one, options, terminal)
            except RailCosimError as error:
                if name != ALL:
                    raise
                problems[one] = str(error)
                _say_error(f"{one}: {error}")
                continue
            _out.print(result.table)
            _out.print(result.conclusion, markup=False, highlight=False, soft_wrap=True)
            for path in result.files:
                print(path)
        if name == ALL:
            _out.print(f"{len(names) - len(problems)} of {len(names)} studies were done")
        if problems:
            raise RailCosimError("these studies failed: " + ", ".join(problems))


@app.command()
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

    with _plain_errors():
        options = RunOptions(
            speed=speed,
            macro_step=macro_step,
            settings=["track.contact.model=profiles", *(settings or [])],
        )
        found = benchmark(options, reference=reference)
    if as_json:
        print(found.to_json())
    else:
        _out.print(benchmark_table(found))


@app.command()
def verify(
    out: Annotated[Path, typer.Option(help="Directory for the page.", metavar="DIR")] = Path("."),
    full: Annotated[
        bool, typer.Option("--full", help="With the longer runs: some minutes.")
    ] = False,
) -> None:
    """Compare the product with everything that is known, and print the table.

    Rail, slab, contact, P2 resonance, irregularities and vehicle from their own
    packages, and coupled runs of both FMUs, each beside its reference with
    source and tolerance; DIR/verification.html has it all with plots. Exit
    status 1 if a value is beyond its tolerance.
    """
    from rail_cosim.verification import PAGE, execute_verification
    from rail_cosim.verification.terminal import conclude, section_table

    with _plain_errors():
        command = shlex.join(["rail-cosim", *sys.argv[1:]])
        with _progress() as terminal:
            values = execute_verification(out, command, terminal, full=full)
        for title, rows in values.sections.items():
            _out.print(section_table(title, rows))
        _out.print(conclude(values), markup=False, highlight=False, soft_wrap=True)
        print(out / PAGE)
    if values.failed:
        raise typer.Exit(1)


def _summary(dataset) -> None:
    from rail_cosim.summary import summarise
    from rail_cosim.tables import summary_table

    if dataset is not None and dataset.sizes["time"] > 1:
        _out.print(summary_table(summarise(dataset), dataset))


def _kept(out: Path | None) -> None:
    if out is not None:
        text = f"what was recorded is in {out}, marked incomplete"
        _err.print(text, markup=False, highlight=False, soft_wrap=True)


def main() -> None:
    """Run the command line."""
    app()


if __name__ == "__main__":
    main()
