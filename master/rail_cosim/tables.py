"""The summary of a run as a table on the terminal."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from rail_cosim.bench import Benchmark
from rail_cosim.results import SIDES
from rail_cosim.summary import Summary

_SHOWN = 10


def _number(value: float, factor: float = 1.0, digits: int = 2) -> str:
    return "-" if math.isnan(value) else f"{value * factor:.{digits}f}"


def wheel_table(summary: Summary) -> Table:
    """Return the table of wheels: one row per wheelset and side."""
    title = f"Evaluated: {summary.range.text}"
    table = Table(title=title, title_justify="left", title_style="")
    table.add_column("wheel", no_wrap=True)
    heads = (
        "mean\nkN",
        "min\nkN",
        "max\nkN",
        f"at sleepers\n{_number(summary.sleeper_frequency, digits=1)} Hz, kN",
        f"at slabs\n{_number(summary.slab_frequency, digits=1)} Hz, kN",
        "box max\nm/s²",
    )
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    columns = (
        (summary.force_mean, 1e-3, 3),
        (summary.force_min, 1e-3, 3),
        (summary.force_max, 1e-3, 3),
        (summary.force_sleeper, 1e-3, 3),
        (summary.force_slab, 1e-3, 3),
        (summary.acceleration_max, 1.0, 3),
    )
    shape = max((values.shape for values, _, _ in columns), key=lambda shape: shape[0] * shape[1])
    for wheelset in range(shape[0]):
        for side in range(shape[1]):
            cells = [
                _number(float(values[wheelset, side]), factor, digits)
                if values.shape == shape
                else "-"
                for values, factor, digits in columns
            ]
            table.add_row(f"{wheelset + 1} {SIDES[side]}", *cells)
    return table


def summary_table(summary: Summary, dataset: xr.Dataset) -> Group:
    """Return the whole summary: wheels, then the run's own figures.

    Parameters
    ----------
    summary
        The figures.
    dataset
        The run, for what its attributes say of the computing.
    """
    about = dataset.attrs
    facts = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    facts.add_column()
    facts.add_column()
    dominant = _number(summary.dominant_frequency, digits=1)
    facts.add_row("dominant frequency", f"{dominant} Hz in the axle-box accelerations")
    simulated, wall = about["simulated_seconds"], about["wall_clock_seconds"]
    facts.add_row(
        "real-time factor",
        f"{about['real_time_factor']:.2f}: {simulated:.3f} s in {wall:.3f} s "
        f"(processor {about['cpu_seconds']:.3f} s)",
    )
    facts.add_row("energy residual of the coupling", _energy_residual(about))
    parts: list[Table | Text] = [wheel_table(summary), facts]
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
        table.add_row("slides, of all the time", f"{100 * found.slide_share:.2f} %")
    table.add_row("loading", f"{found.load:.2f} s")
    table.add_row("set-up", f"{found.setup:.2f} s")
    return table
