"""Command lines of ``rail-cosim``, one after the other in one process."""

from typer.testing import CliRunner


def invoke(lines: list[list[str]]) -> list[tuple[int, str, str]]:
    """Run each; return exit status, output of both streams, and what was raised beside an exit."""
    from rail_cosim.cli.application import app

    found = []
    for words in lines:
        done = CliRunner().invoke(app, words)
        ended = done.exception is None or isinstance(done.exception, SystemExit)
        found.append((done.exit_code, done.output, "" if ended else repr(done.exception)))
    return found
