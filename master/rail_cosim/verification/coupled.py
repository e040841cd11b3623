"""Values of the coupled system: runs of both FMUs through the master.

Amplitudes are half the peak-to-peak over the last slab length, Fourier terms up to 500 Hz.
"""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from rail_cosim.options import KM_H, RunOptions
from rail_cosim.postprocessing.statistics import BAND_LIMIT, half_range_below_limit
from rail_cosim.reporter import Reporter
from rail_cosim.runner import execute
from rail_cosim.studies import StudyOptions, run_study
from rail_cosim.studies.slide import BEHIND, LEVEL
from rail_cosim.summary import spectrum, summarise
from rail_cosim.verification.rows import Curve, Row, Values
from rail_cosim.window import periods

SECTION = "Coupled: FMUs through the master"
FORCE, BOX = "normal_force", "axle_box_vertical_acceleration"
VERTICAL = "wheelset_contact_vertical_force"
PROFILES = "track.contact.model=profiles"
STIFFNESS = "track.fastener.vertical_stiffness"
_SLABS = 10
_SETTLED = 10 * 5.032  # m
_OFFSET = 2.5  # m; half a slab pitch, so that two runs slide at different places
_LONG, _SHORT = 100.0, 25.0  # m
_LOAD = 69.2108  # kN

_FE = "independent finite-element model of the test suite (own mesh, own integrator, 4 wheelsets)"
_ARTICLE = "the article, Figs. 8 and 9: sleeper-passing frequency, whole Hz"
_WEIGHT = "static load: (44039 + 2 x 2439 + 4 x 1881) kg x 9.81 m/s2 / 8, Table 2 of the article"
_FURTHEST = "the wheel furthest from it"
_OTHER_SPRING = "the model has eq. (1) on a level tread: another Hertz spring, no rail roll"
_UNDISTURBED = "an endless line has no window shifts; limit: 0.01 % of the static load"
_FIG_6 = (
    "moving mass in a window of 39 slabs, same run; the article's Fig. 6 has 0.01 % between them"
)


@dataclasses.dataclass(frozen=True)
class Case:
    """Amplitudes of the finite-element model: wheel force (N) and acceleration (m/s2).

    Values are those of the leading and the trailing wheelset of a bogie; both bogies are alike
    within 0.03 %. Speed in km/h, stiffness in N/m, damping 52 kN.s/m.
    """

    speed: float
    stiffness: float
    force: tuple[float, float]
    acceleration: tuple[float, float]

    @property
    def label(self) -> str:
        """Speed and pads in words."""
        return f"{self.speed:g} km/h, pads {1e-6 * self.stiffness:g} MN/m"


CASES = (
    Case(100.0, 40e6, (1420.83, 1470.28), (1.75494, 1.80100)),
    Case(170.0, 40e6, (1581.32, 1571.48), (1.74124, 1.72939)),
    Case(200.0, 40e6, (1402.44, 1377.21), (1.53403, 1.50731)),
    Case(300.0, 40e6, (1340.47, 1303.58), (1.44030, 1.39882)),
    Case(400.0, 40e6, (1479.18, 1570.07), (1.58176, 1.67831)),
    Case(100.0, 140e6, (1957.62, 1953.60), (2.27577, 2.26427)),
    Case(170.0, 140e6, (18409.47, 18732.62), (20.5082, 20.85396)),
    Case(200.0, 140e6, (7554.64, 7577.87), (8.27623, 8.30087)),
    Case(300.0, 140e6, (3756.23, 3783.83), (4.05231, 4.08006)),
    Case(400.0, 140e6, (2874.57, 2886.76), (3.07594, 3.09099)),
    Case(100.0, 200e6, (3173.37, 3177.50), (3.60850, 3.59584)),
    Case(170.0, 200e6, (20301.88, 20582.50), (22.58616, 22.88089)),
    Case(200.0, 200e6, (16300.34, 16372.71), (17.87502, 17.94800)),
    Case(300.0, 200e6, (5521.70, 5575.86), (5.95995, 6.01612)),
    Case(400.0, 200e6, (4027.05, 4059.22), (4.31207, 4.34453)),
)
QUICK = {(300.0, 40e6), (200.0, 140e6)}
"""Cases of the short report: both of the article's dominant frequencies are among them."""
DOMINANT = {(300.0, 40e6): 132.0, (200.0, 140e6): 88.0}
"""The article's dominant frequencies in Hz, by speed and pads."""


