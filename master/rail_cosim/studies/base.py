"""What a study is asked for, and what it gives."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from rail_cosim.errors import ResultsError


@dataclasses.dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """How a study is to be done; the fields are the options of ``rail-cosim study``.

    Attributes
    ----------
    out
        Directory for data and plots; made if it is not there.
    quick
        A coarser result in less time.
    settings
        Texts ``track.NAME=VALUE`` and ``vehicle.NAME=VALUE``; they win over the study's own.
    command
        The command as typed, for the record.
    """

    out: Path
    quick: bool = False
    settings: Sequence[str] = ()
    command: str = ""


@dataclasses.dataclass(frozen=True, kw_only=True)
class StudyResult:
    """What a study found.

    Attributes
    ----------
    table
        The figures, for the terminal.
    conclusion
        The result in a sentence or two.
    files
        Data and plots that were written.
    """

    table: Table
    conclusion: str
    files: Sequence[Path]


def make_directory(path: Path) -> None:
    """Make a study's directory before it starts.

    Raises
    ------
    ResultsError
        If it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"{path}: cannot be made ({error.strerror})") from error
    if not os.access(path, os.W_OK):
        raise ResultsError(f"{path}: cannot be written to; give another directory with --out")
