"""The compiled core of a package: its entries as Python calls them.

Kernels are plain functions over arrays and numbers. Marked by :func:`kernel` and
:meth:`Core.entry` they are

- compiled by numba while a library is made (:mod:`rail_native.__main__`),
- called in that library, by ctypes, wherever the product runs: no numba, no compiling,
- plain Python with ``RAIL_COSIM_KERNELS=python`` in the environment, for a debugger.
"""

import ctypes
import functools
import hashlib
import importlib
import importlib.util
import os
import platform
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rail_native.errors import NativeError
from rail_native.signature import ArrayKind, Group, Vector, leaves, parameters, result, results

COMPILING = "RAIL_NATIVE_COMPILES"
"""Set in the environment of the process that compiles."""

SWITCH = "RAIL_COSIM_KERNELS"
"""``python`` has the kernels run as plain Python."""

_OPTIONS: dict[str, Any] = {"error_model": "numpy"}
# No wrappers for calls from Python and C: kernels are called by kernels only.
_OPTIONS |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

_ENDINGS = {"win32": "dll", "darwin": "dylib"}


def kernel(function: Callable[..., Any]) -> Any:
    """Mark a function that entries and other kernels call; division by zero gives infinity."""
    if COMPILING not in os.environ:
        return function
    import numba

    return numba.njit(**_OPTIONS)(function)


FAST = {"contract", "reassoc", "nsz", "arcp"}
"""Fused, reordered and scaled operations: rounding errors only."""


def fast_kernel(function: Callable[..., Any]) -> Any:
    """Mark a kernel that streams through arrays; its sums may be reordered, products fused."""
    if COMPILING not in os.environ:
        return function
    import numba

    return numba.njit(fastmath=FAST, **_OPTIONS)(function)


def library_name() -> str:
    """Return the file name of a library for this platform, such as ``linux-x86_64.so``."""
    return f"{sys.platform}-{platform.machine().lower()}.{_ENDINGS.get(sys.platform, 'so')}"


class Library:
    """A shared library of a package, in its folder ``native``.

    Parameters
    ----------
    package
        Name of the package.
    """

    def __init__(self, package: str) -> None:
        self.package = package

    @functools.cached_property
    def folder(self) -> Path:
        """Folder of the package."""
        spec = importlib.util.find_spec(self.package)
        if spec is None or not spec.submodule_search_locations:
            raise NativeError(f"package {self.package!r} is not installed")
        return Path(spec.submodule_search_locations[0])

    @property
    def path(self) -> Path:
        """The library for this platform."""
        return self.folder / "native" / library_name()

    @property
    def sources(self) -> list[Path]:
        """Files that it is made from."""
        raise NotImplementedError

    def make(self) -> None:
        """Compile it."""
        raise NotImplementedError

    @property
    def digest(self) -> str:
        """SHA-256 of the sources."""
        total = hashlib.sha256()
        for file in self.sources:
            total.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
        return total.hexdigest()

    @functools.cached_property
    def library(self) -> ctypes.CDLL:
        """The library, loaded.

        Raises
        ------
        NativeError
            If there is none for this platform, or it was made from other sources.
        """
        remedy = f"Remedy: {sys.executable} -m rail_native {self.package}"
        if not self.path.is_file():
            raise NativeError(
                f"{self.package} has no compiled core for this platform: {self.path} does not "
                f"exist. {remedy}"
            )
        library = ctypes.CDLL(str(self.path))
        made_from = ctypes.c_char_p.in_dll(library, "rail_native_sources").value or b""
        if made_from.decode() != self.digest:
            raise NativeError(
                f"{self.path} was compiled from other sources ({made_from[:12].decode()}) than "
                f"those of {self.package} ({self.digest[:12]}). {remedy}"
            )
        return library


class CLibrary(Library):
    """A library made from C.

    Parameters
    ----------
    package
        Name of the package.
    source
        Its file, by its name in the package's folder.
    """

    def __init__(self, package: str, source: str) -> None:
        super().__init__(package)
        self._source = source

    @property
    def sources(self) -> list[Path]:
        """Files that it is made from."""
        return [self.folder / self._source]

    def make(self) -> None:
        """Compile it."""
        from rail_native.compiler import compile_c

        compile_c(self.sources[0], self.path, sources=self.digest)


