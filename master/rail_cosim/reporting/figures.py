"""Sections with tables: settings, statistics of the evaluation window, residuals, parameters."""

from __future__ import annotations

import json
import math

import numpy as np
import xarray as xr

from rail_cosim.attributes import CHANGED
from rail_cosim.irregularity import irregularity_words
from rail_cosim.postprocessing import (
    basic_statistics,
    evaluated,
    guiding_statistics,
    passing_amplitudes,
    static_wheel_load,
    steady_state_amplitude,
    vertical_force,
    wheel_statistics,
)
from rail_cosim.presentation import all_without_round_off, channels, title
from rail_cosim.reporting.schematic import drawing, geometry
from rail_cosim.reporting.sections import Figure, MissingError, Section, Table, number, text
from rail_cosim.summary import Summary
from rail_cosim.window import distances

_ACCELERATIONS = (
    "axle_box_vertical_acceleration",
    "bogie_vertical_acceleration",
    "bogie_lateral_acceleration",
    "car_body_vertical_acceleration",
    "car_body_lateral_acceleration",
)
ABOUT = (
    ("command", "command"),
    ("date", "date"),
    ("source", "program"),
    ("line", "line"),
    ("speed_km_h", "speed (km/h)"),
    ("algorithm", "coupling algorithm"),
    ("macro_step", "communication step (s)"),
    ("steps", "communication steps"),
    ("simulated_seconds", "simulated time (s)"),
    ("wall_clock_seconds", "wall-clock time (s)"),
    ("real_time_factor", "real-time factor"),
)

RESIDUALS = (
    ("interface_energy_residual", "energy residual of the coupling, net (J)"),
    ("interface_energy_absolute_residual", "sum of the absolute residuals of the steps (J)"),
    ("interface_energy_exchanged", "work exchanged (J)"),
    ("interface_energy_residual_share", "absolute residual over work exchanged"),
    ("interface_energy_residual_limit", "the same, limit for a good coupling"),
    ("algorithm_iterations", "iterations"),
    ("steady_change", "change from slab to slab at the end of the run"),
)
"""Attributes of a run that tell how good the coupling was, and words for them."""


def settings(run: xr.Dataset) -> Section:
    """Return the section of the simulation settings, with a schematic."""
    about = run.attrs
    rows = [[words, text(about[name])] for name, words in ABOUT if about.get(name, "") != ""]
    distance = distances(run)
    rows.append(["distance travelled", f"{distance[-1] - distance[0]:.6g} m"])
    rows.append(["records", str(run.sizes["time"])])
    if irregularity := irregularity_words(about):
        rows.append(["irregularity", irregularity])
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
    section = Section(title="Simulation settings")
    section.add(lambda: Table(heads=["", ""], rows=rows, numeric=False))
    section.add(lambda: _schematic(run))
    return section


def _schematic(run: xr.Dataset) -> Figure:
    svg = drawing(geometry(run))
    if not svg:
        raise MissingError("wheelset_longitudinal_position: no schematic can be drawn without it")
    return Figure(title="Vehicle and window at the start, to scale along the line", svg=svg)


def statistics(run: xr.Dataset, summary: Summary) -> Section:
    """Return the section of statistics."""
    section = Section(
        title="Statistics of the evaluation window",
        intro=f"{summary.window.text}: {summary.state}. 20 Hz: after the low-pass filter of "
        "EN 14363, percentiles 0.15 % and 99.85 %. Formulas are in the documentation of "
        "rail_cosim.postprocessing.",
    )
    section.add(lambda: _wheels(run))
    section.add(lambda: _lateral(run))
    section.add(lambda: _passing(run))
    section.add(lambda: _accelerations(run))
    return section


def _columns(
    found: xr.Dataset, columns: list[tuple[str, str, float]], load: float
) -> list[list[str]]:
    """One row per channel: its name, and the columns' values; ``load`` of a wheel in N."""
    found = all_without_round_off(found, load)
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
        ("amplitude", "amplitude to 500 Hz, last slab length (kN)", 1e-3),
        ("dynamic_factor", "dynamic factor", 1.0),
        ("unloading", "ΔQ/Q₀", 1.0),
        ("dynamic_factor_20_hz", "dynamic factor 20 Hz", 1.0),
        ("unloading_20_hz", "ΔQ/Q₀ 20 Hz", 1.0),
    ]
    found = wheel_statistics(run)
    found["amplitude"] = steady_state_amplitude(run, vertical_force(run))
    load = static_wheel_load(run)
    caption = "Vertical wheel force Q" + (
        "" if math.isnan(load) else f"; static load {load / 1e3:.4g} kN"
    )
    heads = ["wheel", *(head for _, head, _ in columns)]
    return Table(heads=heads, rows=_columns(found, columns, load), caption=caption)


