r"""Discrete sine and cosine transforms of many rows at once, for the shift of the window.

Types II and III, without factors in front as in ``scipy.fft``, by one complex fast Fourier
transform of the length M for two real rows: with :math:`w_k=e^{-i\pi k/2M}` and V the transform of
the even samples followed by the odd ones backwards, the cosine transform is
:math:`y_k = 2\,\mathrm{Re}(w_k V_k)`, and :math:`w_k V_k = (y_k - i y_{M-k})/2` on the way back
(J. Makhoul, IEEE Trans. ASSP 28 (1980) 27-34). A sine transform is a cosine transform with
alternating signs of the samples and the order of the waves turned round.

The data have the rows last, so that every butterfly works on contiguous numbers.
"""

from typing import NamedTuple

import numpy as np
from rail_native import Indices, Matrix, Vector, fast_kernel, kernel

from slab_track.core import core


class Transform(NamedTuple):
    """A transform of a length M.

    Attributes
    ----------
    factors
        Of M: 4, 2, 3, and larger primes.
    cosine, sine
        Of 2 pi k/M, (M,).
    half_cosine, half_sine
        Of pi k/(2 M), (M,).
    real, imaginary, next_real, next_imaginary
        Memory, (M, rows / 2).
    """

    factors: Indices
    cosine: Vector
    sine: Vector
    half_cosine: Vector
    half_sine: Vector
    real: Matrix
    imaginary: Matrix
    next_real: Matrix
    next_imaginary: Matrix


