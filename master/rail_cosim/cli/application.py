"""What all commands of ``rail-cosim`` share: the application, its consoles, errors, progress."""

from __future__ import annotations

import contextlib
import shlex
import sys
import time
from collections.abc import Iterator
from typing import Annotated

import typer
from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from rail_cosim import version
from rail_cosim.errors import RailCosimError

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
def plain_errors() -> Iterator[None]:
    """Turn errors into one block of text and an exit status."""
    try:
        yield
    except RailCosimError as error:
        say_error(str(error))
        raise typer.Exit(error.exit_status) from error
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


def show(table: RenderableType) -> None:
    """Print a table."""
    _out.print(table)


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
    quiet = not _err.is_terminal
    # Refreshed by hand: a thread of its own would take time from the slaves.
    with Progress(*columns, console=_err, transient=True, auto_refresh=False, disable=quiet) as bar:
        yield Terminal(bar)


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


def main() -> None:
    """Run the command line."""
    app()
