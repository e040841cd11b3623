"""White noise by number: value ``i`` of a stream is a function of (stream, i) alone.

No generator state exists, so any place of an endless line can be asked for in
any order. The integers come from the SplitMix64 finaliser (Steele, Lea and
Flood 2014, "Fast splittable pseudorandom number generators") on a counter.
"""

import numpy as np
from rail_native import Vector, kernel

from slab_track.core import core

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_MASK = np.uint64(0xFFFF)
_S16, _S27, _S30, _S31, _S32, _S48 = (np.uint64(n) for n in (16, 27, 30, 31, 32, 48))
# Four uniform numbers of 16 bits: k = 0 ... 65535 has the variance (65536^2 - 1) / 12.
_MEAN = 4 * 65535 / 2
_SCALE = float(np.sqrt(12.0 / (4.0 * (65536.0**2 - 1.0))))


@kernel
def _bits(number):
    """Return the 64 bits of an integer, which may be negative."""
    return np.uint64(np.int64(number))


@kernel
def mix(bits):
    """Scramble 64 bits: each bit of the input changes half of the output's."""
    bits = (bits ^ (bits >> _S30)) * _FIRST
    bits = (bits ^ (bits >> _S27)) * _SECOND
    return bits ^ (bits >> _S31)


@kernel
def white(key, index):
    """Return number ``index`` (any int64) of the stream ``key``: mean 0, variance 1.

    It is the sum of four uniform numbers, close to Gaussian (kurtosis 2.7); what is
    filtered from many of them is Gaussian.
    """
    bits = mix(key + _bits(index) * _GOLDEN)
    total = (bits & _MASK) + ((bits >> _S16) & _MASK) + ((bits >> _S32) & _MASK) + (bits >> _S48)
    return (float(total) - _MEAN) * _SCALE


@kernel
def stream_key(seed, band, channel):
    """Return the key (64 bits) of an independent stream for (seed, band, channel)."""
    key = mix(_bits(seed) + _GOLDEN)
    key = mix(key ^ (_bits(band) + _FIRST))
    return mix(key ^ (_bits(channel) + _SECOND))


@core.entry
def white_noise(seed: int, band: int, channel: int, first: int, out: Vector) -> None:
    """Write the numbers ``first``, ``first + 1``, ... of the stream of (seed, band, channel)."""
    key = stream_key(seed, band, channel)
    for i in range(out.size):
        out[i] = white(key, first + i)
