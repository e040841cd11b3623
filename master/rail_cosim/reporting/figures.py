"""Sections with tables: statistics, comfort, quality of the co-simulation, what was run."""

from __future__ import annotations

import json
import math

import numpy as np
import xarray as xr

from rail_cosim.attributes import CHANGED
from rail_cosim.postprocessing import (
    basic_statistics,
    comfort_in_words,
    evaluated,
    guiding_statistics,
    mean_comfort,
    passing_amplitudes,
    sperling_index,
    static_wheel_load,
    steady_state_amplitude,
    vertical_force,
    weighted_rms,
    wheel_statistics,
)
from rail_cosim.postprocessing.comfort import BLOCK, BLOCKS, SETTLING
from rail_cosim.reporting.motion import channels
from rail_cosim.reporting.schematic import drawing, geometry
from rail_cosim.reporting.sections import Figure, MissingError, Section, Table, need, number
from rail_cosim.window import distances

_ABOUT = (
    ("command", "command"),
    ("date", "date"),
    ("source", "made by"),
    ("line", "line"),
    ("algorithm", "coupling"),
    ("macro_step", "macro step (s)"),
    ("steps", "macro steps"),
    ("simulated_seconds", "simulated (s)"),
    ("wall_clock_seconds", "wall clock (s)"),
    ("real_time_factor", "real-time factor"),
)


def what_was_run(run: xr.Dataset) -> Section:
    """Return the section that says what was run, with its picture."""
    about = run.attrs
    rows = [[words, _text(about[name])] for name, words in _ABOUT if about.get(name, "") != ""]
    way = distances(run)
    rows.append(["way", f"{way[-1] - way[0]:.6g} m"])
    rows.append(["records", str(run.sizes["time"])])
    for fmu in ("vehicle", "track"):
        if f"{fmu}_fmu" in about:
            tool = about.get(f"{fmu}_generation_tool", "")
            words = [
                about[f"{fmu}_fmu"],
                about.get(f"{fmu}_version", ""),
                about[f"{fmu}_guid"],
                tool,
            ]
            rows.append([f"{fmu} FMU", ", ".join(str(word) for word in words if word)])
    section = Section(title="What was run")
    section.add(lambda: Table(heads=["", ""], rows=rows, numeric=False))
    section.add(lambda: _picture(run))
    return section


def _picture(run: xr.Dataset) -> Figure:
    svg = drawing(geometry(run))
    if not svg:
        raise MissingError("wheelset_longitudinal_position: the picture cannot be drawn without it")
    return Figure(title="Vehicle and window at the start, to scale along the line", svg=svg)


def statistics(run: xr.Dataset) -> Section:
    """Return the section of statistics."""
    section = Section(
        title="Statistics",
        intro="Over the evaluated part. 20 Hz: after the low-pass of EN 14363, percentiles 0.15 % "
        "and 99.85 %. Formulas are in the documentation of rail_cosim.postprocessing.",
    )
    section.add(lambda: _wheels(run))
    section.add(lambda: _guiding(run))
    section.add(lambda: _passing(run))
    section.add(lambda: _accelerations(run))
    return section


def _columns(found: xr.Dataset, columns: list[tuple[str, str, float]]) -> list[list[str]]:
    """One row per channel: its name, and the columns' values."""
    first = found[columns[0][0]]
    rows = [[name] for name, *_ in channels(first)]
    for name, _, factor in columns:
        for row, (_, value, *_) in zip(rows, channels(found[name]), strict=True):
            row.append(number(float(value) * factor))
    return rows


def _wheels(run: xr.Dataset) -> Table:
    columns = [
        ("mean", "mean (kN)", 1e-3),
        ("rms", "rms (kN)", 1e-3),
        ("min", "min (kN)", 1e-3),
        ("max", "max (kN)", 1e-3),
        ("percentile_99_85", "99.85 % (kN)", 1e-3),
        ("amplitude", "amplitude to 500 Hz (kN)", 1e-3),
        ("dynamic_factor", "dynamic factor", 1.0),
        ("unloading", "ΔQ/Q₀", 1.0),
        ("dynamic_factor_20_hz", "dynamic factor 20 Hz", 1.0),
        ("unloading_20_hz", "ΔQ/Q₀ 20 Hz", 1.0),
    ]
    found = wheel_statistics(run)
    found["amplitude"] = steady_state_amplitude(run, vertical_force(run))
    load = static_wheel_load(run)
    caption = "Wheel forces Q" + ("" if math.isnan(load) else f"; static load {load / 1e3:.4g} kN")
    heads = ["wheel", *(head for _, head, _ in columns)]
    return Table(heads=heads, rows=_columns(found, columns), caption=caption)


def _guiding(run: xr.Dataset) -> list[Table]:
    found = guiding_statistics(run)
    limit = float(found["prudhomme_limit"]) / 1e3
    climbing = [
        ("flange_climbing", "99.85 %, 20 Hz, 2 m", 1.0),
        ("flange_climbing_peak", "largest", 1.0),
    ]
    sums = [
        ("sum_of_guiding_forces", "|0.15 %|, 99.85 %, 20 Hz, 2 m (kN)", 1e-3),
        ("sum_of_guiding_forces_peak", "largest (kN)", 1e-3),
    ]
    return [
        Table(
            heads=["wheel", *(head for _, head, _ in climbing)],
            rows=_columns(found, climbing),
            caption="Y/Q",
        ),
        Table(
            heads=["wheelset", *(head for _, head, _ in sums)],
            rows=_columns(found, sums),
            caption=f"Sum of guiding forces; 10 kN + 2 Q₀/3 = {limit:.4g} kN",
        ),
    ]


