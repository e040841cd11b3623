"""Arrays in compiled code without counted references: same memory, same numbers."""

import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest
from rail_quantities.uncounted import borrowed, flat, on_stack, shaped


class Inner(NamedTuple):
    values: np.ndarray
    factor: float


class Outer(NamedTuple):
    inner: Inner
    numbers: np.ndarray


@numba.njit
def _scale(outer, out):
    outer, out = borrowed(outer), borrowed(out)
    row = out[1]
    for i in range(row.size):
        row[i] = outer.inner.factor * outer.inner.values[i] + outer.numbers[i]
    return out


@numba.njit
def _parts(vector, first, rows):
    vector = borrowed(vector)
    part = shaped(vector, first, (rows, 2, 3))
    part[rows - 1, 1, 2] = -1.0
    line = flat(part)
    return part.shape, part[1].sum(), line.size, line[6:].sum()


@numba.njit
def _fill(room, number):
    for i in range(room.size):
        room[i] = number


@numba.njit
def _sums(count):
    total = 0.0
    for number in range(count):
        room, other = on_stack(5), on_stack(3)
        _fill(room, number)
        _fill(other, 1.0)
        total += room.sum() + 100.0 * other.sum()
    return total


def test_borrowed_arrays_are_the_callers():
    numbers, out = np.arange(4), np.zeros((3, 4))
    outer = Outer(Inner(np.arange(4.0), 10.0), numbers)
    before = sys.getrefcount(numbers), sys.getrefcount(outer.inner.values), sys.getrefcount(out)
    for _ in range(3):
        _scale(outer, out)
    assert out[1] == pytest.approx([0.0, 11.0, 22.0, 33.0])
    assert not out[[0, 2]].any()
    assert before == (
        sys.getrefcount(numbers),
        sys.getrefcount(outer.inner.values),
        sys.getrefcount(out),
    )


def test_parts_of_a_vector_have_their_shape():
    vector = np.arange(30.0)
    shape, second, size, rest = _parts(vector, 3, 4)
    assert (shape, size) == ((4, 2, 3), 24)
    assert vector[26] == -1.0
    assert np.array_equal(np.flatnonzero(vector != np.arange(30.0)), [26])
    wanted = vector[3:27].reshape(4, 2, 3)
    assert second == wanted[1].sum()
    assert rest == wanted[1:].sum()


def test_arrays_on_the_stack_are_apart():
    assert _sums(1000) == pytest.approx(5.0 * 999 * 500 + 1000 * 300)


def test_the_stack_takes_numbers_of_the_source_only():
    @numba.njit
    def of_any_size(count):
        return on_stack(count).sum()

    with pytest.raises(numba.core.errors.TypingError):
        of_any_size(3)


def test_arrays_that_are_not_contiguous_are_refused():
    @numba.njit
    def in_a_row(array):
        return flat(array).size

    assert in_a_row(np.zeros((2, 3))) == 6
    with pytest.raises(numba.core.errors.TypingError):
        in_a_row(np.zeros((2, 3)).T)
