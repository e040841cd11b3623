"""Documents made from the table of variables."""

import html
from collections.abc import Iterable, Mapping

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


_HOSTS = (
    "A host that is Python uses its own interpreter. Any other host on Linux is started with "
    "LD_PRELOAD=.../libpython3.x.so.1.0, and PYTHONHOME or PYTHONPATH must lead to the libraries; "
    "on Windows the folder of python3.dll is on the PATH. The path to which the FMU is extracted "
    "must not need percent-encoding; spaces are fine."
)
_ERRORS = (
    "A parameter that is refused ends fmi2ExitInitializationMode with fmi2Fatal, a step that "
    "fails ends fmi2DoStep so; outputs are then not-a-number. The reason is in the log, on stderr "
    "if the host has logging off, and in the variable status.message."
)


def general_guide(python: str, requirements: Iterable[str]) -> dict[str, str]:
    """Return the sections of the documentation that all FMUs have, text by heading.

    Parameters
    ----------
    python
        The oldest version of Python.
    requirements
        Libraries that must be installed.
    """
    needed = f"Python {python} or newer, with {', '.join(requirements)}. {_HOSTS}"
    return {"Requirements": needed, "Errors": _ERRORS}


def documentation_page(
    title: str, description: str, guide: Mapping[str, str], variables: Iterable[Variable]
) -> str:
    """Return the FMU's ``documentation/index.html``: what it is, what to know, the table."""
    rows = []
    for variable in variables:
        cells = "".join(f"<td>{html.escape(cell.strip('`'))}</td>" for cell in _row(variable))
        rows.append(f"<tr>{cells}</tr>")
    head = "".join(f"<th>{column}</th>" for column in _COLUMNS)
    sections = "".join(
        f"<h2>{html.escape(heading)}</h2>\n<p>{html.escape(text)}</p>\n"
        for heading, text in guide.items()
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title></head><body>\n"
        f"<h1>{html.escape(title)}</h1>\n<p>{html.escape(description)}</p>\n{sections}"
        f"<h2>Variables</h2>\n<table>\n<tr>{head}</tr>\n"
        + "\n".join(rows)
        + "\n</table>\n</body></html>\n"
    )
