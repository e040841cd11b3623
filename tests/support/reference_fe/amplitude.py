"""Amplitude of a periodic steady state."""

import numpy as np
from scipy.interpolate import CubicSpline


def low_pass(period_signal: np.ndarray, duration: float, f_max: float) -> np.ndarray:
    """Keep the Fourier terms up to `f_max` of whole periods (shape: time, ...; end excluded)."""
    spectrum = np.fft.rfft(period_signal, axis=0)
    spectrum[np.fft.rfftfreq(len(period_signal), duration / len(period_signal)) > f_max] = 0.0
    return np.fft.irfft(spectrum, len(period_signal), axis=0)


def band_limited_amplitude(
    time: np.ndarray, signal: np.ndarray, f_max: float = 500.0, window: float = 0.0
) -> np.ndarray:
    """Half the peak-to-peak of the last `window` seconds, Fourier terms up to `f_max` only.

    Parameters
    ----------
    time : ndarray, shape (time,)
        Equidistant, s.
    signal : ndarray, shape (time, ...)
    f_max : float
        Last frequency kept, Hz.
    window : float
        Whole number of periods (slab passings) in s. Need not be a multiple of the step; where
        it is, samples are taken as they are.

    Returns
    -------
    ndarray, shape of `signal` without time
        In the signal's unit.
    """
    if not 0.0 < window <= (time[-1] - time[0]) * (1 + 1e-12):
        raise ValueError(
            f"window = {window} s: it must be positive and not longer than the signal "
            f"({time[-1] - time[0]} s)"
        )
    count = round(window / (time[1] - time[0]))
    instants = time[-1] - window + window / count * np.arange(count)
    if np.allclose(instants, time[-count - 1 : -1], rtol=0.0, atol=1e-6 * window / count):
        samples = signal[-count - 1 : -1]
    else:
        samples = CubicSpline(time, signal)(instants)
    return 0.5 * np.ptp(low_pass(samples, window, f_max), axis=0)
