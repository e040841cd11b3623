"""P2 resonance: the article's formula, and the mode of wheelset and track together."""

import math

import numpy as np
from rail_quantities import with_values
from rail_quantities.comparison import Row, Section

from slab_track.frequency import (
    WHEELSET_ON_PRIMARY,
    CoupledSystem,
    Wheelset,
    middle,
    p2_formula,
    resonance_speed,
)
from slab_track.parameters import TrackParameters
from slab_track.presets import HD

_SECTION = Section("P2 resonance")
_TEXT_BAY = 0.60
_KMH = 3.6
_HALF = 0.5 * WHEELSET_ON_PRIMARY.mass

_ARTICLE = {40e6: (51.4, 50.5, 116.4), 140e6: (83.1, 81.6, 188.2)}
"""By pad stiffness: frequency with a bay of 0.60 m and of 0.629 m, Hz; speed, km/h."""
_INDEPENDENT = {40e6: 110.47, 140e6: 160.06, 200e6: 175.71}
"""Speed in km/h at which a wheel on the finite-element track has its largest acceleration."""

_TEXT = "the article's section 3.1.2; its figures follow from (12)-(16) with l_0 = 0.60 m"
_TABLE_2 = "(12)-(16) of the article with l_0 = 0.629 m of Table 2, evaluated apart"
_SPEED = "the article's section 3.1.2: frequency with 0.60 m, way with 0.629 m"
_RIGID = "(12)-(16) of the article, which has a rigid base, a rigid contact and no shear"
_TRACK = (
    "speed of the largest axle-box acceleration of a single wheel in the independent "
    "finite-element model of the test suite"
)
_DAMPED = "the peak of a damped response is not exactly at the natural frequency"
_SOFTER = "slabs, shear and Hertz springs make the track softer than the formula's; not judged"


def p2_rows() -> list[Row]:
    """Return formula and coupled modes."""
    row, rows = _SECTION.row, []
    for pad, (text, table_2, speed) in _ARTICLE.items():
        line, label = _line(pad), f"{1e-6 * pad:g} MN/m"
        short = p2_formula(line, _HALF, spacing=_TEXT_BAY).frequency
        own = p2_formula(line, _HALF).frequency
        passing = _KMH * resonance_speed(short, HD.fastener.spacing)
        rows += [
            row(f"formula, {label}, 0.600 m", "Hz", text, 0.06, short, _TEXT, relative=False),
            row(f"formula, {label}, 0.629 m", "Hz", table_2, 0.06, own, _TABLE_2, relative=False),
            row(f"resonance speed, {label}", "km/h", speed, 2e-3, passing, _SPEED),
        ]
    rigid = with_values(
        HD, {"slab_support.vertical_stiffness": 1e16, "fastener.vertical_damping": 0.0}
    )
    found = _coupled(rigid, Wheelset(), contact_stiffness=math.inf)
    rows.append(row("coupled mode, rigid slabs and contact", "Hz", 50.5, 0.03, found, _RIGID))
    for pad, (_, table_2, _) in _ARTICLE.items():
        name = f"coupled mode with primary suspension, {1e-6 * pad:g} MN/m"
        found = _coupled(_line(pad), WHEELSET_ON_PRIMARY)
        rows.append(row(name, "Hz", table_2, None, found, _TABLE_2, remark=_SOFTER))
    for pad, speed in _INDEPENDENT.items():
        frequency = _coupled(_line(pad), Wheelset())
        found = _KMH * resonance_speed(frequency, HD.fastener.spacing)
        name = f"coupled mode of a wheel alone as speed, {1e-6 * pad:g} MN/m"
        rows.append(row(name, "km/h", speed, 0.02, found, _TRACK, remark=_DAMPED))
    return rows


def _line(pad: float) -> TrackParameters:
    return with_values(HD, {"fastener.vertical_stiffness": pad})


def _coupled(
    line: TrackParameters, wheelset: Wheelset, contact_stiffness: float | None = None
) -> float:
    """Return the natural frequency in Hz, mean of mid-bay and over a fastener."""
    found = []
    for place in middle(line):
        at = np.array([place])
        system = CoupledSystem(line, wheelset, at, contact_stiffness=contact_stiffness)
        ((eigenvalue, _),) = system.eigenvalues()
        found.append(abs(eigenvalue) / (2.0 * math.pi))
    return sum(found) / len(found)
