"""A picture of a sweep: a panel for each quantity, over one axis or two."""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (Matplotlib and xarray are typed in part only.)

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rail_cosim.errors import ParameterError
from rail_cosim.plot import check_format
from rail_cosim.sweeps.assembly import POINT

_FACTS = (
    "error",
    "remarks",
    "distance_travelled",
    "steady",
    "steady_change",
    "window_start",
    "window_stop",
)
_WHEELS = ("wheelset", "side", "bogie")
_CURVES = 7  # at most so many curves in a panel; more are a map
_FLAT = 1e-4  # relative; below this the panel shows a constant
_COLUMNS, _PANEL, _DPI = 2, (4.8, 3.2), 150
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
_PREFIXED = ("N", "Pa")


def check_drawable(axes: Sequence[str]) -> None:
    """Make sure before the runs that a sweep over these axes can be drawn.

    Raises
    ------
    ParameterError
        If it has more than two.
    """
    if len(axes) > 2:
        limit = f"a sweep over {len(axes)} axes ({', '.join(axes)}) is not drawn, only one or two"
        raise ParameterError("--plot", None, limit, "leave it out, and draw sections of the file")


def plot_sweep(
    dataset: xr.Dataset, path: str | Path, *, quantities: Sequence[str] | None = None
) -> None:
    """Draw the quantities of a sweep to a file.

    Over one axis they are curves. Over two they are a family of curves where one axis has up
    to seven values, else a map. Of the wheels (or bogies) the largest value is drawn, of a
    minimum the smallest, of a mean the mean, of a frequency the median. Points that failed
    are gaps.

    Parameters
    ----------
    dataset
        As :func:`rail_cosim.sweep` returns it.
    path
        The picture; its ending says the format (png, pdf, svg).
    quantities
        Variables of ``dataset`` to draw, in their units there; ``None`` for all but the records
        kept by ``[history]``.

    Raises
    ------
    ParameterError
        For another format, more than two axes, or a quantity that the dataset does not have.
    """
    path = Path(path)
    check_format(path)
    sweep_figure(dataset, quantities).savefig(path, dpi=_DPI)


def sweep_figure(dataset: xr.Dataset, quantities: Sequence[str] | None = None) -> Figure:
    """Return the picture of :func:`plot_sweep`."""
    reduced = [_over_wheels(dataset[name], name) for name in _chosen(dataset, quantities)]
    columns = min(_COLUMNS, len(reduced))
    rows = math.ceil(len(reduced) / columns)
    size = (_PANEL[0] * columns, _PANEL[1] * rows)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    for number, (values, words) in enumerate(reduced):
        axes = figure.add_subplot(rows, columns, number + 1)
        axes.set_title(words, loc="left", fontsize="small")
        _panel(figure, axes, values, values.attrs.get("units", ""))
    _legend(figure, _family_label(reduced[0][0]))
    return figure


def _chosen(dataset: xr.Dataset, wanted: Sequence[str] | None) -> list[str]:
    of_points = dataset["error"].dims
    check_drawable([str(d) for d in of_points])
    known = [
        str(name)
        for name, array in dataset.data_vars.items()
        if name not in _FACTS and set(array.dims) <= {*of_points, *_WHEELS}
    ]
    for name in wanted or ():
        if name not in known:
            limit = "the sweep has no such quantity"
            raise ParameterError("quantities", name, limit, "it has " + ", ".join(known))
    found = list(wanted or known)
    if not found:
        raise ParameterError("--plot", None, "no point gave anything to draw")
    return found


def _over_wheels(array: xr.DataArray, name: str) -> tuple[xr.DataArray, str]:
    """Return one value for each point, and of which wheels it is."""
    dims = [d for d in _WHEELS if d in array.dims]
    kind, word = "max", "largest"
    if name.endswith("_min"):
        kind, word = "min", "smallest"
    elif name.endswith("_mean"):
        kind, word = "mean", "mean"
    elif name.endswith("_frequency"):
        kind, word = "median", "median"
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "All-NaN", RuntimeWarning)  # a point that failed
        values = getattr(array, kind)(dims, skipna=True) if dims else array
    what = "bogies" if "bogie" in dims else "wheels"
    title = name.replace("_", " ")
    return values.assign_attrs(array.attrs), f"{title}, {word} of all {what}" if dims else title


def _panel(figure: Figure, axes: Axes, values: xr.DataArray, unit: str) -> None:
    factor, unit = _scale(values.to_numpy(), unit)
    values = values * factor
    if values.dims == (POINT,):
        values = _sorted_points(values)
    lines = list(values.dims)
    if len(lines) == 1:
        _curve(axes, values, str(lines[0]))
        _value_axis(axes, values.to_numpy(), unit)
        return
    family, along = _roles(values)
    if not _numeric(values[family]) or values.sizes[family] <= _CURVES:
        _family(axes, values, along, family)
        _value_axis(axes, values.to_numpy(), unit)
    else:
        _map(figure, axes, values, (along, family), unit)


