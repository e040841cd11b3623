"""Values of the verification report: what a source says, and what is computed here."""

import dataclasses
import json
import math
from collections.abc import Iterable


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
        By the code that runs in the time domain.
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


@dataclasses.dataclass(frozen=True)
class Section:
    """A part of the report; :meth:`row` makes its rows, one per line."""

    title: str

    def row(
        self,
        name: str,
        unit: str,
        reference: float,
        tolerance: float | None,
        computed: float,
        source: str,
        *,
        relative: bool = True,
        remark: str = "",
    ) -> Row:
        """Return a :class:`Row` of this section."""
        return Row(
            section=self.title,
            name=name,
            unit=unit,
            reference=reference,
            source=source,
            tolerance=tolerance,
            computed=float(computed),
            relative=relative,
            remark=remark,
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Curve:
    """A line or points of one of the report's plots.

    Attributes
    ----------
    plot, label
        Title of the plot it belongs to, and its name in the legend.
    x_label, y_label
        The plot's axes, with units.
    x, y
        Coordinates.
    points
        Drawn as single points: references.
    """

    plot: str
    label: str
    x_label: str
    y_label: str
    x: list[float]
    y: list[float]
    points: bool = False


def as_json(rows: Iterable[Row], curves: Iterable[Curve] = ()) -> str:
    """Return rows and curves as JSON; a value that is no finite number becomes ``null``."""
    plain = [dataclasses.asdict(row) for row in rows]
    for row in plain:
        row["computed"] = row["computed"] if math.isfinite(row["computed"]) else None
    lines = [dataclasses.asdict(curve) for curve in curves]
    return json.dumps({"rows": plain, "curves": lines}, allow_nan=False)
