r"""Frequency weightings of accelerations in the car body, as rational transfer functions.

ISO 2631-1, Annex A, and BS 6841 build a weighting of four factors,

.. math::

   H_h &= \frac{s^2}{s^2+\omega_1 s/Q_1+\omega_1^2}, \quad
   H_l  = \frac{\omega_2^2}{s^2+\omega_2 s/Q_2+\omega_2^2}, \\
   H_t &= \frac{1+s/\omega_3}{1+s/(Q_4\omega_4)+(s/\omega_4)^2}, \quad
   H_s  = K\,\frac{1+s/(Q_5\omega_5)+(s/\omega_5)^2}{1+s/(Q_6\omega_6)+(s/\omega_6)^2}

=====  ======  =====  ======  ======  ====  ====  ====  =====  ====  ======================
\      f3      f4     Q4      f5      Q5    f6    Q6    K      for   source
=====  ======  =====  ======  ======  ====  ====  ====  =====  ====  ======================
Wk     12.5    12.5   0.63    2.37    0.91  3.35  0.91  0.502  z     ISO 2631-1, Table A.1
Wd     2       2      0.63                              1      x, y  ISO 2631-1, Table A.1
Wb     16      16     0.55    2.5     0.9   4     0.95  0.4    z     BS 6841; EN 12299
=====  ======  =====  ======  ======  ====  ====  ====  =====  ====  ======================

with f1 = 0.4 Hz, f2 = 100 Hz and Q1 = Q2 = 1/sqrt 2. K is the gain at low frequencies,
(f5/f6)^2 for Wk, so that it is 1 above the step.

Sperling's comfort weighting (Garg and Dukkipati, *Dynamics of Railway Vehicle Systems*, 1984) is

.. math:: B(f) = k\sqrt{\frac{1.911 f^2+(0.25 f^2)^2}
          {(1-0.277 f^2)^2+(1.563 f-0.0368 f^3)^2}},

k = 0.588 vertically and 0.737 laterally: the magnitude of a rational function, too.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy and xarray are typed in part only.)

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import scipy  # its parts are imported when they are used
import xarray as xr

from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.postprocessing.signals import Array, along_time, sampling_rate

LEAST_RATE = 1000.0
"""Lowest sampling rate at which the digital filters keep to the tolerances, Hz."""


class Weighting(NamedTuple):
    """A transfer function ``numerator(s) / denominator(s)``, s in rad/s.

    Attributes
    ----------
    numerator, denominator
        Coefficients by falling powers.
    meaning
        Name and source in words.
    """

    numerator: Array
    denominator: Array
    meaning: str

    def gain(self, frequency: Array) -> Array:
        """Return the magnitude at frequencies in Hz, same shape."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        ratio: Any = np.polyval(self.numerator, s) / np.polyval(self.denominator, s)
        return np.abs(ratio)


def _product(*factors: list[float]) -> Array:
    """Multiply polynomials given by rising powers; falling powers come out."""
    found: Array = np.ones(1)
    for factor in factors:
        found = np.convolve(found, factor)
    return found[::-1]


def _human(
    f3: float,
    f4: float,
    q4: float,
    step: tuple[float, float, float, float, float] | None,
    meaning: str,
) -> Weighting:
    """Band limits 0.4 Hz and 100 Hz, the transition, and a step (f5, Q5, f6, Q6, K)."""
    w1, w2, w3, w4 = (2.0 * math.pi * f for f in (0.4, 100.0, f3, f4))
    root = math.sqrt(0.5)
    above = [[0.0, 0.0, 1.0], [1.0, 1.0 / w3]]
    below = [
        [w1**2, w1 / root, 1.0],
        [1.0, 1.0 / (root * w2), 1.0 / w2**2],
        [1.0, 1.0 / (q4 * w4), 1.0 / w4**2],
    ]
    if step is not None:
        f5, q5, f6, q6, gain = step
        w5, w6 = 2.0 * math.pi * f5, 2.0 * math.pi * f6
        above.append([gain, gain / (q5 * w5), gain / w5**2])
        below.append([1.0, 1.0 / (q6 * w6), 1.0 / w6**2])
    return Weighting(_product(*above), _product(*below), meaning)


def _sperling(factor: float, meaning: str) -> Weighting:
    # In u = i f = s/(2 pi): (1.382 u + 0.25 u^2) / (1 + 1.563 u + 0.277 u^2 + 0.0368 u^3).
    u = 1.0 / (2.0 * math.pi)
    above = [0.0, factor * math.sqrt(1.911) * u, factor * 0.25 * u**2]
    below = [1.0, 1.563 * u, 0.277 * u**2, 0.0368 * u**3]
    return Weighting(_product(above), _product(below), meaning)


WEIGHTINGS = {
    "Wk": _human(
        12.5, 12.5, 0.63, (2.37, 0.91, 3.35, 0.91, (2.37 / 3.35) ** 2), "vertical, ISO 2631-1 Wk"
    ),
    "Wd": _human(2.0, 2.0, 0.63, None, "horizontal, ISO 2631-1 and EN 12299 Wd"),
    "Wb": _human(16.0, 16.0, 0.55, (2.5, 0.9, 4.0, 0.95, 0.4), "vertical, BS 6841 and EN 12299 Wb"),
    "sperling_vertical": _sperling(0.588, "vertical comfort, Sperling"),
    "sperling_lateral": _sperling(0.737, "lateral comfort, Sperling"),
}
"""All weightings by name."""


def weighting(name: str) -> Weighting:
    """Return a weighting by ``name``: ``Wb``, ``Wd``, ...

    Raises
    ------
    UnknownNameError
        If there is none of this name.
    """
    if name not in WEIGHTINGS:
        raise UnknownNameError("weighting", name, WEIGHTINGS, "frequency weighting", name)
    return WEIGHTINGS[name]


def weighted(acceleration: xr.DataArray, name: str) -> xr.DataArray:
    """Return an acceleration through a weighting filter, from rest.

    The transfer function is made digital by the bilinear transform, without prewarping: at
    1 kHz and above it keeps to the tolerance of ISO 8041 (1 dB) up to 80 Hz.

    Parameters
    ----------
    acceleration
        In m/s2; dimensions ``time`` and any others.
    name
        ``Wk``, ``Wd``, ``Wb``, ``sperling_vertical`` or ``sperling_lateral``.

    Raises
    ------
    UnknownNameError
        For another name.
    ParameterError
        If the sampling rate is below 1 kHz.
    """
    chosen = weighting(name)
    rate = sampling_rate(acceleration)
    if rate < LEAST_RATE * (1.0 - 1e-6):
        limit = f"must be at least {LEAST_RATE:g} Hz for weightings up to 100 Hz"
        raise ParameterError("sampling rate", rate, limit, "record more often")
    roots = scipy.signal.tf2zpk(chosen.numerator, chosen.denominator)
    sections = scipy.signal.zpk2sos(*scipy.signal.bilinear_zpk(*roots, fs=rate))
    return along_time(lambda x: np.asarray(scipy.signal.sosfilt(sections, x, axis=0)), acceleration)
