"""Operators begin at cache lines, with the numbers they had."""

from typing import NamedTuple

import numpy as np
from slab_track.alignment import aligned, empty


class Some(NamedTuple):
    matrix: np.ndarray
    places: np.ndarray
    number: float


def test_copies_begin_at_cache_lines():
    matrix = np.random.default_rng(0).normal(size=(7, 5))
    given = Some(matrix, np.arange(3), 2.5)
    made = aligned(given)
    assert type(made) is Some
    assert made.matrix.ctypes.data % 64 == 0
    assert np.array_equal(made.matrix, matrix)
    assert made.matrix.flags.c_contiguous
    assert not np.shares_memory(made.matrix, matrix)
    assert (made.places is given.places, made.number) == (True, 2.5)
    for size in range(1, 20):
        assert empty(size).ctypes.data % 64 == 0
        assert empty(size).shape == (size,)
