"""Rows of the report: a computed value beside its reference, and the verdict."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any


@dataclasses.dataclass(frozen=True, kw_only=True)
class Row:
    """One value beside its reference.

    Attributes
    ----------
    section
        Part of the report.
    name, unit
        Meaning of the value, and its unit; ``"1"`` for plain numbers.
    reference, source
        The known value, and who says so.
    tolerance
        Largest deviation that passes; ``None`` for a value that is shown and not judged.
    relative
        The tolerance is a share of the reference, not in ``unit``.
    computed
        What this product computes; NaN fails.
    remark
        Why the two differ, where that has a reason.
    """

    section: str
    name: str
    unit: str
    reference: float
    source: str
    tolerance: float | None
    computed: float
    relative: bool = True
    remark: str = ""

    @property
    def limit(self) -> float | None:
        """Largest deviation that passes, in ``unit``."""
        if self.tolerance is None:
            return None
        return self.tolerance * abs(self.reference) if self.relative else self.tolerance

    @property
    def deviation(self) -> float:
        """Computed less reference, in ``unit``."""
        return self.computed - self.reference

    @property
    def verdict(self) -> str:
        """``pass``, ``FAIL``, or empty for a value that is not judged."""
        if self.limit is None:
            return ""
        # Written so that NaN fails; a count with tolerance 0 must be exact.
        return "pass" if abs(self.deviation) <= self.limit else "FAIL"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Curve:
    """A line, or with ``points`` single points, of the plot titled ``plot``."""

    plot: str
    label: str
    x_label: str
    y_label: str
    x: Sequence[float]
    y: Sequence[float]
    points: bool = False


@dataclasses.dataclass(frozen=True, kw_only=True)
class Values:
    """Rows and the curves of their plots."""

    rows: Sequence[Row]
    curves: Sequence[Curve] = ()

    def __add__(self, other: Values) -> Values:
        rows, curves = [*self.rows, *other.rows], [*self.curves, *other.curves]
        return Values(rows=rows, curves=curves)

    @property
    def sections(self) -> dict[str, list[Row]]:
        """Rows by section, in the order in which they came."""
        found: dict[str, list[Row]] = {}
        for row in self.rows:
            found.setdefault(row.section, []).append(row)
        return found

    @property
    def failed(self) -> list[Row]:
        """Rows that fail."""
        return [row for row in self.rows if row.verdict == "FAIL"]

    @property
    def judged(self) -> int:
        """Number of rows with a verdict."""
        return sum(bool(row.verdict) for row in self.rows)


def from_json(content: Mapping[str, Any]) -> Values:
    """Return what a component's ``verification`` module printed; ``null`` becomes NaN."""
    rows = []
    for given in content["rows"]:
        computed = math.nan if given["computed"] is None else given["computed"]
        rows.append(Row(**{**given, "computed": computed}))
    return Values(rows=rows, curves=[Curve(**given) for given in content["curves"]])


def reference_text(row: Row) -> str:
    """Return the reference with the digits it was given with, six at most."""
    return f"{row.reference:.6g}"


def computed_text(row: Row) -> str:
    """Return the computed value with one digit more than the tolerance asks for."""
    value, limit = row.computed, row.limit
    if not math.isfinite(value):
        return "not a number"
    if not limit or row.reference == 0.0:
        return f"{value:.4g}"
    decimals = max(1 - math.floor(math.log10(limit)), 0)
    return f"{value:.{decimals}f}"


def deviation_text(row: Row) -> str:
    """Return the deviation as it is judged: in percent of the reference, or in its unit."""
    if row.deviation == 0.0:
        return "0"
    if row.relative and row.reference:
        return f"{100.0 * row.deviation / abs(row.reference):+.2g} %"
    return f"{row.deviation:+.2g}"


def tolerance_text(row: Row) -> str:
    """Return the tolerance as it is judged."""
    if row.tolerance is None:
        return ""
    return f"{100.0 * row.tolerance:g} %" if row.relative else f"{row.tolerance:g}"
