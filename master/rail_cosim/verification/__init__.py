"""The verification report: every reference value beside the computed one.

The components' own values come from their packages, each in a process of its own; coupled ones
from runs of both FMUs.
"""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rail_cosim.studies.base import make_directory
from rail_cosim.verification.components import MODULES, component_values
from rail_cosim.verification.coupled import coupled_values
from rail_cosim.verification.page import write_page
from rail_cosim.verification.rows import Curve, Row, Values

if TYPE_CHECKING:
    from rail_cosim.reporter import Reporter

__all__ = ["PAGE", "Curve", "Row", "Values", "execute_verification", "gather", "verify"]

PAGE = "verification.html"


def gather(reporter: Reporter, *, full: bool = False) -> Values:
    """Compute all values; ``full`` adds the longer runs.

    Raises
    ------
    RailCosimError
        If one cannot be computed.
    """
    values = Values(rows=[])
    for name in MODULES:
        reporter.stage(f"verifying the {name}")
        values += component_values(name)
    return values + coupled_values(reporter, full=full)


def execute_verification(out: Path, command: str, reporter: Reporter, *, full: bool) -> Values:
    """Compute all values and write the page into the directory ``out``."""
    make_directory(out)
    values = gather(reporter, full=full)
    write_page(values, out / PAGE, command)
    return values


def verify(
    *, out: str | Path = ".", full: bool = False, reporter: Reporter | None = None
) -> Values:
    """Do the verification; mirrors ``rail-cosim verify``.

    Parameters
    ----------
    out
        Directory for the page.
    full
        With the longer runs.
    reporter
        Told of stages, progress and warnings.

    Returns
    -------
    Values
        Its ``failed`` are the rows that fail.

    Raises
    ------
    RailCosimError
        If a value cannot be computed, or the page not written.
    """
    from rail_cosim.reporter import Quiet

    command = shlex.join(sys.argv)
    return execute_verification(Path(out), command, reporter or Quiet(), full=full)
