"""The report as one HTML page that needs no other file."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path
from string import Template

from rail_cosim.errors import ResultsError
from rail_cosim.html import STYLE, made
from rail_cosim.verification.plots import plots
from rail_cosim.verification.rows import (
    Row,
    Values,
    computed_text,
    deviation_text,
    reference_text,
    tolerance_text,
)

_LIBRARIES = ("numpy", "scipy", "fmpy", "pythonfmu")

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>rail-cosim: verification</title>
<style>
$style
td.source { color: #666; font-size: 12.5px; min-width: 18em; }
.pass { color: #00714f; } .FAIL { color: #b00000; font-weight: 700; }
tr.FAIL { background: #fdeaea; }
figure { margin: 2em 0; } figure img { max-width: 100%; }
</style>
</head>
<body>
<h1>Verification</h1>
<p class="$state">$result</p>
<p>Values of the track and of the vehicle come from the functions that the time domain uses;
coupled ones from runs of both FMUs. A value without verdict is shown for comparison.</p>
$sections
<h2>Plots</h2>
$pictures
<footer>$made</footer>
</body>
</html>
""")
_HEADS = ("", "unit", "reference", "computed", "deviation", "tolerance", "", "source")


def write_page(values: Values, path: Path, command: str) -> None:
    """Write the page.

    Raises
    ------
    ResultsError
        If it cannot be written.
    """
    try:
        path.write_text(page(values, command), encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written ({error.strerror})") from error


def page(values: Values, command: str) -> str:
    """Return the page as text."""
    failed = len(values.failed)
    result = f"{values.judged - failed} of {values.judged} values pass"
    sections = "\n".join(_section(title, rows) for title, rows in values.sections.items())
    pictures = "\n".join(_picture(title, png) for title, png in plots(values).items())
    return _PAGE.substitute(
        state="FAIL" if failed else "pass",
        result=result + (f", {failed} fail" if failed else ""),
        sections=sections,
        pictures=pictures,
        style=STYLE,
        made=escape(made(command, _LIBRARIES)),
    )


def _section(title: str, rows: list[Row]) -> str:
    heads = "".join(f"<th>{head}</th>" for head in _HEADS)
    body = "\n".join(_row(row) for row in rows)
    return f"<h2>{escape(title)}</h2>\n<table>\n<tr>{heads}</tr>\n{body}\n</table>"


def _row(row: Row) -> str:
    verdict = row.verdict
    numbers = [reference_text(row), computed_text(row)]
    numbers += [deviation_text(row), tolerance_text(row)]
    source = escape(row.source) + (f"; <em>{escape(row.remark)}</em>" if row.remark else "")
    return (
        f'<tr class="{verdict}"><td>{escape(row.name)}</td>'
        f"<td>{'' if row.unit == '1' else escape(row.unit)}</td>"
        + "".join(f'<td class="number">{escape(text)}</td>' for text in numbers)
        + f'<td class="{verdict}">{verdict}</td><td class="source">{source}</td></tr>'
    )


def _picture(title: str, png: bytes) -> str:
    data = base64.b64encode(png).decode("ascii")
    return (
        f"<figure><figcaption>{escape(title)}</figcaption>"
        f'<img src="data:image/png;base64,{data}" alt="{escape(title)}"></figure>'
    )
