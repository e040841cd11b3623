"""The points' results as one labelled Dataset."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence

import numpy as np
import xarray as xr

from rail_cosim import version
from rail_cosim.sweeps.plan import Plan
from rail_cosim.sweeps.point import PointResult
from rail_cosim.window import ATTRIBUTE

POINT = "point"


def assemble(plan: Plan, results: Sequence[PointResult]) -> xr.Dataset:
    """Return quantities over the axes of a sweep; NaN at points that failed.

    Parameters
    ----------
    plan
        The sweep.
    results
        In the order of the plan's tasks.

    Returns
    -------
    xarray.Dataset
        Dimensions are the axes of a grid, or ``point`` with the axes as coordinates; then
        those of the quantities. Statistics have the attribute ``evaluation_window``, points
        ``window_start`` and ``window_stop`` (m). ``error`` says why a point failed.
    """
    specification = plan.specification
    dimensions = specification.axes if specification.grid else (POINT,)
    shape = specification.shape
    joined = xr.Dataset()
    for name, template in _templates(results).items():
        sizes = _sizes(results, template)
        values = np.full((len(results), *sizes), np.nan)
        for row, result in enumerate(results):
            if name in result.data:
                found = result.data[name].transpose(*template.dims).to_numpy()
                values[(row, *(slice(n) for n in found.shape))] = found
        whole = values.reshape(*shape, *sizes)
        about = template.attrs | _windows(results, name)
        joined[name] = ((*dimensions, *template.dims), whole, about)
    joined = joined.assign_coords(_coordinates(results))
    remarks = ["\n".join(result.remarks) for result in results]
    for name, texts, meaning in (
        ("error", [r.error for r in results], "why the point failed, empty if it did not"),
        ("remarks", remarks, "warnings of the FMUs, events outside the evaluation window"),
    ):
        array = np.array(texts, dtype=object).reshape(shape)
        joined[name] = (dimensions, array, {"long_name": meaning})
    return joined.assign_coords(_axes(plan)).assign_attrs(_attributes(plan))


def _templates(results: Sequence[PointResult]) -> dict[str, xr.DataArray]:
    found: dict[str, xr.DataArray] = {}
    for result in results:
        for name, array in result.data.data_vars.items():
            found.setdefault(str(name), array)
    return found


def _windows(results: Sequence[PointResult], name: str) -> dict[str, str]:
    """Return over what a statistic was evaluated, if it is one; all windows if they differ."""
    attributes = [result.data[name].attrs for result in results if name in result.data]
    texts = [about[ATTRIBUTE] for about in attributes if ATTRIBUTE in about]
    return {ATTRIBUTE: " or ".join(dict.fromkeys(texts))} if texts else {}


def _sizes(results: Sequence[PointResult], template: xr.DataArray) -> tuple[int, ...]:
    return tuple(max(result.data.sizes.get(str(d), 0) for result in results) for d in template.dims)


def _coordinates(results: Sequence[PointResult]) -> dict[str, xr.DataArray]:
    """Return coordinates of the quantities' own dimensions, each from where it is longest."""
    found: dict[str, xr.DataArray] = {}
    for result in results:
        for name, array in result.data.coords.items():
            if str(name) not in found or array.size > found[str(name)].size:
                found[str(name)] = array
    return found


def _axes(plan: Plan) -> dict[str, tuple]:
    specification = plan.specification
    points = specification.all_points()
    axes: dict[str, tuple] = {}
    for axis, (unit, meaning) in plan.about.items():
        grid = bool(specification.grid)
        values = specification.grid[axis] if grid else [point[axis] for point in points]
        about = {"units": unit, "long_name": meaning}
        axes[axis] = (axis if grid else POINT, _array(values), about)
    return axes


def _array(values: Sequence) -> np.ndarray:
    """Return values as an array of one type that NetCDF has."""
    if all(isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.int8)
    if any(isinstance(value, str) for value in values):
        return np.array([str(value) for value in values], dtype=object)
    whole = all(isinstance(value, int) for value in values)
    return np.array(values, dtype=np.int64 if whole else float)


def _attributes(plan: Plan) -> dict[str, str]:
    specification = plan.specification
    fmus = {
        f"{name}_fmu": f"{file.name} {file.identity}" for name, file in plan.tasks[0].fmus.items()
    }
    return {
        "title": "Parameter sweep of a railway vehicle on slab track",
        "source": f"rail-cosim {version()}",
        "python_version": platform.python_version(),
        "run": json.dumps(dict(specification.run), default=str),
        "settings": json.dumps(dict(specification.settings)),
        **fmus,
    }
