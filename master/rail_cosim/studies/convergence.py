"""Convergence in the modes of rail and slab, with and without the compliance of those left out.

Amplitudes are half the peak to peak over the last slab length, Fourier terms up to 500 Hz, as an
instrumented wheelset would give them. Errors are against a reference of the same model: the
finest count of modes with the static compliance of the modes left out. Beside it stand amplitudes
of an independent finite-element track, which says whether that reference is right.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from rich.table import Table

from rail_cosim.errors import RailCosimError
from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.slave import Value
from rail_cosim.studies.article import BOX, FORCE, STIFFNESS, specification_settings
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.convergence_plot import plot_convergence
from rail_cosim.sweeps import SweepSpecification, execute_sweep

CASES: Mapping[str, tuple[float, float]] = {
    "300 km/h, 40 MN/m": (300.0, 40e6),
    "170 km/h, 140 MN/m": (170.0, 140e6),
}
"""Speed in km/h and stiffness of the pads in N/m: nominal, and near the P2 resonance."""

COUNTS: Mapping[str, tuple[int, ...]] = {
    "rail": (100, 150, 200, 256, 300, 400, 600, 800),
    "slab": (12, 24, 36, 60, 100, 160, 240),
}
"""Modes of one part; the other part keeps its default, residual compliance included."""

_SLABS = 13
"""In the window, as in the article: so the counts of rail modes are comparable with its 200."""

DEFAULTS = {"rail": 256, "slab": 60}
"""With the default's shortest wave on so many slabs."""

LIMIT = 0.01
"""Largest error of the default counts, and of finite elements from the reference, that passes."""
_QUICK_LIMIT = 0.02  # its step of 0.2 ms alone is 1 % off the finite elements

_QUICK: Mapping[str, tuple[int, ...]] = {"rail": (100, 200, 256, 400), "slab": (24, 60, 120)}
_STATISTIC = "half_range_500_hz"
_QUANTITIES = {"force": (FORCE, "N"), "acceleration": (BOX, "m/s2")}

