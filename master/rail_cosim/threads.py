"""One thread for linear algebra: with small matrices more of them wait for each other.

The FMUs run in this process, with the same numpy and scipy. On two cores a run took twice the CPU
time with two threads, and no less time.
"""

from __future__ import annotations

import importlib
from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import threadpool_limits

_LIBRARIES = ("numpy", "scipy.linalg")


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which the linear algebra of this process has one thread."""
    for name in _LIBRARIES:  # what is loaded later would not be limited
        importlib.import_module(name)
    return threadpool_limits(limits=1, user_api="blas")