def _roles(values: xr.DataArray) -> tuple[str, str]:
    """Return which of two axes tells the curves apart, and which they run along."""
    family, along = sorted(values.dims, key=lambda d: (_numeric(values[d]), values.sizes[d]))
    return str(family), str(along)


def _family_label(values: xr.DataArray) -> str:
    return _axis(values[_roles(values)[0]])[1] if len(values.dims) == 2 else ""


def _value_axis(axes: Axes, values: NDArray[np.float64], unit: str) -> None:
    """Label the axis, and do not blow up what is as good as constant."""
    axes.set_ylabel(_shown(unit))
    axes.ticklabel_format(axis="y", useOffset=False)
    found = values[np.isfinite(values)]
    if found.size and np.ptp(found) <= _FLAT * np.abs(found).max():
        middle = float(found.mean())
        half = 0.01 * abs(middle) or 1.0
        axes.set_ylim(middle - half, middle + half)


def _legend(figure: Figure, title: str) -> None:
    """Put one legend below all panels: their families are the same."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    if handles:
        place = "outside lower center"
        legend = figure.legend(handles, labels, loc=place, ncols=len(handles), frameon=False)
        legend.set_title(title)


def _sorted_points(values: xr.DataArray) -> xr.DataArray:
    """Return single points over the one axis of numbers that differs, else over their number."""
    axes = [
        name
        for name, c in values.coords.items()
        if c.dims == (POINT,) and name != POINT and len(set(c.to_numpy().tolist())) > 1
    ]
    if len(axes) == 1 and _numeric(values[axes[0]]):
        return values.swap_dims({POINT: axes[0]}).sortby(axes[0])
    numbers = np.arange(1, values.sizes[POINT] + 1)
    return values.assign_coords({POINT: (POINT, numbers, {"long_name": "point", "units": ""})})


def _numeric(axis: xr.DataArray) -> bool:
    return np.issubdtype(axis.dtype, np.number)


def _curve(axes: Axes, values: xr.DataArray, along: str, **style: object) -> None:
    places, label = _axis(values[along])
    axes.plot(places, values.to_numpy(), marker="o", ms=3.5, lw=1.2, **style)  # type: ignore[arg-type]
    axes.set_xlabel(label)
    axes.grid(visible=True, lw=0.3, color="0.8")


def _family(axes: Axes, values: xr.DataArray, along: str, family: str) -> None:
    members, _ = _axis(values[family])
    colours = colormaps["viridis"](np.linspace(0.0, 0.88, len(members)))
    for number, member in enumerate(members):
        text = member if isinstance(member, str) else f"{member:.6g}"
        _curve(axes, values.isel({family: number}), along, color=colours[number], label=text)


def _map(
    figure: Figure, axes: Axes, values: xr.DataArray, dims: tuple[str, str], unit: str
) -> None:
    across, up = dims
    x, x_label = _axis(values[across])
    y, y_label = _axis(values[up])
    order_x, order_y = np.argsort(x), np.argsort(y)  # a mesh needs rising axes
    cells = values.transpose(up, across).to_numpy()[np.ix_(order_y, order_x)]
    mesh = axes.pcolormesh(
        np.asarray(x)[order_x], np.asarray(y)[order_y], cells, shading="nearest", cmap="viridis"
    )
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    figure.colorbar(mesh, ax=axes, label=_shown(unit))


def _axis(axis: xr.DataArray) -> tuple[list[Any], str]:
    """Return the values of an axis as they are drawn, and its name with the unit."""
    name = str(axis.name)
    if not _numeric(axis):
        return [str(value) for value in axis.to_numpy()], name
    factor, unit = _scale(axis.to_numpy(), axis.attrs.get("units", ""))
    name = name if name != POINT else "number of the point"
    return list(axis.to_numpy() * factor), f"{name} ({_shown(unit)})" if unit not in (
        "",
        "1",
    ) else name


def _shown(unit: str) -> str:
    return unit.replace("m/s2", "m/s²").replace("kg/m3", "kg/m³")


def _scale(values: NDArray[np.float64], unit: str) -> tuple[float, str]:
    """Return a factor and the unit with the prefix for it: MN/m for 40e6 N/m."""
    if not unit.startswith(_PREFIXED) or not np.isfinite(values).any():
        return 1.0, unit
    largest = float(np.nanmax(np.abs(values)))
    for size, prefix in _PREFIXES:
        if largest >= size:
            return 1.0 / size, prefix + unit
    return 1.0, unit
