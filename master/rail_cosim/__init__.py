"""The co-simulation master: runs a vehicle FMU and a track FMU together.

>>> import rail_cosim
>>> data = rail_cosim.run(line="HD", speed=300.0, distance=100.0)  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rail_cosim.builder import build as build
    from rail_cosim.case import read_case as read_case
    from rail_cosim.reporting import report as report
    from rail_cosim.run_result import RunResult as RunResult
    from rail_cosim.run_result import open_result as open_result
    from rail_cosim.runner import run as run
    from rail_cosim.studies import study as study
    from rail_cosim.summary import summarise as summarise
    from rail_cosim.sweeps import plot_sweep as plot_sweep
    from rail_cosim.sweeps import sweep as sweep
    from rail_cosim.verification import verify as verify

__all__ = [
    "RunResult",
    "build",
    "open_result",
    "plot_sweep",
    "read_case",
    "report",
    "run",
    "study",
    "summarise",
    "sweep",
    "verify",
    "version",
]

_HOME = {
    "RunResult": "rail_cosim.run_result",
    "build": "rail_cosim.builder",
    "open_result": "rail_cosim.run_result",
    "plot_sweep": "rail_cosim.sweeps",
    "read_case": "rail_cosim.case",
    "report": "rail_cosim.reporting",
    "run": "rail_cosim.runner",
    "study": "rail_cosim.studies",
    "summarise": "rail_cosim.summary",
    "sweep": "rail_cosim.sweeps",
    "verify": "rail_cosim.verification",
}


def version() -> str:
    """Return the version of the installed package; "unknown" in a bare source tree."""
    try:
        return metadata.version("rail-cosim")
    except metadata.PackageNotFoundError:
        return "unknown"


def __getattr__(name: str) -> Any:
    # Loaded on first use, so that `rail-cosim --help` does not wait for xarray.
    if name in _HOME:
        from importlib import import_module

        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
