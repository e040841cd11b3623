"""Arrays in compiled code without counted references: same memory, same numbers."""

import gc
import sys
import weakref
from typing import NamedTuple

import numba
import numpy as np
import pytest
from rail_quantities.uncounted import COUNTED, UNCOUNTED, Reference, flat, on_stack, shaped


class Inner(NamedTuple):
    values: np.ndarray
    factor: float


class Outer(NamedTuple):
    inner: Inner
    numbers: np.ndarray


@numba.njit(**UNCOUNTED)
def _add(factor, values, numbers, row):
    for i in range(row.size):
        row[i] = factor * values[i] + numbers[i]


@numba.njit(**UNCOUNTED)
def _scale(outer, out):
    _add(outer.inner.factor, outer.inner.values, outer.numbers, out[1])


@numba.njit(**UNCOUNTED)
def _parts(vector, first, rows):
    part = shaped(vector, first, (rows, 2, 3))
    part[rows - 1, 1, 2] = -1.0
    line = flat(part)
    return part.shape, part[1].sum(), line.size, line[6:].sum()


@numba.njit(**UNCOUNTED)
def _fill(room, number):
    for i in range(room.size):
        room[i] = number


@numba.njit(**UNCOUNTED)
def _sums(count):
    total = 0.0
    for number in range(count):
        room, other = on_stack(5), on_stack(3)
        _fill(room, number)
        _fill(other, 1.0)
        total += room.sum() + 100.0 * other.sum()
    return total


@pytest.mark.parametrize("way", ["tuple", "reference"])
def test_arrays_are_the_callers(way):
    numbers, out = np.arange(4), np.zeros((3, 4))
    inner = Inner(np.arange(4.0), 10.0)
    outer = Outer(inner, numbers)
    given = Reference(outer) if way == "reference" else outer
    before = [sys.getrefcount(of) for of in (numbers, inner.values, out)]
    for _ in range(3):
        _scale(given, out)
    assert out[1] == pytest.approx([0.0, 11.0, 22.0, 33.0])
    assert not out[[0, 2]].any()
    assert before == [sys.getrefcount(of) for of in (numbers, inner.values, out)]


def test_a_reference_keeps_what_it_refers_to():
    """Its arrays live as long as it does, and it reads their present contents."""
    numbers = np.arange(4)
    given, out = Reference(Outer(Inner(np.full(4, 2.0), 10.0), numbers)), np.zeros((3, 4))
    watch = weakref.ref(given.parts.inner.values)
    gc.collect()
    numbers[:] = 5
    _scale(given, out)
    assert out[1] == pytest.approx([25.0] * 4)
    assert watch() is not None
    del given
    gc.collect()
    assert watch() is None


def test_references_of_one_kind_share_their_code():
    @numba.njit(**UNCOUNTED)
    def factor(of):
        return of.factor

    values = np.zeros(3)
    assert [factor(Reference(Inner(values, x))) for x in (1.0, 2.5)] == [1.0, 2.5]
    assert len(factor.signatures) == 1
    assert factor(Reference(Inner(values, 7))) == 7
    assert len(factor.signatures) == 2


def test_a_field_that_is_not_there_is_refused():
    @numba.njit(**UNCOUNTED)
    def missing(of):
        return of.missing

    with pytest.raises(numba.core.errors.TypingError, match="missing"):
        missing(Reference(Inner(np.zeros(3), 1.0)))


def test_nothing_is_counted():
    @numba.njit(**UNCOUNTED)
    def total(of):
        return of.values[1:].sum()

    assert total(Reference(Inner(np.ones(3), 1.0))) == 2.0
    (code,) = total.inspect_llvm().values()
    assert "NRT_incref" not in code


def test_functions_that_make_arrays_say_so():
    def doubled(values):
        return (2.0 * values).sum()

    with pytest.raises(numba.core.errors.NumbaError, match=r"NRT required|array passed into"):
        numba.njit(**UNCOUNTED)(doubled)(np.ones(3))
    counted = numba.njit(**COUNTED)(doubled)

    @numba.njit(**UNCOUNTED)
    def caller(values):
        return counted(values)

    assert caller(np.ones(3)) == 6.0


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
