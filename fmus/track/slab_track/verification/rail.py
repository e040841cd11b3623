"""Rail: modes, statics and waves of a Timoshenko beam with the data of Table 2."""

import math
from typing import Any

import numpy as np
from rail_quantities import with_values
from rail_quantities.comparison import Curve, Row, Section

from slab_track.assembly import SYMMETRIC, assemble
from slab_track.frequency import pinned_pinned_frequency
from slab_track.parameters import TrackParameters
from slab_track.presets import HD
from slab_track.rail import RailModes, vertical_modes
from slab_track.statics import static_coordinates

_SECTION = Section("Rail")
LENGTH = 65.416
"""13 slabs of the HD line, m."""

_BEAM = "closed form of the hinged Timoshenko beam, eqs. (6a), (6b) of the article, Table 2"
_MODES = {1: 0.1211, 10: 12.0743, 50: 283.68, 100: 977.27, 200: 2787.25}
_SUPPORT = "closed form: beam on a Winkler foundation, 40 MN/m each 0.629 m, 69.21 kN"
_LOAD = 69.21e3
_BAY = 0.1
"""Bay in m at which fasteners are as good as a continuous support."""
_EULER_SHEAR = 7.9e14
"""Shear modulus in Pa of a rail as good as rigid in shear."""
_MODE_PLOT = "Modes of the hinged rail"


def rail_rows() -> list[Row]:
    """Return modes, deflections, critical speeds and pinned-pinned frequencies."""
    modes = vertical_modes(HD.rail, LENGTH)
    hertz = np.sqrt(modes.omega_squared) / (2.0 * math.pi)
    rows = [
        _SECTION.row(
            f"hinged rail of {LENGTH:g} m, mode {k}", "Hz", known, 5e-4, hertz[0, k - 1], _BEAM
        )
        for k, known in _MODES.items()
    ]
    cut_off = "closed form: shear mode of the Timoshenko beam, sqrt(kappa G A / (rho I))"
    rows.append(_SECTION.row("start of the shear branch", "Hz", 5715.0, 1e-4, hertz[1, 0], cut_off))
    for theory, shear, millimetres in (
        ("Euler", _EULER_SHEAR, 0.6773),
        ("Timoshenko", HD.rail.shear_modulus, 0.7089),
    ):
        found, name = 1e3 * _winkler_deflection(shear), f"point load, {theory} rail, rigid slabs"
        rows.append(_SECTION.row(name, "mm", millimetres, 1e-3, found, _SUPPORT))
    waves = "closed form: least phase speed in a Timoshenko beam on a Winkler foundation"
    rows.append(_SECTION.row("critical speed", "m/s", 803.0, 1e-3, critical_speed(HD), waves))
    pinned = "first root of (6a), (6b) of the article at the wave number pi/l_0"
    for bay, known in ((0.629, 1042.8), (0.600, 1126.7)):
        found = pinned_pinned_frequency(with_values(HD, {"fastener.spacing": bay}))
        rows.append(
            _SECTION.row(f"pinned-pinned, bay {bay:.3f} m", "Hz", known, 1e-4, found, pinned)
        )
    return rows


def rail_curves() -> list[Curve]:
    """Return frequency over mode number, and the references on it."""
    modes = vertical_modes(HD.rail, LENGTH)
    count = min(modes.wave_number.size, 220)
    hertz = np.sqrt(modes.omega_squared[0, :count]) / (2.0 * math.pi)
    axes: dict[str, Any] = {"plot": _MODE_PLOT, "x_label": "mode", "y_label": "frequency (Hz)"}
    computed = Curve(
        **axes, label="computed", x=list(map(float, range(1, count + 1))), y=hertz.tolist()
    )
    known = Curve(
        **axes,
        label="closed form",
        x=list(map(float, _MODES)),
        y=list(_MODES.values()),
        points=True,
    )
    return [computed, known]


def _winkler_deflection(shear_modulus: float) -> float:
    """Return the deflection in m under the load, with fasteners close together on rigid slabs."""
    stiffness = HD.fastener.vertical_stiffness * _BAY / HD.fastener.spacing
    track = with_values(
        HD,
        {
            "rail.shear_modulus": shear_modulus,
            "contact.model": "vertical",
            "slab_support.vertical_stiffness": 1e16,
            "fastener.spacing": _BAY,
            "fastener.count_per_slab": 40,
            "fastener.vertical_stiffness": stiffness,
            "slab.gap": 0.05,
            "window.slab_count": 16,
        },
    )
    middle = np.array([0.5 * track.window_length])
    pair = np.array([math.sqrt(2.0) * _LOAD])  # both rails alike: orthonormal pair
    solved = static_coordinates(assemble(track), middle, pair, SYMMETRIC)
    return float(solved.deflection[0]) / math.sqrt(2.0)


def critical_speed(p: TrackParameters) -> float:
    """Return the least phase speed in m/s of waves in the rail on smeared fasteners.

    Each wave number kappa couples its two branches through the foundation; the lower root
    omega of that 2 x 2 problem gives the phase speed omega/kappa.
    """
    modes = vertical_modes(p.rail, LENGTH)
    foundation = p.fastener.vertical_stiffness / p.fastener.spacing
    speeds = np.sqrt(_on_foundation(modes, foundation)) / modes.wave_number
    best = int(np.argmin(speeds))
    around = slice(best - 1, best + 2)
    # The modes are discrete: the minimum is that of the parabola through three of them.
    curve = np.polyfit(modes.wave_number[around], speeds[around], 2)
    return float(np.polyval(curve, -curve[1] / (2.0 * curve[0])))


def _on_foundation(modes: RailModes, foundation: float) -> np.ndarray:
    """Return the lower squared circular frequency of each wave number, rad2/s2, (N,)."""
    mean_square = modes.waves.mean_square * modes.waves.length
    first, second = modes.deflection * np.sqrt(foundation * mean_square)
    a, b = modes.omega_squared[0] + first**2, modes.omega_squared[1] + second**2
    return 0.5 * (a + b) - np.hypot(0.5 * (a - b), first * second)
