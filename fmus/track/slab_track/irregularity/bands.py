r"""Filters that turn white noise into irregularities of a given spectrum.

The wavelengths are split into a few bands, each on a grid as coarse as its
shortest wavelength allows, so that long waves cost little. In band j

.. math::  z_j(x) = \sum_n y_n\, \beta(x / h_j - n), \qquad
           y_n = \sum_m g_m\, \xi_{n - m}

with white noise :math:`\xi` of variance 1 and the cubic B-spline
:math:`\beta`. Its density, one-sided, is

.. math::  S_j(\Omega) = \frac{h_j}{\pi} |G_j(\Omega)|^2
                         \operatorname{sinc}^8(\Omega h_j / 2),

so :math:`G_j = \sqrt{\pi w_j S / h_j} / \operatorname{sinc}^4`. The weights
:math:`w_j` cross over smoothly between neighbours and sum to 1 inside the band
of the irregularity; independent bands add up in power.
"""

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from slab_track.irregularity.spectra import CHANNELS, FloatArray, Spectrum

_BAND_RATIO = 4.0
"""Largest ratio of the wavelengths at the two ends of one band."""
_OVERLAP = 0.35
"""Half the width of a cross-over inside, as a share of the band's logarithmic width."""
_EDGE = 0.05
"""Half the width of the roll-off at the outer ends, relative to the wavelength."""
_SAMPLES_PER_WAVE = 6.0
"""Grid points per shortest wavelength; images are (1/5)^8 in power."""
_TAIL = 1e-6
"""Share of a filter's energy that is cut off at its ends."""
_TRANSFORM = 1 << 15


@dataclasses.dataclass(frozen=True, kw_only=True)
class Band:
    """One band of wavelengths.

    Attributes
    ----------
    spacing
        Distance of its grid, m.
    kernels
        Filter of each channel, shape (4, taps), taps odd, m.
    """

    spacing: float
    kernels: FloatArray


def _rise(value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a smooth amplitude from 0 (value <= -1) to 1 (>= 1), sqrt(1/2) at 0.

    ``_rise(v)**2 + _rise(-v)**2 == 1``: what one band loses its neighbour gains.
    """
    t = np.clip((value + 1) / 2, 0.0, 1.0)
    return np.sin(np.pi / 2 * t**3 * (10 - 15 * t + 6 * t * t))


def design_bands(
    spectrum: Spectrum, shortest: float, longest: float, factors: tuple[float, ...]
) -> list[Band]:
    """Return the filters for a spectrum between two wavelengths (m), longest band first.

    ``factors`` scale the amplitudes of the four channels.
    """
    total = math.log(longest / shortest)
    count = max(1, math.ceil(total / math.log(_BAND_RATIO) - 1e-9))
    edges = np.log(2 * np.pi / longest) + total * np.arange(count + 1) / count
    widths = np.full(count + 1, _OVERLAP * total / count)
    widths[[0, -1]] = math.log1p(_EDGE)
    bands = []
    for j in range(count):
        spacing, kernels = _design(spectrum, edges[j : j + 2], widths[j : j + 2])
        bands.append(Band(spacing=spacing, kernels=np.array(factors)[:, None] * kernels))
    return bands


def _design(spectrum: Spectrum, edges: FloatArray, widths: FloatArray) -> tuple[float, FloatArray]:
    """Return spacing and filters between two edges, given with half widths as ln(wavenumber)."""
    spacing = 2 * np.pi / np.exp(edges[1] + widths[1]) / _SAMPLES_PER_WAVE
    step = 2 * np.pi / (_TRANSFORM * spacing)
    wavenumber = step * np.arange(1, _TRANSFORM // 2 + 1)
    position = np.log(wavenumber)
    weight = _rise((position - edges[0]) / widths[0]) * _rise((edges[1] - position) / widths[1])
    inside = weight > 0
    spline = np.sinc(wavenumber * spacing / (2 * np.pi)) ** 4
    kernels = np.zeros((len(CHANNELS), _TRANSFORM))
    for channel in range(len(CHANNELS)):
        gain = np.zeros(_TRANSFORM // 2 + 1)
        density = spectrum.density(channel, wavenumber[inside])
        gain[1:][inside] = weight[inside] * np.sqrt(np.pi * density / spacing) / spline[inside]
        kernels[channel] = np.fft.fftshift(np.fft.irfft(gain))
    return float(spacing), _cut(kernels)


def _cut(kernels: FloatArray) -> FloatArray:
    """Cut the ends that carry little energy, to zero over the last tenth."""
    middle = kernels.shape[1] // 2
    energy = kernels**2
    energy /= energy.sum(axis=1, keepdims=True)
    outside = np.cumsum(energy, axis=1).max(axis=0)[:middle]  # symmetric: the left half will do
    half = max(8, middle - int(np.searchsorted(outside, _TAIL / 2)))
    half = min(half, middle - 1)
    kept = kernels[:, middle - half : middle + half + 1]
    distance = np.abs(np.arange(-half, half + 1)) / half
    fade = np.cos(np.pi / 2 * np.clip((distance - 0.9) / 0.1, 0.0, 1.0)) ** 2
    return np.ascontiguousarray(kept * fade)


def realised_density(bands: list[Band], channel: int, wavenumber: FloatArray) -> FloatArray:
    """Return the density (m2/(rad/m), one-sided) that the filters really produce.

    Computed from the filters as they are, with their cut ends and with the images
    that the splines leave beyond the grids' Nyquist wavenumber.
    """
    total = np.zeros_like(wavenumber)
    for band in bands:
        kernel = band.kernels[channel]
        half = len(kernel) // 2
        lag = np.arange(half + 1)
        twice = np.where(lag > 0, 2.0, 1.0) * kernel[half:]
        gain = np.array([twice @ np.cos(w * band.spacing * lag) for w in wavenumber])
        spline = np.sinc(wavenumber * band.spacing / (2 * np.pi)) ** 8
        total += band.spacing / np.pi * gain**2 * spline
    return total
