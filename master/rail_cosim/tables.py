"""The summary of a run as a table on the terminal."""

from __future__ import annotations

import io
import math
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from rail_cosim.events import wheel_name
from rail_cosim.irregularity import irregularity_words
from rail_cosim.summary import Summary
from rail_cosim.window import ATTRIBUTE

if TYPE_CHECKING:
    from rail_cosim.bench import Benchmark

_SHOWN = 10
_WIDTH = 100
_NOT_RECORDED = "not recorded"


def as_text(shown: RenderableType) -> str:
    """Return what is shown on a terminal as text."""
    console = Console(file=io.StringIO(), width=_WIDTH)
    console.print(shown)
    return console.file.getvalue().rstrip("\n")  # type: ignore[attr-defined]


def _number(value: float, factor: float = 1.0, digits: int = 2) -> str:
    return "-" if math.isnan(value) else f"{value * factor:.{digits}f}"


Column = tuple[str, str, float, int]
"""Figure of a summary, head, factor and digits."""

EXTREMES: list[Column] = [
    ("wheel_force_max", "wheel force\nmax, kN", 1e-3, 3),
    ("wheel_force_max_distance", "at\nm", 1.0, 2),
    ("wheel_force_min", "wheel force\nmin, kN", 1e-3, 3),
    ("wheel_force_min_distance", "at\nm", 1.0, 2),
    ("axle_box_acceleration_peak", "peak axle-box\nacceleration\nm/s²", 1.0, 3),
    ("axle_box_acceleration_peak_distance", "at\nm", 1.0, 2),
]


def window_columns(summary: Summary) -> list[Column]:
    """Return the columns of the statistics of the evaluation window."""
    fastener = _number(summary.fastener_passing_frequency, digits=1)
    slab = _number(summary.slab_passing_frequency, digits=1)
    passing = "passing\namplitude¹"
    return [
        ("wheel_force_mean", "mean\nkN", 1e-3, 3),
        ("wheel_force_window_min", "min\nkN", 1e-3, 3),
        ("wheel_force_window_max", "max\nkN", 1e-3, 3),
        (
            "wheel_force_fastener_passing_amplitude",
            f"fastener-\n{passing}\n{fastener} Hz, kN",
            1e-3,
            3,
        ),
        ("wheel_force_slab_passing_amplitude", f"slab-\n{passing}\n{slab} Hz, kN", 1e-3, 3),
        ("axle_box_acceleration_window_peak", "peak\naxle-box\nacceler.\nm/s²", 1.0, 3),
    ]


def rows(summary: Summary, columns: list[Column]) -> list[list[str]]:
    """Return the cells of these columns, a row for each wheel; none if nothing is recorded."""
    there = [summary.data[name] for name, *_ in columns if name in summary.data]
    shape = max((array.shape for array in there), key=math.prod, default=(0, 0))

    def cell(wheel: tuple[int, ...], name: str, factor: float, digits: int) -> str:
        if name not in summary.data or summary.data[name].shape != shape:
            return "-"
        return _number(float(summary.data[name].to_numpy()[wheel]), factor, digits)

    return [
        [wheel_name(*wheel), *(cell(wheel, name, f, digits) for name, _, f, digits in columns)]
        for wheel in np.ndindex(*shape)
    ]


def _by_wheel(summary: Summary, title: str, columns: list[Column]) -> RenderableType:
    cells = rows(summary, columns)
    if not cells:
        return Text(f"{title}: wheel forces and accelerations {_NOT_RECORDED}")
    table = Table(title=title, title_justify="left", title_style="")
    table.add_column("wheel", no_wrap=True)
    for _, head, _, _ in columns:
        table.add_column(head, justify="right", no_wrap=True)
    for row in cells:
        table.add_row(*row)
    return table


def extremes_table(summary: Summary) -> RenderableType:
    """Return the table of the extremes of the whole run."""
    return _by_wheel(summary, f"Whole run, distance travelled {summary.whole.text}", EXTREMES)


def contact_text(summary: Summary) -> list[str]:
    """Return the losses of contact of each wheel in words, one line each."""
    if "loss_of_contact_count" not in summary.data:
        return [_NOT_RECORDED]
    lines: list[str] = []
    for wheel, count in np.ndenumerate(summary["loss_of_contact_count"].to_numpy()):
        if count:
            longest, total = (
                1e3 * float(summary[f"loss_of_contact_{name}"].to_numpy()[wheel])
                for name in ("longest", "total")
            )
            times = "once" if count == 1 else f"{count} times"
            durations = f"longest {longest:.4g} ms, total {total:.4g} ms"
            lines.append(f"wheel {wheel_name(*wheel)}: {times}, {durations}")
    return lines or ["none"]


def window_table(summary: Summary) -> RenderableType:
    """Return the table of the statistics of the evaluation window."""
    title = f"Evaluation window {summary.window.text}:\n{summary.state}"
    return _by_wheel(summary, title, window_columns(summary))


