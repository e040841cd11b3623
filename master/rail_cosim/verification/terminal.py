"""The report on the terminal."""

from __future__ import annotations

from rich.table import Table

from rail_cosim.verification.rows import (
    Row,
    Values,
    computed_text,
    deviation_text,
    reference_text,
    tolerance_text,
)

_STYLES = {"pass": "green", "FAIL": "bold red", "": ""}


def section_table(title: str, rows: list[Row]) -> Table:
    """Return one section; sources are on the page."""
    table = Table(title=title, title_justify="left", title_style="bold")
    table.add_column("", overflow="fold")
    for head in ("unit", "reference", "computed", "deviation", "tolerance", ""):
        table.add_column(head, justify="left" if head in ("unit", "") else "right", no_wrap=True)
    for row in rows:
        verdict = row.verdict
        cells = [reference_text(row), computed_text(row)]
        cells += [deviation_text(row), tolerance_text(row)]
        style = _STYLES[verdict]
        shown = f"[{style}]{verdict}[/]" if style else verdict
        unit = "" if row.unit == "1" else row.unit
        table.add_row(row.name, unit, *cells, shown)
    return table


def conclude(values: Values) -> str:
    """Return the result in a sentence, with the names of what fails."""
    shown = len(values.rows) - values.judged
    text = f"{values.judged - len(values.failed)} of {values.judged} values pass"
    text += f"; {shown} more are shown and not judged" if shown else ""
    return text + "".join(f"\nFAIL: {row.section}: {row.name}" for row in values.failed)
