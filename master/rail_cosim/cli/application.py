"""What all commands of ``rail-cosim`` share: the application, its consoles, errors, progress."""

from __future__ import annotations

import contextlib
import shlex
import sys
import time
from collections.abc import Iterator
from typing import Annotated, Any

import typer
from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text
from typer.core import TyperCommand

from rail_cosim import version
from rail_cosim.errors import RailCosimError

_STATUS = (
    "Exit status: 0 all right; 1 the run failed, or a check was not passed; 2 the command, a "
    "parameter or a file is wrong; 130 stopped by Ctrl-C (what was computed is kept)."
)


def examples(*lines: str) -> str:
    """Return the end of a help text, with lines that stay as they are."""
    # Click keeps the lines of a paragraph that begins with \b; empty lines end paragraphs.
    kept = "\n".join("  " + line if line else "\n\b" for line in lines)
    return "For example:\n\n\b\n" + kept


# Help without markup: in Typer's boxes, names in brackets vanish and examples are broken.
app = typer.Typer(
    name="rail-cosim",
    help="Co-simulation of a high-speed railway vehicle on an endless slab track.\n\n" + _STATUS,
    epilog=examples(
        "rail-cosim run --speed 300 --out run.nc --plot run.png",
        "rail-cosim run winter.toml --distance 200",
        "rail-cosim sweep sweep.toml --out sweep.nc --plot sweep.png",
        "rail-cosim --install-completion",
    ),
    rich_markup_mode=None,
    context_settings={"max_content_width": 100},
    pretty_exceptions_enable=False,
)


class GroupedCommand(TyperCommand):
    """A command whose help lists its options in groups, by their ``rich_help_panel``.

    Typer itself groups them in its boxes only.
    """

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the options, group by group in the order of their first ones."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                argument = parameter.param_type_name == "argument"
                usual = "Arguments" if argument else "Other options"
                group = getattr(parameter, "rich_help_panel", None) or usual
                groups.setdefault(group, []).append(record)
        for group, records in groups.items():
            with formatter.section(group):
                formatter.write_dl(records)


_DRAW_EVERY = 0.2  # s
_WIDEST = 10_000  # characters
_out = Console()
_err = Console(stderr=True)


@contextlib.contextmanager
def plain_errors() -> Iterator[None]:
    """Turn errors into one block of text and an exit status."""
    try:
        yield
    except RailCosimError as error:
        say_error(str(error))
        raise typer.Exit(error.exit_status) from error
    except OSError as error:  # a full disk, say, or a quota, wherever a file is written
        what = f"{error.filename}: " if error.filename else ""
        say_error(f"{what}{error.strerror or error}")
        raise typer.Exit(1) from error
    except KeyboardInterrupt as error:
        say_error("stopped by the user")
        raise typer.Exit(130) from error


def say_error(text: str) -> None:
    """Print an error on standard error."""
    _plain(_err, f"rail-cosim: error: {text}")


def say(text: str) -> None:
    """Print a line of results."""
    _plain(_out, text)


def remark(text: str) -> None:
    """Print a line on standard error."""
    _plain(_err, text)


def given(context: typer.Context, values: dict[str, Any]) -> dict[str, Any]:
    """Return those of ``values`` that were typed, not defaults."""
    return {
        name: value
        for name, value in values.items()
        if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE"
    }


def show(table: RenderableType) -> None:
    """Print a table as wide as its content: never cut, neither in a file nor on a terminal."""
    if _out.quiet:
        return
    content = _out.measure(table, options=_out.options.update(max_width=_WIDEST))
    Console(width=content.maximum).print(table)


def _plain(console: Console, text: str) -> None:
    # No markup and no wrapping: names in brackets and long paths stay as they are.
    console.print(Text(text), soft_wrap=True)


def typed_command() -> str:
    """Return the command as typed, for the record."""
    return shlex.join(["rail-cosim", *sys.argv[1:]])


class Terminal:
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
        if _out.quiet:
            return
        _plain(self._bar.console, f"rail-cosim: warning: {text}")


@contextlib.contextmanager
def progress() -> Iterator[Terminal]:
    """Show a progress bar as long as this lasts."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    hidden = _out.quiet or not _err.is_terminal
    # Refreshed by hand: a thread of its own would take time from the slaves.
    with Progress(
        *columns, console=_err, transient=True, auto_refresh=False, disable=hidden
    ) as bar:
        yield Terminal(bar)


def _be_quiet(wanted: bool) -> bool:
    _out.quiet = wanted
    return wanted


Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet",
        "-q",
        callback=_be_quiet,
        is_eager=True,
        help="Print errors only; the exit status tells how it went.",
    ),
]
"""The option ``--quiet`` of a command; all that is said with this module's functions obeys."""


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"rail-cosim {version()}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def _common(
    context: typer.Context,
    show: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    _be_quiet(False)
    if context.invoked_subcommand is None:
        print(context.get_help())


def main() -> None:
    """Run the command line."""
    try:
        status = app(standalone_mode=False)
    except Exception as error:
        # A wrong command line; its class is Typer's or Click's, by their versions.
        if not hasattr(error, "format_message"):
            raise
        say_error(_usage(error))
        status = 2
    sys.exit(status if isinstance(status, int) else 0)


def _usage(error: Any) -> str:
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "rail-cosim"
    return f"{error.format_message()}\nsee {path} --help"
