r"""Power spectral densities of track irregularities.

All are one-sided and over the angular wavenumber :math:`\Omega = 2\pi/\lambda`
in rad/m, so that :math:`\sigma^2 = \int_0^\infty S\,d\Omega`; unit m2/(rad/m).
"""

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CHANNELS = ("level", "alignment", "cross_level", "gauge")
"""The four kinds of irregularity, in the order of every array of channels."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spectrum:
    """Spectra of the four kinds of irregularity.

    Attributes
    ----------
    name
        As in the parameter ``irregularity.spectrum``.
    band
        Shortest and longest wavelength used by default, m.
    valid
        Shortest and longest wavelength that the source gives it for, m.
    density
        Function of channel index (0 to 3, order of :data:`CHANNELS`) and
        angular wavenumber (rad/m) that returns the density, m2/(rad/m).
    source
        Where the formula is from.
    """

    name: str
    band: tuple[float, float]
    valid: tuple[float, float]
    density: Callable[[int, FloatArray], FloatArray]
    source: str


# Cut-off wavenumbers of the German spectra, rad/m.
_OMEGA_C, _OMEGA_R, _OMEGA_S = 0.8246, 0.0206, 0.4380


def _german(alignment: float, vertical: float, gauge: float) -> Callable:
    """Return the density function for the roughness constants (m2 rad/m)."""

    def density(channel: int, wavenumber: FloatArray) -> FloatArray:
        square = np.asarray(wavenumber, dtype=float) ** 2
        shape = _OMEGA_C**2 / ((square + _OMEGA_R**2) * (square + _OMEGA_C**2))
        if channel == 0:
            return vertical * shape
        if channel == 1:
            return alignment * shape
        shape = shape * square / (square + _OMEGA_S**2)
        # The source gives cross-level as an angle, with A_v / b^2; the height difference
        # of the two rails is 2 b times the angle, so that b cancels.
        return (4.0 * vertical if channel == 2 else gauge) * shape

    return density


# (A, k) of S = A / f^k in mm2.m over f in 1/m, and the frequencies between the pieces.
_CHINESE = (
    (
        (1.0544e-5, 3.3891),
        (3.5588e-3, 1.9271),
        (1.9784e-2, 1.3643),
        (3.9488e-4, 3.4516),
        (0.0187, 0.0474, 0.1533),
    ),
    ((3.9513e-3, 1.8670), (1.1047e-2, 1.5354), (7.5633e-4, 2.8171), (0.0450, 0.1234)),
    ((3.6148e-3, 1.7278), (4.3685e-2, 1.0461), (4.5867e-3, 2.0939), (0.0258, 0.1163)),
    ((5.4978e-2, 0.8282), (5.0701e-3, 1.9037), (1.8778e-4, 4.5948), (0.1090, 0.2938)),
)


def _chinese(channel: int, wavenumber: FloatArray) -> FloatArray:
    *pieces, breaks = _CHINESE[channel]
    frequency = np.asarray(wavenumber, dtype=float) / (2 * np.pi)
    amplitude, exponent = np.array(pieces)[np.searchsorted(breaks, frequency, side="right")].T
    millimetres = amplitude.T / frequency**exponent.T  # mm2/(1/m)
    return millimetres * 1e-6 / (2 * np.pi)


_GERMAN_SOURCE = "German railways' spectra for high-speed lines, low and high disturbance"

SPECTRA = {
    spectrum.name: spectrum
    for spectrum in (
        Spectrum(
            name="german_low",
            band=(1.0, 80.0),
            valid=(1.0, 80.0),
            density=_german(2.119e-7, 4.032e-7, 5.32e-8),
            source=_GERMAN_SOURCE,
        ),
        Spectrum(
            name="german_high",
            band=(1.0, 80.0),
            valid=(1.0, 80.0),
            density=_german(6.125e-7, 1.08e-6, 1.032e-7),
            source=_GERMAN_SOURCE,
        ),
        Spectrum(
            name="chinese_ballastless",
            band=(2.0, 200.0),
            valid=(2.0, 200.0),
            density=_chinese,
            source="TB/T 3352-2014, ballastless track of high-speed lines",
        ),
    )
}
"""The spectra by name."""


def band_rms(spectrum: Spectrum, channel: int, shortest: float, longest: float) -> float:
    """Return the root mean square (m) of a channel between two wavelengths (m)."""
    wavenumber = 2 * np.pi / np.geomspace(longest, shortest, 20001)
    density = spectrum.density(channel, wavenumber)
    return float(np.sqrt(np.trapezoid(density, wavenumber)))