def make_transform(length: int, rows: int) -> Transform:
    """Return the transform of an even number of ``rows`` of a ``length``."""
    factors, rest = [], length
    for prime in (4, 2, 3):
        while rest % prime == 0:
            factors.append(prime)
            rest //= prime
    prime = 5
    while rest > 1:
        while rest % prime == 0:
            factors.append(prime)
            rest //= prime
        prime += 2
    angle = 2.0 * np.pi * np.arange(length) / length
    pair = (length, rows // 2)
    return Transform(
        factors=np.array(factors or [1], dtype=np.int64),
        cosine=np.cos(angle),
        sine=np.sin(angle),
        half_cosine=np.cos(0.25 * angle),
        half_sine=np.sin(0.25 * angle),
        real=np.zeros(pair),
        imaginary=np.zeros(pair),
        next_real=np.zeros(pair),
        next_imaginary=np.zeros(pair),
    )


@core.entry
def waves_to_samples(transform: Transform, cosines: bool, rows: Matrix) -> None:
    """Replace waves (rows, M) by twice the field at the sample points: type III, in place.

    Column k belongs to sin((k + 1) pi x/l), with ``cosines`` to cos(k pi x/l); the last sine and
    the first cosine count half.
    """
    count, pairs = transform.real.shape
    for k in range(count):
        c, s = transform.half_cosine[k], transform.half_sine[k]
        here = k if cosines else count - 1 - k
        there = count - k if cosines else k - 1
        for r in range(pairs):
            y, other = rows[r, here], rows[r + pairs, here]
            z, another = 0.0, 0.0
            if k > 0:
                z, another = rows[r, there], rows[r + pairs, there]
            # (y - i z) conj(w) of one row plus i times that of the other
            real, imaginary = c * y + s * z, s * y - c * z
            real_2, imaginary_2 = c * other + s * another, s * other - c * another
            transform.real[k, r] = real - imaginary_2
            transform.imaginary[k, r] = imaginary + real_2
    is_swapped = _fourier(transform, 1.0)
    field, second = transform.real, transform.imaginary
    if is_swapped:
        field, second = transform.next_real, transform.next_imaginary
    for n in range(count):
        place = 2 * n if 2 * n < count else 2 * (count - n) - 1
        sign = -1.0 if place % 2 == 1 and not cosines else 1.0
        for r in range(pairs):
            rows[r, place] = sign * field[n, r]
            rows[r + pairs, place] = sign * second[n, r]


@core.entry
def samples_to_waves(transform: Transform, cosines: bool, rows: Matrix) -> None:
    """Replace samples (rows, M) by twice their sums with the waves: type II, in place."""
    count, pairs = transform.real.shape
    for n in range(count):
        place = 2 * n if 2 * n < count else 2 * (count - n) - 1
        sign = -1.0 if place % 2 == 1 and not cosines else 1.0
        for r in range(pairs):
            transform.real[n, r] = sign * rows[r, place]
            transform.imaginary[n, r] = sign * rows[r + pairs, place]
    is_swapped = _fourier(transform, -1.0)
    real, imaginary = transform.real, transform.imaginary
    if is_swapped:
        real, imaginary = transform.next_real, transform.next_imaginary
    for k in range(count):
        c, s = transform.half_cosine[k], transform.half_sine[k]
        mirrored = (count - k) % count
        here = k if cosines else count - 1 - k
        for r in range(pairs):
            # Twice the transforms of both rows, from that of row + i row.
            a, b = real[k, r] + real[mirrored, r], imaginary[k, r] - imaginary[mirrored, r]
            d, e = imaginary[k, r] + imaginary[mirrored, r], real[mirrored, r] - real[k, r]
            rows[r, here] = c * a + s * b
            rows[r + pairs, here] = c * d + s * e


@kernel
def _fourier(transform, sign):
    """Transform with exp(sign 2 pi i k n/M), Stockham's way; True if it ends in ``next_``."""
    count = transform.real.shape[0]
    x, y = transform.real, transform.imaginary
    u, v = transform.next_real, transform.next_imaginary
    length, stride, is_swapped = count, 1, False
    for radix in transform.factors:
        length //= radix
        step = count // (length * radix)
        if radix == 4:
            _stage_of_4(transform.cosine, transform.sine, sign, length, stride, step, x, y, u, v)
        elif radix == 2:
            _stage_of_2(transform.cosine, transform.sine, sign, length, stride, step, x, y, u, v)
        else:
            _stage_of(radix, transform, sign, length, stride, step, x, y, u, v)
        x, y, u, v = u, v, x, y
        stride *= radix
        is_swapped = not is_swapped
    return is_swapped


@fast_kernel
def _stage_of_2(cosine, sine, sign, length, stride, step, x, y, u, v):
    """Butterflies of two: ``length`` of them on blocks of ``stride`` numbers."""
    pairs = x.shape[1]
    for p in range(length):
        c, s = cosine[p * step], sign * sine[p * step]
        for q in range(stride):
            i, j, to = q + stride * p, q + stride * (p + length), q + stride * 2 * p
            for r in range(pairs):
                a, b = x[i, r] - x[j, r], y[i, r] - y[j, r]
                u[to, r], v[to, r] = x[i, r] + x[j, r], y[i, r] + y[j, r]
                u[to + stride, r], v[to + stride, r] = c * a - s * b, c * b + s * a


@fast_kernel
def _stage_of_4(cosine, sine, sign, length, stride, step, x, y, u, v):
    """Butterflies of four."""
    pairs, quarter = x.shape[1], stride * length
    for p in range(length):
        c1, s1 = cosine[p * step], sign * sine[p * step]
        c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
        c3, s3 = c1 * c2 - s1 * s2, c1 * s2 + s1 * c2
        for q in range(stride):
            i, to = q + stride * p, q + stride * 4 * p
            j, k, m = i + quarter, i + 2 * quarter, i + 3 * quarter
            for r in range(pairs):
                a, b = x[i, r] + x[k, r], y[i, r] + y[k, r]
                c, d = x[i, r] - x[k, r], y[i, r] - y[k, r]
                e, f = x[j, r] + x[m, r], y[j, r] + y[m, r]
                g, h = sign * (y[m, r] - y[j, r]), sign * (x[j, r] - x[m, r])
                u[to, r], v[to, r] = a + e, b + f
                g1, h1 = c + g, d + h
                u[to + stride, r], v[to + stride, r] = c1 * g1 - s1 * h1, c1 * h1 + s1 * g1
                g2, h2 = a - e, b - f
                u[to + 2 * stride, r] = c2 * g2 - s2 * h2
                v[to + 2 * stride, r] = c2 * h2 + s2 * g2
                g3, h3 = c - g, d - h
                u[to + 3 * stride, r] = c3 * g3 - s3 * h3
                v[to + 3 * stride, r] = c3 * h3 + s3 * g3


@fast_kernel
def _stage_of(radix, transform, sign, length, stride, step, x, y, u, v):
    """Butterflies of any number."""
    count, pairs = x.shape
    cosine, sine = transform.cosine, transform.sine
    for p in range(length):
        for q in range(stride):
            for j in range(radix):
                to = q + stride * (radix * p + j)
                for r in range(pairs):
                    u[to, r] = v[to, r] = 0.0
                for k in range(radix):
                    turn = (j * k * (count // radix) + j * p * step) % count
                    c, s = cosine[turn], sign * sine[turn]
                    i = q + stride * (p + length * k)
                    for r in range(pairs):
                        u[to, r] += c * x[i, r] - s * y[i, r]
                        v[to, r] += c * y[i, r] + s * x[i, r]
