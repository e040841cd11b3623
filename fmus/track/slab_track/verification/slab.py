"""Slab: modes of a free plate."""

import math

import numpy as np
from rail_quantities.comparison import Row, Section

from slab_track.assembly import plate_modes
from slab_track.plate import free_plate_modes
from slab_track.presets import HD, ZX

_SECTION = Section("Slab")
_RITZ = (
    "converged Ritz solution; A. W. Leissa, J. Sound Vib. 31 (1973) 257-293, gives upper bounds "
    "up to 1.2 % above"
)
_PARAMETERS = {
    0.4: (3.4326, 5.2782, 9.5406),
    1.0: (13.468, 19.596, 24.270),
    2.5: (21.454, 32.989, 59.629),
}
"""omega a^2 sqrt(rho h / D) of the first three bending modes, nu = 0.3, by a/b."""

_SLABS = {"HD": (HD, (25.52, 32.61, 70.59, 71.11)), "ZX": (ZX, (23.57, 33.88, 65.22, 72.88))}
_HIGHEST = 450.0
_RIGID = 3


def slab_rows() -> list[Row]:
    """Return frequency parameters, frequencies of both lines' slabs, and a count of modes."""
    rows = []
    for aspect, known in _PARAMETERS.items():
        for n, (value, found) in enumerate(
            zip(known, frequency_parameters(aspect), strict=True), start=1
        ):
            name = f"free plate, a/b = {aspect:g}, frequency parameter {n}"
            rows.append(_SECTION.row(name, "1", value, 2e-4, found, _RITZ))
    for line, (parameters, known) in _SLABS.items():
        omega_squared = plate_modes(parameters).omega_squared
        hertz = np.sqrt(omega_squared[_RIGID:]) / (2.0 * math.pi)
        thin = "free thin plate, nu = 0.2, converged Ritz solution; data of Table 2 of the article"
        for n, value in enumerate(known, start=1):
            name = f"slab of line {line}, bending mode {n}"
            rows.append(_SECTION.row(name, "Hz", value, 5e-4, hertz[n - 1], thin))
        below = np.count_nonzero(hertz < _HIGHEST)
        counted = (
            "thin plate, counted; the article's 30 modes are those of solid elements: 24 elastic "
            "ones, in-plane modes among them"
        )
        name = f"slab of line {line}, bending modes below {_HIGHEST:g} Hz"
        rows.append(_SECTION.row(name, "1", 21.0, 0.0, float(below), counted))
    return rows


def frequency_parameters(aspect: float) -> np.ndarray:
    """Return the first three of a free plate with sides a and b = a/``aspect``."""
    plate = {"thickness": 0.01, "youngs_modulus": 1e10, "density": 1000.0, "poisson_ratio": 0.3}
    modes = free_plate_modes(length=1.0, width=1.0 / aspect, count=10, **plate)
    bending = plate["youngs_modulus"] * plate["thickness"] ** 3 / (12.0 * (1.0 - 0.3**2))
    per_area = plate["density"] * plate["thickness"]
    return np.sqrt(modes.omega_squared[_RIGID : _RIGID + 3] * per_area / bending)