def coupled_values(reporter: Reporter, *, full: bool = False) -> Values:
    """Run the FMUs and return rows and curves; ``full`` adds runs and lengthens them."""
    values = Values(rows=[])
    chosen = [c for c in CASES if full or (c.speed, c.stiffness) in QUICK]
    for case in chosen:
        reporter.stage(f"verifying {case.label}")
        values += case_values(case, run_case(case, reporter))
    values += Values(rows=[], curves=amplitude_curves(chosen, values))
    reporter.stage("verifying the contact on profiles")
    values += Values(rows=profile_rows(reporter))
    reporter.stage("verifying window shifts")
    values += slide_values(reporter, _LONG if full else _SHORT)
    if full:
        values += Values(rows=joint_rows(reporter))
    return values


def run_case(case: Case, reporter: Reporter) -> xr.Dataset:
    """Run vehicle and track on smooth line HD for ten slab lengths."""
    return _run(case.speed, _SETTLED, [f"{STIFFNESS}={case.stiffness}"], reporter)


def _run(speed: float, distance: float, settings: list[str], reporter: Reporter) -> xr.Dataset:
    options = RunOptions(line="HD", speed=speed, distance=distance, settings=[LEVEL, *settings])
    return execute(options, reporter)


def case_values(case: Case, dataset: xr.Dataset) -> Values:
    """Return mean force, dominant frequency and amplitudes of a run, and its spectrum."""
    key, rows = (case.speed, case.stiffness), []
    mean = 1e-3 * _worst_mean(dataset, 1e3 * _LOAD)
    name = f"mean wheel force, {case.label}"
    rows.append(_row(name, "kN", _LOAD, 1e-4, mean, _WEIGHT, remark=_FURTHEST))
    curves = []
    if key in DOMINANT:
        found = summarise(dataset).dominant_frequency
        name = f"dominant frequency of the axle boxes, {case.label}"
        rows.append(_row(name, "Hz", DOMINANT[key], 1.0, found, _ARTICLE, relative=False))
        curves = [_spectrum(case, dataset)]
    for variable, known, unit, factor, what in (
        (FORCE, case.force, "kN", 1e-3, "wheel force"),
        (BOX, case.acceleration, "m/s2", 1.0, "axle-box acceleration"),
    ):
        found = amplitudes(dataset, variable).mean(axis=1)
        for number, value in enumerate(known, start=1):
            name = f"amplitude of {what} {number}, {case.label}"
            computed = factor * found[number - 1]
            rows.append(_row(name, unit, factor * value, 0.01, computed, _FE))
    return Values(rows=rows, curves=curves)


def profile_rows(reporter: Reporter) -> list[Row]:
    """Return mean force and amplitude with contact on profiles in three dimensions."""
    options = RunOptions(line="HD", speed=300.0, distance=_SETTLED, settings=[PROFILES])
    dataset = execute(options, reporter)
    evaluated = dataset[VERTICAL].isel(time=summarise(dataset).window.rows)
    mean = -0.5e-3 * float(evaluated.mean())
    known = next(case for case in CASES if (case.speed, case.stiffness) == (300.0, 40e6))
    found = 1e-3 * float(amplitudes(dataset, FORCE)[0].mean())
    name = "amplitude of wheel force 1, 300 km/h, contact on profiles"
    return [
        _row("mean wheel force, 300 km/h, contact on profiles", "kN", _LOAD, 1e-4, mean, _WEIGHT),
        _row(name, "kN", 1e-3 * known.force[0], 0.02, found, _FE, remark=_OTHER_SPRING),
    ]


def _worst_mean(dataset: xr.Dataset, load: float) -> float:
    mean = summarise(dataset)["wheel_force_mean"].to_numpy().ravel()
    return float(mean[np.argmax(np.abs(mean - load))])


def amplitudes(dataset: xr.Dataset, variable: str) -> NDArray[np.float64]:
    """Return half the peak-to-peak up to 500 Hz over the last slab length, (wheelset, side)."""
    time = dataset["time"].to_numpy()
    signal = dataset[variable].transpose("time", "wheelset", "side").to_numpy()
    _, pitch = periods(dataset)
    window = pitch / (dataset.attrs["speed_km_h"] * KM_H)
    count = round(window / (time[1] - time[0]))
    # A slab length is no whole number of steps: the samples are put where they fit.
    instants = time[-1] - window + window / count * np.arange(count)
    return half_range_below_limit(CubicSpline(time, signal)(instants), window / count)


