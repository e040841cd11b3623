"""Endless slab track with wheel/rail contact: the physics of InfiniteSlabTrack.fmu.

The package knows no FMI (only :mod:`slab_track.slave` does) and can be used alone.
"""

from slab_track.errors import TrackError
from slab_track.model import TrackModel, TrackOutputs, TrackState
from slab_track.parameters import TrackParameters
from slab_track.presets import HD, LINES, ZX

__all__ = [
    "HD",
    "LINES",
    "ZX",
    "TrackError",
    "TrackModel",
    "TrackOutputs",
    "TrackParameters",
    "TrackState",
]