class Core(Library):
    """Entries of a package and the library that holds them.

    Parameters
    ----------
    package
        Name of the package.
    modules
        Its modules that hold kernels, by their names inside the package.

    Attributes
    ----------
    entries
        The functions marked by :meth:`entry`, by name.
    """

    def __init__(self, package: str, modules: Sequence[str]) -> None:
        super().__init__(package)
        self.modules = tuple(modules)
        self.entries: dict[str, Callable[..., Any]] = {}

    def entry(self, function: Callable[..., Any]) -> Any:
        """Mark a function that Python calls; its annotations say what it takes."""
        if COMPILING in os.environ:
            function = kernel(function)
            self.entries[function.__name__] = function
            return function
        return Entry(self, function)

    @property
    def sources(self) -> list[Path]:
        """Files that it is made from."""
        here = Path(__file__).parent
        files = [here / name for name in ("compiler.py", "signature.py")]
        own = (self.folder.joinpath(*name.split(".")) for name in self.modules)
        return [*files, *(path.with_suffix(".py") for path in own)]

    def make(self) -> None:
        """Compile it, in a process that was started for that."""
        from rail_native.compiler import compile_entries

        for module in self.modules:
            importlib.import_module(f"{self.package}.{module}")
        compile_entries(self.entries.values(), self.path, sources=self.digest)


class Entry:
    """A function of a core.

    Parameters
    ----------
    core
        Whose it is.
    function
        Its plain form.
    """

    def __init__(self, core: Core, function: Callable[..., Any]) -> None:
        self._core, self.plain = core, function
        self._kinds, self._result = parameters(function), result(function)
        self._count = results(function)
        functools.update_wrapper(self, function)

    @functools.cached_property
    def _address(self) -> Any:
        call = getattr(self._core.library, self.plain.__name__)
        kinds = {float: ctypes.c_double, type(None): None}
        call.restype = kinds.get(self._result, ctypes.c_int64)
        call.argtypes = [ctypes.c_void_p] * 5
        return call

    def __call__(self, *arguments: Any) -> Any:
        """Call it once."""
        if self._count and os.environ.get(SWITCH) != "python":
            found = np.empty(self._count)
            kinds = (*self._kinds, ("results", Vector.__metadata__[0]))
            Bound(self._address, self._result, kinds, (*arguments, found))()
            return tuple(found.tolist())
        return self.bind(*arguments)()

    def bind(self, *arguments: Any) -> Callable[[], Any]:
        """Return a function without arguments that calls it with these.

        Arrays are taken by reference: what is written into them between two calls is seen. Numbers
        stay what they were.

        Raises
        ------
        TypeError
            If an array has another type or number of dimensions, or is not contiguous.
        """
        if os.environ.get(SWITCH) == "python":
            return functools.partial(_as_compiled, self.plain, *arguments)
        return Bound(self._address, self._result, self._kinds, arguments)


def _as_compiled(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a plain form where integers overflow and zeros divide as they do in a library."""
    with np.errstate(all="ignore"):
        return function(*arguments)


class Bound:
    """A call with its tables (see :mod:`rail_native.signature`)."""

    __slots__ = ("_call", "_is_bool", "_kept", "_tables")

    def __init__(self, call: Any, returns: type, kinds: Any, arguments: tuple[Any, ...]) -> None:
        whole = Group(tuple, tuple(kinds))
        self._kept = tables_of(whole, arguments)
        self._call, self._is_bool = call, returns is bool
        self._tables = tuple(table.ctypes.data for table in self._kept[:5])

    def __call__(self) -> Any:
        """Make the call."""
        found = self._call(*self._tables)
        return bool(found) if self._is_bool else found


def tables_of(kind: Group, value: Any) -> tuple[Any, ...]:
    """Return the five tables of a value, and the arrays they point to.

    Raises
    ------
    TypeError
        As :meth:`Entry.bind`.
    """
    pointers: dict[str, list[int]] = {"float64": [], "int64": []}
    sizes: list[int] = []
    reals: list[float] = []
    integers: list[int] = []
    arrays: list[np.ndarray] = []
    for of, part in leaves(kind, value):
        if isinstance(of, ArrayKind):
            good = isinstance(part, np.ndarray) and part.dtype == of.dtype and part.ndim == of.ndim
            if not good or not part.flags.c_contiguous:
                raise TypeError(f"{_described(part)} is not a contiguous array of {of}")
            arrays.append(part)
            pointers[of.dtype].append(part.__array_interface__["data"][0])
            sizes.extend(part.shape)
        elif of is float:
            reals.append(part)
        else:
            integers.append(part)
    tables = (
        np.array(pointers["float64"], dtype=np.int64),
        np.array(pointers["int64"], dtype=np.int64),
        np.array(sizes, dtype=np.int64),
        np.array(reals, dtype=np.float64),
        np.array(integers, dtype=np.int64),
    )
    return (*tables, arrays)


def _described(value: Any) -> str:
    if isinstance(value, np.ndarray):
        order = "" if value.flags.c_contiguous else ", not contiguous"
        return f"an array {value.dtype}{value.shape}{order}"
    return f"{type(value).__name__} {value!r}"
