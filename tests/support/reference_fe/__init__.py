"""Independent finite-element reference of a vehicle on a slab track (tests only).

Rail: Timoshenko beam elements; slabs: conforming plate elements; generalised-alpha in time; a
finite line long enough that its ends do not matter. Nothing here is shared with the product.
"""

from .amplitude import band_limited_amplitude, low_pass
from .line import build_line, receptance, static_deflection
from .parameters import GRAVITY, ReferenceTrack, ReferenceVehicle, SingleWheel
from .simulation import ReferenceResult, simulate

__all__ = [
    "GRAVITY",
    "ReferenceResult",
    "ReferenceTrack",
    "ReferenceVehicle",
    "SingleWheel",
    "band_limited_amplitude",
    "build_line",
    "low_pass",
    "receptance",
    "simulate",
    "static_deflection",
]
