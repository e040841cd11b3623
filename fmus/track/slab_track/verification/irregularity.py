"""Irregularities: root mean square of what the filters of the time domain produce."""

import numpy as np
from rail_quantities.comparison import Row, Section

from slab_track.irregularity import CHANNELS, SPECTRA
from slab_track.irregularity.bands import design_bands, realised_density

_SECTION = Section("Irregularities")
_MILLIMETRES = {
    "german_low": {"level": 2.07, "alignment": 1.50},
    "german_high": {"level": 3.39, "alignment": 2.56},
    "chinese_ballastless": {
        "level": 1.22,
        "alignment": 0.67,
        "cross_level": 0.52,
        "gauge": 0.34,
    },
}
"""Root mean square over the band of each spectrum, by integrating its formula."""
_ROUNDING = 0.0051


def irregularity_rows() -> list[Row]:
    """Return a row for each spectrum and channel with a known root mean square."""
    rows = []
    for name, known in _MILLIMETRES.items():
        spectrum = SPECTRA[name]
        shortest, longest = spectrum.band
        source = f"{spectrum.source}; integral from {shortest:g} to {longest:g} m"
        for channel, millimetres in known.items():
            found = 1e3 * _realised_rms(name, CHANNELS.index(channel))
            what = f"{name}, {channel.replace('_', '-')}, rms"
            rows.append(
                _SECTION.row(what, "mm", millimetres, _ROUNDING, found, source, relative=False)
            )
    return rows


def _realised_rms(name: str, channel: int) -> float:
    """Return the root mean square in m of the filters' output, images and cut ends included."""
    spectrum = SPECTRA[name]
    shortest, longest = spectrum.band
    bands = design_bands(spectrum, shortest, longest, (1.0, 1.0, 1.0, 1.0))
    wavenumber = 2.0 * np.pi / np.geomspace(1.1 * longest, shortest / 1.1, 4000)
    density = realised_density(bands, channel, wavenumber)
    return float(np.sqrt(np.trapezoid(density, wavenumber)))