FINITE_ELEMENTS: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "300 km/h, 40 MN/m": {
        "force": (1340.47, 1303.58, 1340.52, 1303.92),
        "acceleration": (1.44030, 1.39882, 1.44029, 1.39919),
    },
    "170 km/h, 140 MN/m": {
        "force": (18409.47, 18732.62, 18409.44, 18732.37),
        "acceleration": (20.50820, 20.85396, 20.50815, 20.85376),
    },
}
"""Amplitudes of the whole vehicle by wheelset, N and m/s2, of an independent model: Timoshenko
beam elements for the rails, slabs of plate elements, an integrator of its own; mesh and step
refined until the force changed by less than 0.03 %. They are among those of
``tests/golden/steady_state_amplitudes.json``, made by ``python -m reference_fe.study`` (in
``tests/support``)."""


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: table, NetCDF file and plot."""
    data, picture = options.out / "convergence.nc", options.out / "convergence.png"
    check_netcdf(data)
    counts = _QUICK if options.quick else COUNTS
    points = execute_sweep(
        _specification(counts, options),
        scheduler=None,
        workers=None,
        out=None,
        store=options.out / "points",
        reporter=reporter,
    )
    if texts := [str(text) for text in points["error"].to_numpy() if text]:
        raise RailCosimError(f"{len(texts)} points failed, the first: {texts[0]}")
    dataset = as_dataset(points, counts, finite_elements=not options.settings)
    limit = _QUICK_LIMIT if options.quick else LIMIT
    dataset.attrs |= {"study": "convergence", "command": options.command, "limit": limit}
    write_netcdf(dataset, data)
    plot_convergence(dataset, picture)
    return StudyResult(table=as_table(dataset), conclusion=conclude(dataset), files=[data, picture])


def _axes(part: str, count: int, residual: bool, case: str) -> dict[str, Value]:
    """Return the values of all axes where ``part`` has ``count`` modes."""
    speed, stiffness = CASES[case]
    point: dict[str, Value] = {"speed": speed, STIFFNESS: stiffness}
    for name, default in DEFAULTS.items():
        there = name == part
        point[f"track.{name}.mode_count"] = count if there else default
        point[f"track.{name}.residual_compliance"] = residual if there else True
    return point


def _specification(
    counts: Mapping[str, tuple[int, ...]], options: StudyOptions
) -> SweepSpecification:
    points = [
        _axes(part, count, residual, case)
        for part, numbers in counts.items()
        for residual in (True, False)
        for count in numbers
        for case in CASES
    ]
    settings, run = specification_settings(options, {"track.window.slab_count": _SLABS})
    return SweepSpecification(
        points=points,
        settings=settings,
        run={**run, "distance": 60.0},
        keep={variable: (_STATISTIC,) for variable, _ in _QUANTITIES.values()},
    )


def as_dataset(
    points: xr.Dataset, counts: Mapping[str, tuple[int, ...]], *, finite_elements: bool
) -> xr.Dataset:
    """Return amplitudes and errors over the modes of either part.

    Parameters
    ----------
    points
        The sweep, in the order of :func:`_specification`.
    counts
        Modes by part.
    finite_elements
        Whether the amplitudes of the finite elements belong to this track.

    Returns
    -------
    xarray.Dataset
        ``PART_QUANTITY_amplitude`` over residual, ``PART_modes``, case and wheelset;
        ``PART_QUANTITY_error``, the largest of the wheelsets, relative; ``PART_steady``.
    """
    found = xr.Dataset(coords={"residual": [1, 0], "case": list(CASES)})
    start = 0
    for part, numbers in counts.items():
        shape = (2, len(numbers), len(CASES))
        rows = slice(start, start := start + int(np.prod(shape)))
        dims = ("residual", f"{part}_modes", "case")
        found = found.assign_coords({f"{part}_modes": list(numbers)})
        found[f"{part}_steady"] = (dims, points["steady"].to_numpy()[rows].reshape(shape))
        for quantity, (variable, unit) in _QUANTITIES.items():
            values = points[f"{variable}_{_STATISTIC}"].mean("side").to_numpy()[rows]
            amplitude = xr.DataArray(values.reshape(*shape, -1), dims=(*dims, "wheelset"))
            reference = amplitude[0, -1]  # with residual compliance, finest
            error = _relative(amplitude, reference)
            found[f"{part}_{quantity}_amplitude"] = amplitude.assign_attrs(units=unit)
            found[f"{part}_{quantity}_error"] = error.assign_attrs(units="1")
            if finite_elements:
                other = [FINITE_ELEMENTS[case][quantity] for case in CASES]
                compared = xr.DataArray(np.array(other), dims=("case", "wheelset"))
                away = _relative(compared, reference).assign_attrs(units="1")
                found[f"{part}_{quantity}_finite_elements"] = away
    return found


def _relative(values: xr.DataArray, reference: xr.DataArray) -> xr.DataArray:
    """Return the largest relative difference of any wheelset, with the sign it has."""
    error = values / reference - 1.0
    return error.isel(wheelset=abs(error).argmax("wheelset"))


def as_table(dataset: xr.Dataset) -> Table:
    """Return the errors in per cent; amplitudes of the reference in the last row of each part."""
    title = "Error in % against the finest modes with residual compliance, below 500 Hz"
    table = Table(title=title, title_justify="left", title_style="")
    table.add_column("")
    table.add_column("modes", justify="right")
    for case in CASES:
        where = case.replace(", ", "\n")
        for quantity in _QUANTITIES:
            table.add_column(f"{where}\n{quantity}", justify="right", min_width=8)
        table.add_column("steady", justify="right")
    for part in DEFAULTS:
        for residual, words in ((1, "with residual"), (0, "plain")):
            for count in dataset[f"{part}_modes"].to_numpy():
                cells = _cells(dataset, part, residual, int(count))
                table.add_row(f"{part}, {words}", str(count), *cells)
        if f"{part}_force_finite_elements" in dataset:
            table.add_row(f"{part}: finite elements", "", *_compared(dataset, part))
        table.add_row(f"{part}: N, m/s²", "", *_reference(dataset, part))
        table.add_section()
    return table


def _cells(dataset: xr.Dataset, part: str, residual: int, count: int) -> list[str]:
    cells = []
    at = dataset.sel({"residual": residual, f"{part}_modes": count})
    for case in CASES:
        errors = [float(at[f"{part}_{quantity}_error"].sel(case=case)) for quantity in _QUANTITIES]
        steady = bool(at[f"{part}_steady"].sel(case=case))
        cells += [*(f"{100.0 * error:+.2f}" for error in errors), "yes" if steady else "no"]
    return cells


def _compared(dataset: xr.Dataset, part: str) -> list[str]:
    cells = []
    for case in CASES:
        for quantity in _QUANTITIES:
            value = float(dataset[f"{part}_{quantity}_finite_elements"].sel(case=case))
            cells.append(f"{100.0 * value:+.2f}")
        cells.append("")
    return cells


def _reference(dataset: xr.Dataset, part: str) -> list[str]:
    cells = []
    for case in CASES:
        for quantity in _QUANTITIES:
            values = dataset[f"{part}_{quantity}_amplitude"].sel(case=case)
            cells.append(f"{float(values[0, -1].mean()):.5g}")
        cells.append("")
    return cells


def conclude(dataset: xr.Dataset) -> str:
    """Return the errors of the default counts and of the plain series, and the verdict."""
    words, largest = [], 0.0
    for part, count in DEFAULTS.items():
        errors = {r: _largest_error(dataset, part, r, count) for r in (1, 0)}
        largest = max(largest, errors[1])
        words.append(
            f"{count} {part} modes (default): {100.0 * errors[1]:.2g} % with residual compliance, "
            f"{100.0 * errors[0]:.2g} % without"
        )
    away = [float(np.abs(dataset[n]).max()) for n in dataset if str(n).endswith("finite_elements")]
    if away:
        words.append(f"finite elements {100.0 * max(away):.2g} % off the reference")
    limit = float(dataset.attrs["limit"])
    verdict = "pass" if max(largest, *away, 0.0) <= limit else "FAIL"
    return f"{'; '.join(words)}; limit {100.0 * limit:g} %: {verdict}"


def _largest_error(dataset: xr.Dataset, part: str, residual: int, count: int) -> float:
    at = dataset.sel({"residual": residual, f"{part}_modes": count})
    return max(float(np.abs(at[f"{part}_{quantity}_error"]).max()) for quantity in _QUANTITIES)
