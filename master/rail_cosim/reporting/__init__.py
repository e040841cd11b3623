"""The report of a run: one HTML page that needs no other file and no network."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any, cast

import jinja2
import xarray as xr
from markupsafe import Markup

from rail_cosim.errors import ResultsError
from rail_cosim.html import STYLE, made
from rail_cosim.reporting import figures, frequencies, motion
from rail_cosim.reporting.charts import Chart
from rail_cosim.reporting.reading import ReportError, check_run, open_run
from rail_cosim.reporting.sections import Section
from rail_cosim.summary import summarise

__all__ = ["ReportError", "execute_report", "page", "report"]

_LIBRARIES = ("numpy", "scipy", "xarray", "plotly")


def report(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write the report of a run; mirrors ``rail-cosim report``.

    Parameters
    ----------
    dataset
        The run, as :func:`rail_cosim.run` returns it.
    path
        The page to write.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    ReportError
        If the data set is no run.
    ResultsError
        If the page cannot be written.
    """
    check_run(dataset, "dataset")
    return _write(dataset, Path(path), shlex.join(sys.argv))


def execute_report(run: Path, out: Path | None, command: str) -> Path:
    """Write the report of the run in a file; beside it with the ending ``.html`` by default.

    Raises
    ------
    ReportError
        If the file is no run.
    ResultsError
        If the page cannot be written, or would overwrite the run.
    """
    target = out or run.with_suffix(".html")
    if target.resolve() == run.resolve():
        raise ResultsError(f"{target}: is the run itself; name another file with --out")
    return _write(open_run(run), target, command)


def _write(dataset: xr.Dataset, path: Path, command: str) -> Path:
    text = page(dataset, command)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


def page(dataset: xr.Dataset, command: str = "") -> str:
    """Return the page as text.

    Parameters
    ----------
    dataset
        A run of some records.
    command
        Said at the end of the page.
    """
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True
    )
    cast(Any, environment).filters["embedded"] = _embedded  # jinja2 gives it no type
    text = resources.files("rail_cosim.reporting").joinpath("page.html").read_text(encoding="utf-8")
    return environment.from_string(text).render(
        title=_title(dataset),
        warning=_warning(dataset.attrs),
        style=Markup(STYLE),
        sections=_sections(dataset),
        made=made(command or "rail_cosim.report", _LIBRARIES),
        plotly=_plotly(),
    )


def _sections(run: xr.Dataset) -> list[Section]:
    summary = summarise(run)
    return [
        figures.what_was_run(run),
        figures.changed(run),
        figures.statistics(run),
        figures.comfort(run),
        motion.forces(run, summary.window),
        motion.accelerations(run, summary.window),
        frequencies.spectra(run, summary),
        frequencies.bands(run),
        frequencies.over_time(run),
        figures.quality(run),
        figures.all_parameters(run),
    ]


def _title(run: xr.Dataset) -> str:
    about: dict[str, Any] = run.attrs
    words: list[str] = []
    if about.get("line"):
        words.append(f"line {about['line']}")
    if "speed_km_h" in about:
        words.append(f"{float(about['speed_km_h']):.4g} km/h")
    if "final_speed_km_h" in about:
        words[-1] += f" to {float(about['final_speed_km_h']):.4g} km/h"
    return "Run" + (": " + ", ".join(words) if words else "")


def _warning(about: Mapping[str, object]) -> str:
    if about.get("complete", 1):
        return ""
    reason = about.get("ended_by", "")
    return "Incomplete run: it ended early" + (f": {reason}" if reason else "") + "."


def _embedded(chart: Chart) -> Markup:
    """Return JSON that stays JSON inside a script element, whatever names it has."""
    text = json.dumps(chart, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _plotly() -> Markup:
    # Only its data file: importing plotly itself takes a second.
    text = resources.files("plotly").joinpath("package_data", "plotly.min.js").read_text("utf-8")
    return Markup(text.replace("</script", "<\\/script"))
