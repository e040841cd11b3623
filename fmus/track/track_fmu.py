"""Entry script of InfiniteSlabTrack.fmu."""

from __future__ import annotations

from slab_track.slave import TrackSlave


class InfiniteSlabTrack(TrackSlave):
    """The slave of the FMU."""

    def __init__(self, **kwargs):  # pythonfmu needs a method of the class itself
        super().__init__(**kwargs)
