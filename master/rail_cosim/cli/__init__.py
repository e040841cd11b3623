"""The command ``rail-cosim``; each module has one or two of its commands.

Exit status: 0 all right, 1 the run failed, 2 the command or a parameter is
wrong, 130 stopped by Ctrl-C.
"""

# Importing a command's module adds it to the application; in this order they are listed.
# ruff: noqa: I001
from rail_cosim.cli.application import app, main
from rail_cosim.cli import fmus, run, report, sweep, study, measure

__all__ = ["app", "fmus", "main", "measure", "report", "run", "study", "sweep"]