def _lateral(run: xr.Dataset) -> list[Table]:
    found = guiding_statistics(run)
    limit, load = float(found["prudhomme_limit"]) / 1e3, static_wheel_load(run)
    climbing = [
        ("flange_climbing", "99.85 %, 20 Hz, 2 m", 1.0),
        ("flange_climbing_peak", "largest", 1.0),
    ]
    sums = [
        ("sum_of_guiding_forces", "0.15 % or 99.85 %, 20 Hz, 2 m (kN)", 1e-3),
        ("sum_of_guiding_forces_peak", "largest (kN)", 1e-3),
    ]
    return [
        Table(
            heads=["wheel", *(head for _, head, _ in climbing)],
            rows=_columns(found, climbing, load),
            caption="Y/Q",
        ),
        Table(
            heads=["wheelset", *(head for _, head, _ in sums)],
            rows=_columns(found, sums, load),
            caption="Track shifting force (sum of Y), magnitude; limit 10 kN + 2 Q₀/3 = "
            f"{limit:.4g} kN",
        ),
    ]


def _passing(run: xr.Dataset) -> Table:
    found = passing_amplitudes(run, vertical_force(run), harmonics=(1, 2, 3))
    rows = [[name] for name, *_ in channels(found["sleeper"].isel(harmonic=0))]
    heads = ["wheel"]
    for what, words in (("sleeper", "fastener"), ("slab", "slab")):
        for k in range(found.sizes["harmonic"]):
            heads.append(f"{words} × {k + 1} (kN)")
            of = channels(found[what].isel(harmonic=k))
            for row, (_, value, *_) in zip(rows, of, strict=True):
                row.append(number(float(value) / 1e3))
    caption = "Fastener-passing and slab-passing amplitudes of Q and their harmonics"
    return Table(heads=heads, rows=rows, caption=caption)


def _accelerations(run: xr.Dataset) -> Table:
    heads = ["acceleration (m/s²)", "rms", "min", "max", "0.15 %", "99.85 %"]
    names = ("rms", "min", "max", "percentile_0_15", "percentile_99_85")
    rows = []
    for name in _ACCELERATIONS:
        if name not in run:
            continue
        found = basic_statistics(run[name].isel(time=evaluated(run)))
        # The worst of its kind: largest magnitude of all channels.
        worst = int(np.argmax(found["peak"].to_numpy()))
        cells = [number(float(found[one].to_numpy().ravel()[worst])) for one in names]
        place = channels(found["peak"])[worst].name
        words = title(run[name])
        rows.append([words if place == "peak" else f"{words}: {place}", *cells])
    if not rows:
        raise MissingError("accelerations: none are among the outputs of this run's FMUs")
    return Table(heads=heads, rows=rows, caption="Accelerations, the channel with the largest peak")


def residuals(run: xr.Dataset) -> Section:
    """Return the section of the coupling's residuals."""
    section = Section(title="Coupling residuals")
    section.add(lambda: _residuals(run))
    return section


def _residuals(run: xr.Dataset) -> Table:
    rows = [[words, text(run.attrs[name])] for name, words in RESIDUALS if name in run.attrs]
    if "window_slide_count" in run:
        rows.append(["window shifts", str(int(run["window_slide_count"].to_numpy()[-1]))])
    if "window_slide_residual" in run:
        largest = float(run["window_slide_residual"].max())
        words = "largest change of the rail deflection at a window shift (nm)"
        rows.append([words, f"{largest * 1e9:.4g}"])
    if not rows:
        raise MissingError("coupling residuals: none are recorded in this file")
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
    rows = [[n, text(run.attrs.get(n, "?")), text(value)] for n, value in before.items()]
    return Table(heads=["parameter", "this run", "parameter set"], rows=rows, numeric=False)


def all_parameters(run: xr.Dataset) -> Section:
    """Return the section of all parameters, folded."""
    section = Section(title="All parameters", folded=True)
    rows = [
        [name, text(value)]
        for name, value in run.attrs.items()
        if name.startswith(("track.", "vehicle."))
    ]
    if rows:
        section.parts.append(Table(heads=["parameter", "value"], rows=rows, numeric=False))
    else:
        section.missing.append("no parameters are recorded in this file")
    return section
