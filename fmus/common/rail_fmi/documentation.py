"""Documents made from the table of variables."""

import html
from collections.abc import Iterable

from rail_fmi.variables import Variable

_COLUMNS = ("name", "causality", "type", "unit", "start", "limits", "description")


def _row(variable: Variable) -> tuple[str, ...]:
    has_start = variable.settable
    start = f"{variable.start:g}" if variable.kind == "real" else str(variable.start)
    return (
        f"`{variable.name}`",
        variable.causality
        if variable.variability != "tunable"
        else f"tunable {variable.causality}",
        variable.kind,
        "" if variable.unit == "1" else variable.unit,
        start if has_start else "",
        variable.limits,
        variable.description,
    )


def documentation_table(variables: Iterable[Variable]) -> str:
    """Return a Markdown table of the variables, one line each, in their order."""
    lines = ["| " + " | ".join(_COLUMNS) + " |", "|" + "---|" * len(_COLUMNS)]
    for variable in variables:
        cells = (cell.replace("|", "\\|").replace("\n", " ") for cell in _row(variable))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def documentation_page(title: str, description: str, variables: Iterable[Variable]) -> str:
    """Return the FMU's ``documentation/index.html``: what it is and the table."""
    rows = []
    for variable in variables:
        cells = "".join(f"<td>{html.escape(cell.strip('`'))}</td>" for cell in _row(variable))
        rows.append(f"<tr>{cells}</tr>")
    head = "".join(f"<th>{column}</th>" for column in _COLUMNS)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title></head><body>\n"
        f"<h1>{html.escape(title)}</h1>\n<p>{html.escape(description)}</p>\n"
        f"<table>\n<tr>{head}</tr>\n" + "\n".join(rows) + "\n</table>\n</body></html>\n"
    )
