"""Contact: Hertz, Kalker's coefficients, FASTSIM, conicity."""

from typing import Any

import numpy as np
from rail_quantities import with_values
from rail_quantities.comparison import Curve, Row, Section
from scipy.optimize import root_scalar

from slab_track.contact import (
    ContactGeometry,
    HertzContact,
    RailPlacement,
    contact_table,
    equivalent_conicity,
    fastsim,
    hertz_contact,
    kalker_coefficients,
    load_profile,
)
from slab_track.contact.hertz import axis_ratio, contact_modulus
from slab_track.contact.solve import hertz_force
from slab_track.frequency import hertz_stiffness
from slab_track.presets import HD
from slab_track.verification.kalker_table import POISSON_RATIOS, kalker_table

_SECTION = Section("Contact")
_ZHAI = "eq. (1) of the article with G = {} m/N^(2/3) (Zhai), evaluated apart"
_CONTACT = "CONTACT, half-space: A = 0.8 /m, a/b = 0.5, N = 106.7 kN, G = 82 GPa, nu = 0.28"
_KALKER = "Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990, Table E.3"
_CLOSED = (
    "closed form of the simplified theory (Kalker, Vehicle System Dynamics 11, 1982), parabolic "
    "traction bound"
)
_PLOT = "Creep curve of FASTSIM, pure longitudinal creepage"

_SHEAR, _NU, _LOAD, _CURVATURE, _RATIO = 82e9, 0.28, 106.7e3, 0.8, 0.5
_FRICTION = 0.33
_SHARES = {
    0.25: 0.22899,
    0.5: 0.41867,
    1.0: 0.69620,
    1.5: 0.86423,
    2.0: 0.95288,
    3.0: 0.99941,
}
"""F/(mu N) by tau = G a b C11 xi / (mu N)."""
_CREEP_CURVE = {0.4e-3: 0.2588, 1.2e-3: 0.6482, 2.0e-3: 0.8816, 3.6e-3: 0.9991}
"""F/(mu N) of CONTACT by creepage."""
_CONTACT_FASTSIM = (0.2577, 0.6281, 0.8433, 0.9915)
"""What its FASTSIM gives, with cells that hold adhesion and slip."""


def contact_rows() -> list[Row]:
    """Return all rows of the contact."""
    return [*_vertical(), *_ellipse(), _coefficients(), *_fastsim(), _conicity()]


def contact_curves() -> list[Curve]:
    """Return FASTSIM's creep curve, its closed form and the points of CONTACT."""
    ellipse = _contact_ellipse()
    axes: dict[str, Any] = {"plot": _PLOT, "x_label": "creepage (0.001)", "y_label": "F / (mu N)"}
    taus = np.linspace(0.0, 3.6, 73)
    per_tau = 1e3 * _creepage(1.0, ellipse)
    creepages = list(_CREEP_CURVE)
    return [
        Curve(
            **axes,
            label=f"FASTSIM, {HD.contact.fastsim_columns} x {HD.contact.fastsim_strips} cells",
            x=(per_tau * taus).tolist(),
            y=[_share(_creepage(tau, ellipse), ellipse) for tau in taus],
        ),
        Curve(
            **axes,
            label="closed form",
            x=[per_tau * tau for tau in _SHARES],
            y=list(_SHARES.values()),
            points=True,
        ),
        Curve(
            **axes,
            label="CONTACT",
            x=[1e3 * xi for xi in creepages],
            y=[_CREEP_CURVE[xi] for xi in creepages],
            points=True,
        ),
    ]


def _vertical() -> list[Row]:
    """Eq. (1) under the static load, for a worn and a coned tread."""
    row, load = _SECTION.row, HD.static_wheel_load
    balance = "(44039 + 2 x 2439 + 4 x 1881) kg x 9.81 m/s2 / 8, Table 2 of the article"
    rows = [row("static wheel load", "kN", 69.21, 1e-4, 1e-3 * load, balance)]
    coned = with_values(HD, {"contact.hertz_constant": 5.131e-8})
    for tread, track, constant, micrometres, stiffness in (
        ("worn", HD, "3.86e-8 R^-0.115", 71.1, 1.459),
        ("coned", coned, "4.57e-8 R^-0.149", 86.5, 1.200),
    ):
        source = _ZHAI.format(constant)
        depth = 1e6 * _penetration(load, track.contact.hertz_constant_used)
        rows.append(row(f"penetration, {tread} tread", "um", micrometres, 1e-3, depth, source))
        found = 1e-9 * hertz_stiffness(track)
        rows.append(
            row(f"linearised stiffness, {tread} tread", "GN/m", stiffness, 1e-3, found, source)
        )
    return rows


