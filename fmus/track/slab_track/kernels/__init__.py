"""The fast step of the track: plain loops over arrays, compiled once (:mod:`rail_native`).

Its only licence is agreement with :mod:`slab_track.equations`.
"""
