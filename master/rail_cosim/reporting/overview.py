"""Section with the extremes of the whole run and what happened outside the evaluation window."""

from __future__ import annotations

import numpy as np

from rail_cosim.presentation import channels
from rail_cosim.reporting.sections import MissingError, Section, Table, number
from rail_cosim.summary import Summary

COLUMNS = (
    ("wheel_force_max", "wheel force, max (kN)", 1e-3),
    ("wheel_force_max_distance", "at (m)", 1.0),
    ("wheel_force_min", "min (kN)", 1e-3),
    ("wheel_force_min_distance", "at (m)", 1.0),
    ("axle_box_acceleration_peak", "peak axle-box acceleration (m/s²)", 1.0),
    ("axle_box_acceleration_peak_distance", "at (m)", 1.0),
    ("loss_of_contact_count", "losses of contact", 1.0),
    ("loss_of_contact_longest", "longest (ms)", 1e3),
    ("loss_of_contact_total", "total (ms)", 1e3),
)


def overview(summary: Summary) -> Section:
    """Return the section."""
    section = Section(
        title="Summary",
        intro="Extremes are those of all records of the run, at the distance travelled by the "
        "leading wheelset.",
        remarks=[
            f"Evaluation window of statistics and spectra: {summary.window.text}, {summary.state}."
        ],
    )
    if summary.events:
        section.remarks.append("Outside the evaluation window: " + "; ".join(summary.events) + ".")
    section.add(lambda: _extremes(summary))
    return section


def _extremes(summary: Summary) -> Table:
    columns = [one for one in COLUMNS if one[0] in summary.data]
    if not columns:
        raise MissingError("wheel forces and axle-box accelerations: not recorded")
    rows = [[one.name] for one in channels(summary[columns[0][0]])]
    for name, _, factor in columns:
        values = summary[name].to_numpy().ravel() * factor
        for row, value in zip(rows, np.asarray(values, float), strict=True):
            row.append(f"{value:.2f}" if name.endswith("_distance") else number(float(value)))
    caption = f"Whole run, {summary.whole.text}"
    return Table(heads=["wheel", *(head for _, head, _ in columns)], rows=rows, caption=caption)
