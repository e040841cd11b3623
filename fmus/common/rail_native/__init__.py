"""Kernels compiled once, to a shared library, and called without a compiler.

``core`` marks kernels and calls them, ``signature`` lays out what they take, ``compiler`` makes
the library. It knows no physics, and imports numba only while it compiles.
"""

from rail_native.core import CLibrary, Core, Entry, fast_kernel, kernel
from rail_native.errors import CompileError, NativeError
from rail_native.signature import Array3, Array4, IndexMatrix, Indices, Matrix, Vector

__all__ = [
    "Array3",
    "Array4",
    "CLibrary",
    "CompileError",
    "Core",
    "Entry",
    "IndexMatrix",
    "Indices",
    "Matrix",
    "NativeError",
    "Vector",
    "fast_kernel",
    "kernel",
]
