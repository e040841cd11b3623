"""Track irregularities on an endless line.

Random irregularities of a given spectrum, rail joints, cosine dips and bumps,
and the user's file, all as functions of the place along the line alone.
"""

from slab_track.irregularity.files import IrregularityFileError, read_file
from slab_track.irregularity.geometry import rails_from_track, track_from_rails
from slab_track.irregularity.irregularity import Irregularity
from slab_track.irregularity.kernels import IrregularityData, evaluate_into
from slab_track.irregularity.parameters import (
    CosineParameters,
    FileParameters,
    IrregularityParameters,
    RailJointParameters,
)
from slab_track.irregularity.spectra import CHANNELS, SPECTRA, Spectrum, band_rms

__all__ = [
    "CHANNELS",
    "SPECTRA",
    "CosineParameters",
    "FileParameters",
    "Irregularity",
    "IrregularityData",
    "IrregularityFileError",
    "IrregularityParameters",
    "RailJointParameters",
    "Spectrum",
    "band_rms",
    "evaluate_into",
    "rails_from_track",
    "read_file",
    "track_from_rails",
]
