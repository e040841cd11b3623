"""What a section of the report contains, and how it says what is missing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import xarray as xr

from rail_cosim.errors import RailCosimError


class MissingError(RailCosimError):
    """Something that a section or a chart is made of is not in the run."""


@dataclasses.dataclass(kw_only=True)
class Table:
    """A table.

    Attributes
    ----------
    heads
        Of the columns; the first one is text, the others are numbers where ``numeric``.
    rows
        Cells as text.
    caption
        Above it.
    numeric
        Whether all columns but the first stand to the right.
    """

    heads: list[str]
    rows: list[list[str]]
    caption: str = ""
    numeric: bool = True


@dataclasses.dataclass(kw_only=True)
class Figure:
    """A chart (see :mod:`rail_cosim.reporting.charts`), or a drawing as SVG, and its title."""

    title: str
    chart: dict[str, Any] | None = None
    svg: str = ""


@dataclasses.dataclass(kw_only=True)
class Section:
    """A part of the report.

    Attributes
    ----------
    title, intro, remarks
        In words; remarks are set off.
    parts
        Tables and figures.
    missing
        What could not be shown, and why.
    folded
        Whether it is closed until it is clicked.
    """

    title: str
    intro: str = ""
    remarks: list[str] = dataclasses.field(default_factory=list)
    parts: list[Table | Figure] = dataclasses.field(default_factory=list)
    missing: list[str] = dataclasses.field(default_factory=list)
    folded: bool = False

    def add(self, make: Callable[[], Table | Figure | Iterable[Table | Figure]]) -> None:
        """Add what ``make`` returns, or the reason why it cannot."""
        try:
            made = make()
        except RailCosimError as error:
            self.missing.append(str(error))
            return
        self.parts += [made] if isinstance(made, Table | Figure) else list(made)


def need(run: xr.Dataset, *names: str) -> xr.DataArray:
    """Return the first of these variables that the run has.

    Raises
    ------
    MissingError
        If it has none of them, or nothing but values that are not a number.
    """
    for name in names:
        if name in run and bool(run[name].notnull().any()):
            return run[name]
    raise MissingError(f"{' or '.join(names)}: not among the outputs of this run's FMUs")


def number(value: float, digits: int = 4) -> str:
    """Return a number in a table; a dash for none."""
    return "–" if value != value else f"{value:.{digits}g}"


def text(value: object) -> str:
    """Return an attribute of a run in a table; a dash for none."""
    if isinstance(value, float | np.floating):
        return f"{float(value):.8g}"
    return "–" if value is None or value == "" else str(value)