def _spectrum(case: Case, dataset: xr.Dataset) -> Curve:
    time = dataset["time"].to_numpy()
    late = time > 0.5 * time[-1]
    boxes = dataset[BOX].to_numpy()[late].reshape(int(late.sum()), -1)
    frequencies, lines = spectrum(time[late], boxes)
    kept = frequencies <= BAND_LIMIT
    return Curve(
        plot="Spectrum of the axle-box acceleration",
        label=case.label,
        x_label="frequency (Hz)",
        y_label="amplitude, mean of all boxes (m/s2)",
        x=frequencies[kept].tolist(),
        y=lines.mean(axis=1)[kept].tolist(),
    )


def amplitude_curves(cases: list[Case], values: Values) -> list[Curve]:
    """Return amplitudes of the leading wheel over speed, with those of the finite elements.

    Only for pads with several speeds: a single one makes no curve.
    """
    axes: dict[str, Any] = {
        "plot": "Amplitude of the leading wheels' force",
        "x_label": "speed (km/h)",
        "y_label": "half peak-to-peak up to 500 Hz (kN)",
    }
    found = {row.name: row.computed for row in values.rows}
    curves = []
    for stiffness in sorted({case.stiffness for case in cases}):
        own = [case for case in cases if case.stiffness == stiffness]
        if len(own) < 2:
            continue
        speeds, pads = [case.speed for case in own], f"{1e-6 * stiffness:g} MN/m"
        computed = [found[f"amplitude of wheel force 1, {case.label}"] for case in own]
        known = [1e-3 * case.force[0] for case in own]
        curves.append(Curve(**axes, label=f"FMUs, {pads}", x=speeds, y=computed))
        label = f"finite elements, {pads}"
        curves.append(Curve(**axes, label=label, x=speeds, y=known, points=True))
    return curves


def slide_values(reporter: Reporter, distance: float) -> Values:
    """Return how much the place of the slides matters: two runs, half a slab apart."""
    runs = [
        _run(300.0, distance, [f"track.window.vehicle_offset={offset}"], reporter)
        for offset in (BEHIND, BEHIND + _OFFSET)
    ]
    first, second = (one[FORCE].to_numpy() for one in runs)
    difference = 0.1 / _LOAD * np.abs(first - second).max(axis=(1, 2))  # % of the static load
    name = f"disturbance by window shifts, 300 km/h, {distance:g} m, % of the static load"
    row = _row(name, "%", 0.0, 0.01, float(difference.max()), _UNDISTURBED, relative=False)
    curve = Curve(
        plot="Disturbance of the wheel forces by window shifts, 300 km/h",
        label="two runs that shift the window at different places",
        x_label="distance travelled (m)",
        y_label="largest difference (% of the static load)",
        x=runs[0]["distance"].to_numpy().tolist(),
        y=difference.tolist(),
    )
    return Values(rows=[row], curves=[curve])


def joint_rows(reporter: Reporter) -> list[Row]:
    """Return the peaks at a rail joint passed at a slide, from the study ``fig06``."""
    with tempfile.TemporaryDirectory(prefix="rail-cosim-") as folder:
        result = run_study("fig06", StudyOptions(out=Path(folder)), reporter)
        with xr.open_dataset(result.files[0], engine="h5netcdf") as file:
            peak = 1e-3 * file["peak"].load()
    reference = float(peak.sel(model="moving_mass"))
    rows = []
    for model in ("sliding", "ring"):
        name = f"largest wheel force at a rail joint, {model}, 300 km/h"
        found = float(peak.sel(model=model))
        rows.append(_row(name, "kN", reference, 1e-4, found, _FIG_6))
    return rows


def _row(
    name: str,
    unit: str,
    reference: float,
    tolerance: float,
    computed: float,
    source: str,
    *,
    relative: bool = True,
    remark: str = "",
) -> Row:
    return Row(
        section=SECTION,
        name=name,
        unit=unit,
        reference=reference,
        tolerance=tolerance,
        computed=float(computed),
        source=source,
        relative=relative,
        remark=remark,
    )
