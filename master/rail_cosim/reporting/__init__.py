"""The HTML report of a run or of several: one file that needs no other file and no network."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, cast

import jinja2
import xarray as xr
from markupsafe import Markup

from rail_cosim.errors import ResultsError
from rail_cosim.html import STYLE, made
from rail_cosim.postprocessing import static_wheel_load
from rail_cosim.presentation import all_without_round_off
from rail_cosim.reporting import comparison, figures, frequencies, motion
from rail_cosim.reporting.charts import Chart
from rail_cosim.reporting.comfort import comfort
from rail_cosim.reporting.overview import overview
from rail_cosim.reporting.reading import ReportError, check_run, check_size, labels, open_run
from rail_cosim.reporting.sections import Section
from rail_cosim.summary import summarise

__all__ = ["ReportError", "compare", "execute_report", "page", "report"]

_LIBRARIES = ("numpy", "scipy", "xarray", "plotly")


def report(runs: xr.Dataset | Mapping[str, xr.Dataset], path: str | Path) -> Path:
    """Write the HTML report of a run, or the comparison of several; mirrors ``rail-cosim report``.

    Parameters
    ----------
    runs
        The run, as :func:`rail_cosim.run` returns it; or two runs or more by their labels, which
        are compared with the first.
    path
        The report to write.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    ReportError
        If a data set is not a run.
    ResultsError
        If the report cannot be written.
    """
    # A Dataset is a Mapping, too.
    several = {"dataset": runs} if isinstance(runs, xr.Dataset) else dict(runs)
    for name, run in several.items():
        check_run(run, name)
        check_size(run, name)
    return _write(several, Path(path), shlex.join(sys.argv))


def execute_report(paths: Sequence[Path], out: Path | None, command: str) -> Path:
    """Write the report of the runs in files.

    By default it is beside the run with the ending ``.html``, and ``comparison.html`` beside the
    first of several runs.

    Raises
    ------
    ReportError
        If a file is not a run.
    ResultsError
        If the report cannot be written, or would overwrite a run.
    """
    beside = paths[0].with_suffix(".html")
    target = out or (beside if len(paths) == 1 else beside.with_name("comparison.html"))
    if target.resolve() in [path.resolve() for path in paths]:
        raise ResultsError(f"{target}: is the run itself; name another file with --out")
    runs = {name: open_run(path) for name, path in zip(labels(paths), paths, strict=True)}
    return _write(runs, target, command)


def _write(runs: Mapping[str, xr.Dataset], path: Path, command: str) -> Path:
    text = page(next(iter(runs.values())), command) if len(runs) == 1 else compare(runs, command)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written ({error.strerror or error})") from error
    return path


def page(dataset: xr.Dataset, command: str = "") -> str:
    """Return the report of a run as text.

    Parameters
    ----------
    dataset
        A run of some records.
    command
        Said at the end of the report.
    """
    return _rendered(_title(dataset), _sections(dataset), command, _warning(dataset.attrs))


def compare(runs: Mapping[str, xr.Dataset], command: str = "") -> str:
    """Return the comparison of two runs or more, by their labels, as text."""
    cleaned = {
        name: all_without_round_off(run, static_wheel_load(run)) for name, run in runs.items()
    }
    return _rendered("Comparison: " + ", ".join(runs), comparison.sections(cleaned), command)


def _rendered(title: str, sections: list[Section], command: str, warning: str = "") -> str:
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True
    )
    cast(Any, environment).filters["embedded"] = _embedded  # jinja2 gives it no type
    text = resources.files("rail_cosim.reporting").joinpath("page.html").read_text(encoding="utf-8")
    return environment.from_string(text).render(
        title=title,
        warning=warning,
        style=Markup(STYLE),
        sections=sections,
        made=made(command or "rail_cosim.report", _LIBRARIES),
        plotly=_plotly(),
    )


def _sections(run: xr.Dataset) -> list[Section]:
    run = all_without_round_off(run, static_wheel_load(run))
    summary = summarise(run)
    return [
        overview(summary),
        figures.settings(run),
        figures.changed(run),
        figures.statistics(run, summary),
        comfort(run),
        motion.forces(run, summary.window),
        motion.accelerations(run, summary.window),
        frequencies.spectra(run, summary),
        frequencies.bands(run, summary),
        frequencies.over_time(run),
        figures.residuals(run),
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
