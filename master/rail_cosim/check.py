"""Whether an FMU, whoever made it, can be the vehicle or the track of a run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from rail_cosim.archives import opened
from rail_cosim.contract import Finding, Role, contract_findings, terminal_numbers
from rail_cosim.description import FmuDescription, read_root
from rail_cosim.manners import manners_findings
from rail_cosim.name_map import described
from rail_cosim.trial import trial_findings


@dataclasses.dataclass(frozen=True, kw_only=True)
class CheckReport:
    """What :func:`check_fmu` found.

    Attributes
    ----------
    description
        The FMU.
    role
        What it is by its terminals; ``None`` for neither.
    wheelsets
        Number of its terminals.
    contract, manners
        Findings about the contract of vehicle and track, and about FMI itself.
    trial
        Faults in a short run, empty if there was none.
    """

    description: FmuDescription
    role: Role | None
    wheelsets: int
    contract: Sequence[Finding]
    manners: Sequence[Finding]
    trial: Sequence[Finding] = ()

    @property
    def parts(self) -> dict[str, Sequence[Finding]]:
        """All findings by what they are about."""
        return {"contract": self.contract, "FMI": self.manners, "run": self.trial}

    @property
    def faults(self) -> list[Finding]:
        """What makes the FMU fail."""
        return [f for found in self.parts.values() for f in found if f.level == "fault"]

    @property
    def passed(self) -> bool:
        """Whether there is no fault."""
        return not self.faults


def check_fmu(path: Path, *, run: bool = False, names: Path | None = None) -> CheckReport:
    """Check an FMU's description against the contract and against FMI 2.0.

    Unless ``run`` is asked for nothing is loaded, and nothing said about values
    (see :mod:`rail_cosim.trial`). ``names`` is a file that maps its names to those of the
    contract (see :mod:`rail_cosim.name_map`).

    Raises
    ------
    FmuFileError
        If the file is no FMI 2.0 co-simulation FMU.
    ParameterError
        If the name map cannot be used.
    """
    description = described(path, names)
    role, contract = contract_findings(description.variables)
    if role is not None and not description.can_save_state:
        text = "absent: the algorithm iterative-gauss-seidel cannot be used"
        contract = [*contract, Finding(level="note", subject="canGetAndSetFMUstate", text=text)]
    with opened(path) as archive:
        members = set(archive.namelist())
    return CheckReport(
        description=description,
        role=role,
        wheelsets=len(terminal_numbers(description.variables)),
        contract=contract,
        manners=manners_findings(read_root(path), members),
        trial=trial_findings(path, names) if run else (),
    )


def check_table(report: CheckReport) -> Table:
    """Return the findings as a table: equal ones on the same member in one row."""
    title = f"{report.description.path.name}: {report.description.model_name}"
    table = Table(title=Text(title), title_justify="left", title_style="")
    for head in ("", "about", "finding"):
        table.add_column(head, overflow="fold")
    for part, findings in report.parts.items():
        for level in ("fault", "note"):
            rows: dict[str, list[str]] = {}
            for finding in findings:
                if finding.level == level:
                    rows.setdefault(finding.text, []).append(finding.subject)
            for text, subjects in rows.items():
                table.add_row(f"{part} {level}", Text(_listed(subjects)), Text(text))
    return table


def _listed(subjects: Sequence[str]) -> str:
    shown = ", ".join(subjects[:4])
    return shown + (f" and {len(subjects) - 4} more" if len(subjects) > 4 else "")


def verdict(report: CheckReport) -> str:
    """Return the outcome in a sentence."""
    name, faults = report.description.path.name, len(report.faults)
    if report.role is None:
        return f"{name} is neither a vehicle nor a track: it does not satisfy the contract"
    plural = "" if report.wheelsets == 1 else "s"
    what = f"{name} is a {report.role} with {report.wheelsets} wheelset{plural}"
    if faults:
        have = "1 fault" if faults == 1 else f"{faults} faults"
        return f"{what}, but does not satisfy the contract: {have}"
    return f"{what} and satisfies the contract"
