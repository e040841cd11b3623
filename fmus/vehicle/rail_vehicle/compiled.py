"""How functions are compiled: entries, which Python may call, and kernels, which only these call.

Numba wraps functions for calls from C and from Python, at half the time that it takes to compile
them: none for C, and none at all for kernels, which would crash if Python called them.
"""

from typing import Any

from numba import njit

_ENTRY: dict[str, Any] = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_KERNEL: dict[str, Any] = {**_ENTRY, "no_cpython_wrapper": True}

entry = njit(**_ENTRY)
kernel = njit(**_KERNEL)