def _penetration(load: float, constant: float) -> float:
    """Return the penetration in m at which the contact of the time step carries ``load`` N."""
    return float(root_scalar(lambda d: hertz_force(d, constant) - load, bracket=(0.0, 1e-3)).root)


def _contact_ellipse() -> HertzContact:
    """Return the ellipse of CONTACT's example, its lateral curvature from a/b."""
    across = root_scalar(lambda b: axis_ratio(_CURVATURE, b) - _RATIO, bracket=(1e-3, _CURVATURE))
    modulus = contact_modulus(2.0 * _SHEAR * (1.0 + _NU), _NU)
    return hertz_contact(_LOAD, _CURVATURE, float(across.root), modulus)


def _ellipse() -> list[Row]:
    found = _contact_ellipse()
    return [
        _SECTION.row(name, unit, known, tolerance, value, _CONTACT)
        for name, unit, known, tolerance, value in (
            ("semi-axis a of the ellipse", "mm", 6.304, 3e-4, 1e3 * found.semi_axis_a),
            ("semi-axis b of the ellipse", "mm", 12.61, 5e-4, 1e3 * found.semi_axis_b),
            ("approach of the bodies", "um", 76.51, 3e-4, 1e6 * found.approach),
            ("largest pressure", "MPa", 640.7, 1e-3, 1e-6 * found.peak_pressure),
        )
    ]


def _coefficients() -> Row:
    """Largest relative deviation from all 171 values of Kalker's table."""
    table, largest = kalker_table(), 0.0
    for ratio, printed in zip(table.axis_ratio, table.coefficients, strict=True):
        for nu, values in zip(POISSON_RATIOS, printed, strict=True):
            found = kalker_coefficients(float(ratio), nu)
            largest = max(largest, float(np.abs(found / values - 1.0).max()))
    name = f"Kalker's coefficients, largest deviation of {table.coefficients.size} values"
    return _SECTION.row(name, "1", 0.0, 1e-6, largest, _KALKER, relative=False)


def _fastsim() -> list[Row]:
    ellipse = _contact_ellipse()
    rows = []
    for tau, known in _SHARES.items():
        found = _share(_creepage(tau, ellipse), ellipse)
        rows.append(
            _SECTION.row(f"FASTSIM, F/(mu N) at tau = {tau:g}", "1", known, 0.01, found, _CLOSED)
        )
    for (creepage, known), own in zip(_CREEP_CURVE.items(), _CONTACT_FASTSIM, strict=True):
        name = f"creep curve, F/(mu N) at xi = {1e3 * creepage:g}e-3"
        remark = f"the simplified theory differs by so much; FASTSIM within CONTACT: {own:g}"
        found = _share(creepage, ellipse)
        rows.append(
            _SECTION.row(name, "1", known, 0.06, found, f"{_CONTACT}, mu = 0.33", remark=remark)
        )
    return rows


def _creepage(tau: float, ellipse: HertzContact) -> float:
    a, b = ellipse.semi_axis_a, ellipse.semi_axis_b
    return float(tau * _FRICTION * _LOAD / (_SHEAR * a * b * kalker_coefficients(a / b, _NU)[0]))


def _share(creepage: float, ellipse: HertzContact) -> float:
    """Return F/(mu N) on the grid of the time domain."""
    a, b = ellipse.semi_axis_a, ellipse.semi_axis_b
    c11, c22, c23 = kalker_coefficients(a / b, _NU)
    columns, strips = HD.contact.fastsim_columns, HD.contact.fastsim_strips
    force = fastsim(
        _LOAD, a, b, c11, c22, c23, _SHEAR, _FRICTION, creepage, 0.0, 0.0, columns, strips
    )
    return -force[0] / (_FRICTION * _LOAD)


def _conicity() -> Row:
    """Equivalent conicity of new profiles, rigid contact points."""
    geometry = ContactGeometry(
        load_profile("wheel", "S1002"),
        load_profile("rail", "60E1"),
        RailPlacement(rolling_circle_distance=1.5),
        reference_penetration=1e-6,
        spacing=2e-5,
    )
    lateral = np.linspace(-4e-3, 4e-3, 33)
    radii = contact_table(geometry, lateral).rolling_radius_difference
    found = equivalent_conicity(lateral, radii, amplitude=3e-3)
    usual = (
        "usual statement for new profiles, 0.17 to 0.18: gauge 1435 mm, 1:40, 1360 mm between "
        "wheels, 3 mm (UIC 519, EN 15302)"
    )
    return _SECTION.row(
        "equivalent conicity, S1002 on 60E1", "1", 0.175, 0.005, found, usual, relative=False
    )