def _passing(run: xr.Dataset) -> Table:
    found = passing_amplitudes(run, vertical_force(run), harmonics=(1, 2, 3))
    rows = [[name] for name, *_ in channels(found["sleeper"].isel(harmonic=0))]
    heads = ["wheel"]
    for what in ("sleeper", "slab"):
        for k in range(found.sizes["harmonic"]):
            heads.append(f"{what} × {k + 1} (kN)")
            of = channels(found[what].isel(harmonic=k))
            for row, (_, value, *_) in zip(rows, of, strict=True):
                row.append(number(float(value) / 1e3))
    return Table(heads=heads, rows=rows, caption="Q at the harmonics of sleeper and slab passing")


def _accelerations(run: xr.Dataset) -> Table:
    heads = ["acceleration (m/s²)", "rms", "min", "max", "0.15 %", "99.85 %"]
    names = ("rms", "min", "max", "percentile_0_15", "percentile_99_85")
    rows = []
    for word, name in (
        ("axle box", "axle_box_vertical_acceleration"),
        ("bogie, vertical", "bogie_vertical_acceleration"),
        ("bogie, lateral", "bogie_lateral_acceleration"),
        ("car body, vertical", "car_body_vertical_acceleration"),
        ("car body, lateral", "car_body_lateral_acceleration"),
    ):
        if name not in run:
            continue
        found = basic_statistics(run[name].isel(time=evaluated(run)))
        # The worst of its kind: largest magnitude of all channels.
        worst = int(np.argmax(found["peak"].to_numpy()))
        cells = [number(float(found[one].to_numpy().ravel()[worst])) for one in names]
        place = channels(found["peak"])[worst][0]
        rows.append([word if place in ("peak", name) else f"{word}: {place}", *cells])
    if not rows:
        raise MissingError("accelerations: none are among the outputs of this run's FMUs")
    return Table(heads=heads, rows=rows, caption="Accelerations, the channel with the largest peak")


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


def quality(run: xr.Dataset) -> Section:
    """Return the section of the co-simulation's quality."""
    section = Section(title="Quality of the co-simulation")
    section.add(lambda: _quality(run))
    return section


def _quality(run: xr.Dataset) -> Table:
    about, rows = run.attrs, []
    for name, words, unit in (
        ("interface_energy_residual", "energy residual of the coupling, net", "J"),
        ("interface_energy_absolute_residual", "sum of the absolute residuals of the steps", "J"),
        ("interface_energy_exchanged", "energy exchanged", "J"),
        ("interface_energy_residual_share", "absolute residual over work exchanged", ""),
        ("algorithm_iterations", "iterations", ""),
        ("steady_change", "change from slab to slab at the end", ""),
    ):
        if name in about:
            rows.append([words, f"{float(about[name]):.4g} {unit}".strip()])
    if "window_slide_count" in run:
        rows.append(["slides of the window", str(int(run["window_slide_count"].to_numpy()[-1]))])
    if "window_slide_residual" in run:
        largest = float(run["window_slide_residual"].max())
        words = "largest change of the rails' deflection by a slide"
        rows.append([words, f"{largest * 1e9:.4g} nm"])
    if not rows:
        raise MissingError("nothing is recorded of it in this file")
    return Table(heads=["", ""], rows=rows, numeric=False)


def changed(run: xr.Dataset) -> Section:
    """Return the section of parameters that differ from the parameter sets."""
    section = Section(title="Parameters that differ from the parameter set")
    section.add(lambda: _changed(run))
    return section


def _changed(run: xr.Dataset) -> Table:
    try:
        before = json.loads(run.attrs[CHANGED])
    except (KeyError, TypeError, ValueError) as error:
        raise MissingError(
            f"the file has no attribute {CHANGED}, which runs have from this version on; see all "
            "parameters below"
        ) from error
    if not before:
        return Table(heads=["none"], rows=[], numeric=False)
    rows = [[n, _text(run.attrs.get(n, "?")), _text(value)] for n, value in before.items()]
    return Table(heads=["parameter", "this run", "parameter set"], rows=rows, numeric=False)


def all_parameters(run: xr.Dataset) -> Section:
    """Return the section of all parameters, shut."""
    section = Section(title="All parameters", folded=True)
    rows = [
        [name, _text(value)]
        for name, value in run.attrs.items()
        if name.startswith(("track.", "vehicle."))
    ]
    if rows:
        section.parts.append(Table(heads=["parameter", "value"], rows=rows, numeric=False))
    else:
        section.missing.append("no parameters are recorded in this file")
    return section


def _text(value: object) -> str:
    if isinstance(value, float | np.floating):
        return f"{float(value):.8g}"
    return "–" if value is None else str(value)
