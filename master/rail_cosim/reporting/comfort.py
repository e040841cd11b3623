"""Section with ride comfort."""

from __future__ import annotations

import xarray as xr

from rail_cosim.postprocessing import (
    comfort_in_words,
    mean_comfort,
    sperling_index,
    weighted_rms,
)
from rail_cosim.postprocessing.comfort import BLOCK, BLOCKS, SETTLING
from rail_cosim.presentation import channels
from rail_cosim.reporting.sections import MissingError, Section, Table, need, number


def comfort(run: xr.Dataset) -> Section:
    """Return the section of ride comfort."""
    section = Section(
        title="Ride comfort",
        intro="At the floor of the car body. Sperling: 1 just noticeable, 2 clearly noticeable, "
        "2.5 more pronounced but not unpleasant, 3 strong but still tolerable.",
    )
    section.add(lambda: _comfort(run))
    return section


def _comfort(run: xr.Dataset) -> Table:
    floor = [f"car_body_floor_{d}_acceleration" for d in ("lateral", "vertical")]
    centre = [f"car_body_{d}_acceleration" for d in ("lateral", "vertical")]
    lateral, vertical = (need(run, *pair) for pair in zip(floor, centre, strict=True))
    if lateral.dims != vertical.dims:
        raise MissingError(f"{lateral.name} and {vertical.name} are not of the same places")
    start = _comfort_start(run)
    index = mean_comfort(lateral, vertical, start=start)
    columns = [
        ("a_w lateral, Wd (m/s²)", weighted_rms(lateral, "Wd", start=start)),
        ("a_w vertical, Wk (m/s²)", weighted_rms(vertical, "Wk", start=start)),
        ("a_w vertical, Wb (m/s²)", weighted_rms(vertical, "Wb", start=start)),
        ("Sperling lateral", sperling_index(lateral, "lateral", start=start)),
        ("Sperling vertical", sperling_index(vertical, "vertical", start=start)),
        ("N_MV, EN 12299", index),
    ]
    rows = [[name] for name, *_ in channels(index.rename("centre of the car body"))]
    for _, values in columns:
        for row, (_, value, *_) in zip(rows, channels(values), strict=True):
            row.append(number(float(value), 3))
    for row, (_, value, *_) in zip(rows, channels(index), strict=True):
        row.append(comfort_in_words(float(value)))
    blocks = index.attrs["blocks"]
    caption = (
        f"Evaluation window: {columns[0][1].attrs['evaluated_over']}, without the transient of the "
        f"first {SETTLING:g} s; N_MV from {blocks} of the {BLOCKS} blocks of {BLOCK:g} s that "
        "EN 12299 requires" + (", so an indication only" if blocks < BLOCKS else "")
    )
    return Table(heads=["position", *(head for head, _ in columns), ""], rows=rows, caption=caption)


def _comfort_start(run: xr.Dataset) -> float:
    """Return the time (s) from which on comfort is evaluated; refuse a run without a block."""
    time = run["time"].to_numpy()
    start, duration = float(time[0]) + SETTLING, float(time[-1] - time[0])
    # The records are half-open intervals: a block ends one step before the next begins.
    if duration * time.size / (time.size - 1) < (SETTLING + BLOCK) * (1.0 - 1e-9):
        raise MissingError(
            f"ride comfort: the run lasts {duration:.3g} s; the first {SETTLING:g} s are left to "
            f"the transient of the start, and the standards average over {BLOCK:g} s or more: run "
            f"{SETTLING + BLOCK:g} s at least, {BLOCKS * BLOCK + SETTLING:g} s for N_MV of EN 12299"
        )
    return start