def figures(summary: Summary) -> Group:
    """Return all figures of a run: extremes, losses of contact, evaluation window, events."""
    facts = _facts()
    for number, line in enumerate(contact_text(summary)):
        facts.add_row("" if number else "loss of contact", line)
    rest = _facts()
    dominant = _number(summary.dominant_frequency, digits=1)
    rest.add_row("dominant frequency", f"{dominant} Hz in the axle-box accelerations")
    note = Text("¹ of the first harmonic")
    parts = [extremes_table(summary), facts, window_table(summary), note, rest]
    if summary.events:
        lines = ["Outside the evaluation window:", *summary.events]
        parts.append(Text("\n  ".join(lines), style="bold"))
    return Group(*parts)


def _facts() -> Table:
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    table.add_column(no_wrap=True)
    table.add_column()
    return table


def summary_table(summary: Summary, dataset: xr.Dataset) -> Group:
    """Return the whole summary: the figures, then the run's own.

    Parameters
    ----------
    summary
        The figures.
    dataset
        The run, for what its attributes say of the computing.
    """
    about = dataset.attrs
    facts = _facts()
    if words := irregularity_words(about):
        facts.add_row("irregularity", words)
    simulated, wall = about["simulated_seconds"], about["wall_clock_seconds"]
    facts.add_row(
        "real-time factor",
        f"{about['real_time_factor']:.2f}: {simulated:.3f} s in {wall:.3f} s "
        f"(processor {about['cpu_seconds']:.3f} s)",
    )
    facts.add_row("energy residual of the coupling", _energy_residual(about))
    parts: list[RenderableType] = [figures(summary), facts]
    if not about["complete"]:
        steps = f"incomplete run: {about['steps']} of {about['steps_planned']} steps"
        parts.append(Text(steps, style="bold red"))
    return Group(*parts)


def _energy_residual(about: dict[str, Any]) -> Text:
    """Return the energy residual of the coupling, and whether it is small enough."""
    share, limit = (about[f"interface_energy_residual_{name}"] for name in ("share", "limit"))
    text = f"{share:.2g} of the work exchanged "
    if share <= limit:
        return Text(f"{text}(good: up to {limit:g})")
    more = f"(above {limit:g}: take a smaller --macro-step)"
    return Text(text + more, style="bold red")


def sweep_table(dataset: xr.Dataset) -> Table:
    """Return how many points of a sweep there are, were steady and failed, and why.

    Parameters
    ----------
    dataset
        As :func:`rail_cosim.sweep` returns it.
    """
    error = dataset["error"]
    failed = [str(text) for text in error.to_numpy().ravel() if text]
    facts = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    facts.add_row("points", str(error.size))
    if "steady" in dataset:
        facts.add_row("steady", str(int((dataset["steady"] == 1).sum())))
    windows = dict.fromkeys(
        str(array.attrs[ATTRIBUTE]) for array in dataset.values() if ATTRIBUTE in array.attrs
    )
    if windows:
        facts.add_row("evaluated over", ", ".join(windows))
    facts.add_row("failed", str(len(failed)))
    reasons = Counter(failed)
    for text, count in reasons.most_common(_SHOWN):
        facts.add_row("", Text(f"{count} x {text}"))
    if len(reasons) > _SHOWN:
        facts.add_row("", f"and {len(reasons) - _SHOWN} other reasons: see the variable error")
    return facts


def benchmark_table(found: Benchmark) -> Table:
    """Return the table of ``rail-cosim bench``."""
    title = (
        f"{found.speed_km_h:.0f} km/h, macro step {found.macro_step:g} s, "
        f"{found.slab_length:g} m, processor time"
    )
    table = Table("", "", title=title, title_justify="left", title_style="", show_header=False)
    table.add_row("per slab length", f"{found.seconds_per_slab_length * 1e3:.1f} ms")
    table.add_row("real-time factor", f"{found.real_time_factor:.2f}")
    if found.ratio is not None and found.reference_seconds_per_slab_length is not None:
        other = found.reference_seconds_per_slab_length * 1e3
        table.add_row(
            "reference implementation", f"{other:.0f} ms, {found.ratio:.1f} times as long"
        )
    for name, value in found.microseconds_per_step.items():
        table.add_row(f"{name.replace('_', ' ')}, per macro step", f"{value:.1f} us")
    for name, value in (found.track_microseconds_per_step or {}).items():
        table.add_row(f"  track alone: {name.replace('_', ' ')}", f"{value:.2f} us")
    if found.slide_share is not None:
        table.add_row("window shifts, of all the time", f"{100 * found.slide_share:.2f} %")
    table.add_row("loading", f"{found.load:.2f} s")
    table.add_row("set-up", f"{found.setup:.2f} s")
    return table
