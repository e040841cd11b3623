"""How functions are compiled: entries, which Python may call, and kernels, which only these call.

Numba wraps functions for calls from C and from Python, at half the time that it takes to compile
them: none for C, and none at all for kernels, which would crash if Python called them. References
to arrays are not counted (:mod:`rail_quantities.uncounted`).
"""

from collections.abc import Callable
from typing import Any

from numba import njit
from rail_quantities.kept_code import with_checksums
from rail_quantities.uncounted import UNCOUNTED

_ENTRY: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    **UNCOUNTED,
}
_KERNEL: dict[str, Any] = {**_ENTRY, "no_cpython_wrapper": True}


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; division by zero gives infinity."""
    return with_checksums(njit(**_ENTRY)(function))


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that only compiled functions call; from Python it would crash."""
    return with_checksums(njit(**_KERNEL)(function))
