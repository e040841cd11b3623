"""The slab track in the frequency domain: receptances, P2 resonance, coupled eigenmodes.

Everything comes from the matrices that the time domain integrates
(:func:`slab_track.assembly.assemble`, :func:`slab_track.lateral.assemble_lateral`).
``python -m slab_track.frequency`` writes tables of it.
"""

from slab_track.frequency.modes import (
    WHEELSET_ON_PRIMARY,
    CoupledMode,
    CoupledSystem,
    Wheelset,
    coupled_modes,
    hertz_stiffness,
)
from slab_track.frequency.p2 import (
    P2Formula,
    PinnedPinned,
    p2_formula,
    pinned_pinned_extremes,
    pinned_pinned_frequency,
    resonance_speed,
)
from slab_track.frequency.receptance import Middle, Receptance, middle, receptance

__all__ = [
    "WHEELSET_ON_PRIMARY",
    "CoupledMode",
    "CoupledSystem",
    "Middle",
    "P2Formula",
    "PinnedPinned",
    "Receptance",
    "Wheelset",
    "coupled_modes",
    "hertz_stiffness",
    "middle",
    "p2_formula",
    "pinned_pinned_extremes",
    "pinned_pinned_frequency",
    "receptance",
    "resonance_speed",
]
