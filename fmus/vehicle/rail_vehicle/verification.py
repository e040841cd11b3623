"""Known values of the vehicle, computed anew.

``python -m rail_vehicle.verification`` prints them as JSON. References were evaluated by hand
from Table 2 of the article, apart from the matrices.
"""

import math

import numpy as np
from rail_quantities.comparison import Row, Section, as_json

from rail_vehicle.coordinates import CAR_BODY, FREE, WHEELSET_COORDINATES, Z, coordinate
from rail_vehicle.model import VehicleModel
from rail_vehicle.parameters import VehicleParameters
from rail_vehicle.presets import PAPER, SOFT_PRIMARY

_SECTION = Section("Vehicle")
_WEIGHT = "(44039 + 2 x 2439 + 4 x 1881) kg x 9.81 m/s2 / 8, Table 2 of the article"
_TWO_MASSES = (
    "closed form: car body (44039 kg) on 4 x 0.24 MN/m, frames (4878 kg) on 8 springs of {:g} MN/m"
)
_BOUNCES = {
    "9 MN/m per box": (PAPER, 9.0, 0.7382, 19.465),
    "0.9 MN/m per box": (SOFT_PRIMARY, 0.9, 0.6975, 6.514),
}
"""By primary suspension: vehicle, stiffness in MN/m, bounce of car body and of frames in Hz."""
_ABOUT = {"9 MN/m per box": 20.0, "0.9 MN/m per box": 6.5}
_PRINTED = "expected of this stiffness; 6.5 Hz is typical of such bogies"


def rows() -> list[Row]:
    """Return all values of the vehicle."""
    load = 1e-3 * PAPER.static_wheel_load
    found = [_SECTION.row("static wheel load", "kN", 69.2108, 1e-5, load, _WEIGHT)]
    for label, (parameters, stiffness, body, frames) in _BOUNCES.items():
        source, hertz = _TWO_MASSES.format(stiffness), bounce_frequencies(parameters)
        found += [
            _SECTION.row(f"car body bounce, {label}", "Hz", body, 1e-3, hertz[0], source),
            _SECTION.row(f"bogie bounce, {label}", "Hz", frames, 1e-3, hertz[-1], source),
            _SECTION.row(
                f"bogie bounce, {label}, round figure",
                "Hz",
                _ABOUT[label],
                0.03,
                hertz[-1],
                _PRINTED,
            ),
        ]
    return found


def bounce_frequencies(parameters: VehicleParameters) -> np.ndarray:
    """Return the undamped frequencies in Hz of the modes that lift the car body, rising.

    The wheelsets are held; car body and frames move.
    """
    system = VehicleModel(parameters).linear_system()
    loose = np.setdiff1d(FREE, WHEELSET_COORDINATES.ravel())
    root_mass = np.sqrt(np.diag(system.mass)[loose])
    scaled = system.stiffness[np.ix_(loose, loose)] / np.outer(root_mass, root_mass)
    squares, shapes = np.linalg.eigh(scaled)
    share = np.abs(shapes[np.flatnonzero(loose == coordinate(CAR_BODY, Z))[0]])
    return np.sqrt(squares[share > 1e-3 * share.max()]) / (2.0 * math.pi)


if __name__ == "__main__":
    print(as_json(rows()))
