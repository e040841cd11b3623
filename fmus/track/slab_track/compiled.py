"""How functions are compiled: entries, which Python may call, and kernels, which only these call.

Numba wraps every function twice, for calls from Python and from C, at more than half of the
time that a short function takes to compile. Kernels go without. Nor are references to arrays
counted (:mod:`rail_quantities.uncounted`). Of a kernel that streams through
arrays the compiler is told that no two arguments overlap: then it can use vector instructions
however many arrays there are.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba.core.compiler import Compiler
from rail_quantities.kept_code import with_checksums
from rail_quantities.uncounted import COUNTED, UNCOUNTED

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""Fused, reordered and scaled operations: rounding errors only."""


class _Apart(Compiler):
    """Numba's compiler for functions whose arguments do not overlap."""

    def define_pipelines(self) -> Any:
        self.state.flags.noalias = True
        return super().define_pipelines()


_ANY: dict[str, Any] = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_ENTRY: dict[str, Any] = {**_ANY, **UNCOUNTED}
_KERNEL: dict[str, Any] = {**_ENTRY, "no_cpython_wrapper": True}
_STREAM: dict[str, Any] = {**_KERNEL, "fastmath": FAST, "pipeline_class": _Apart}


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; division by zero gives infinity."""
    return with_checksums(numba.njit(**_ENTRY)(function))


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that only compiled functions call; from Python it would crash."""
    return with_checksums(numba.njit(**_KERNEL)(function))


def stream(function: Callable[..., Any]) -> Any:
    """As :func:`kernel`, for loops over arrays that do not overlap."""
    return with_checksums(numba.njit(**_STREAM)(function))


def maker(function: Callable[..., Any]) -> Any:
    """As :func:`entry`, for a function that makes arrays; compiled ones may call it too."""
    return with_checksums(numba.njit(**_ANY, **COUNTED)(function))


def view(function: Callable[..., Any]) -> Any:
    """As :func:`kernel`, for a function that returns a part of an array: put into its callers."""
    return with_checksums(numba.njit(**_KERNEL, inline="always")(function))
