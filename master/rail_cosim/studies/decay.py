"""Does a lateral motion die out? Envelope, frequency and growth rate of a record."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FLOOR = 2e-5  # m; below it, what is left is not the motion that was started
_SUSTAINED = 0.1  # share by which a sustained motion may change over the evaluated half
_LEAST_PERIODS = 2.0  # in the evaluated half; nothing slower is looked for
_FEWEST = 4  # blocks for a fit


@dataclasses.dataclass(frozen=True, kw_only=True)
class LateralMotion:
    """Lateral motion of the wheelsets after a start away from the middle.

    Attributes
    ----------
    times, amplitude
        Envelope: half the range of the wheelset that moves most in a block of one period, at
        the blocks' middles, s and m, shape (n,).
    frequency
        Dominant frequency of the second half, Hz.
    growth_rate
        Slope of the envelope's logarithm over the second half, 1/s; negative: it dies out.
    final_amplitude
        Of the last block, m.
    verdict
        ``decays``, ``grows`` or ``limit cycle`` (goes on with constant amplitude).
    """

    times: FloatArray
    amplitude: FloatArray
    frequency: float
    growth_rate: float
    final_amplitude: float
    verdict: str

    @property
    def decrement(self) -> float:
        """Logarithmic decrement: loss of the amplitude's logarithm in a period."""
        return -self.growth_rate / self.frequency

    @property
    def stable(self) -> bool:
        """Whether it dies out."""
        return self.verdict == "decays"


def analyse(time: FloatArray, lateral: FloatArray) -> LateralMotion:
    """Return what the lateral displacements do in the second half of a record.

    Parameters
    ----------
    time
        Equidistant, s, shape (n,).
    lateral
        Lateral displacements of the wheelsets, m, shape (n, wheelsets).
    """
    length = time[-1] - time[0]
    second = time >= time[0] + 0.5 * length
    frequency = _dominant(time[second], lateral[second], lowest=2.0 * _LEAST_PERIODS / length)
    times, amplitude = _envelope(time, lateral, 1.0 / frequency)
    fitted = times >= time[0] + 0.5 * length
    rate = _slope(times[fitted], amplitude[fitted])
    final = float(amplitude[-1])
    return LateralMotion(
        times=times,
        amplitude=amplitude,
        frequency=frequency,
        growth_rate=rate,
        final_amplitude=final,
        verdict=_verdict(rate, 0.5 * length, final),
    )


def _verdict(rate: float, span: float, final: float) -> str:
    if final <= _FLOOR:
        return "decays"
    if abs(rate) * span < _SUSTAINED:
        return "limit cycle"
    return "grows" if rate > 0.0 else "decays"


def _dominant(time: FloatArray, lateral: FloatArray, lowest: float) -> float:
    """Return the strongest frequency (Hz) from ``lowest`` on, summed over the wheelsets."""
    step = (time[-1] - time[0]) / (len(time) - 1)
    window = np.hanning(len(time))[:, None]
    count = 8 * len(time)
    lines = np.abs(np.fft.rfft((lateral - lateral.mean(axis=0)) * window, count, axis=0)) ** 2
    frequencies = np.fft.rfftfreq(count, step)
    power = np.where(frequencies >= lowest, lines.sum(axis=1), -1.0)
    return float(frequencies[int(np.argmax(power))])


def _envelope(
    time: FloatArray, lateral: FloatArray, period: float
) -> tuple[FloatArray, FloatArray]:
    """Half the range in blocks of one period, each a quarter of a period after the last."""
    step = (time[-1] - time[0]) / (len(time) - 1)
    size = max(2, round(period / step))
    starts = np.arange(len(time) - size, -1, -max(1, size // 4))[::-1]  # the last ends the record
    ranges = [np.ptp(lateral[start : start + size], axis=0).max() for start in starts]
    return time[starts] + 0.5 * period, 0.5 * np.array(ranges)


def _slope(times: FloatArray, amplitude: FloatArray) -> float:
    """Slope of the logarithm over time, 1/s, as far as there is a motion; nan if there is none."""
    moving = amplitude > _FLOOR
    if np.count_nonzero(moving) < _FEWEST:
        return math.nan
    return float(np.polyfit(times[moving], np.log(amplitude[moving]), 1)[0])
