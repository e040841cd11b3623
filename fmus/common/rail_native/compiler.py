"""Entries of a core -> shared library: numba's LLVM, optimised for the target, linked by ``cc``.

Only public interfaces are used: ``numba.njit`` for the kernels, one ``numba.cfunc`` per entry that
wraps raw pointers by ``numba.carray``, its ``inspect_llvm``, and ``llvmlite.binding``. In one
module, with all but the entries internal, the optimiser removes every count of a reference and
every call of Python; what it leaves is refused (:func:`_check_symbols`). Memory comes from the
caller.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false

import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from rail_native.errors import CompileError
from rail_native.signature import ArrayKind, Group, Leaf, parameters, result, results

_COUNTING = re.compile(
    r"define linkonce_odr void @(NRT_(?:in|de)cref)\(([^)]*)\)[^{]*\{.*?\n\}", re.DOTALL
)
_NO_COUNTING = r"define linkonce_odr void @\1(\2) alwaysinline {\n  ret void\n}"
"""Counting of references: arrays over raw pointers have none, and kernels make no others."""

LEVELS = {"x86_64": ("x86-64-v3",), "aarch64": ("generic",), "arm64": ("generic",)}
"""Processors that a library holds code for, the least demanding first."""

_ALLOWED = ("sin", "cos", "tan", "atan", "atan2", "exp", "log", "pow", "cbrt", "floor", "ceil")
_ALLOWED += ("fmod", "memcpy", "memset", "memmove", "sincos", "hypot", "asin", "acos", "sqrt")


def has_linker() -> bool:
    """Whether a C compiler is there without the package ``ziglang``."""
    return bool(os.environ.get("CC") or shutil.which("cc"))


def linker() -> list[str]:
    """Return the command of a C compiler: ``CC``, the system's ``cc``, or PyPI's ``ziglang``.

    Raises
    ------
    CompileError
        If there is none.
    """
    if os.environ.get("CC"):
        return os.environ["CC"].split()
    if shutil.which("cc"):
        return ["cc"]
    try:
        import ziglang  # noqa: F401
    except ImportError:
        raise CompileError(
            "no C compiler: neither CC, nor cc, nor the package ziglang. Remedy: install the "
            "system's C compiler, or: pip install ziglang"
        ) from None
    return [sys.executable, "-m", "ziglang", "cc"]


def compile_entries(
    entries: Iterable[Callable[..., Any]], target: Path, *, sources: str = ""
) -> None:
    """Compile plain functions, by the names they have, into the shared library ``target``.

    Parameters
    ----------
    entries
        Functions whose kernels were made with numba (see :mod:`rail_native.kernels`).
    target
        The library; it is put in place by one rename.
    sources
        Digest of what it is made from; the library tells it.

    Raises
    ------
    CompileError
        If a function cannot be compiled without Python, or the linker fails.
    """
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    # Loops over many arrays: looking whether any two overlap costs less than going without vectors.
    llvm.set_option("", "--runtime-memory-check-threshold=256")
    triple = llvm.get_process_triple()
    machine = triple.partition("-")[0]
    levels = LEVELS[machine]
    entries = list(entries)
    text = {entry.__name__: _llvm_of(entry) for entry in entries}
    with tempfile.TemporaryDirectory(prefix="rail_native_") as folder:
        objects: list[Path] = []
        for level in levels:
            module = _linked(llvm, text, suffix=_suffix(level))
            objects.append(Path(folder, f"{_suffix(level)}.o"))
            objects[-1].write_bytes(_object_of(llvm, module, triple, level))
        source = Path(folder, "interface.c")
        source.write_text(_interface_source(entries, levels, sources), encoding="utf-8")
        objects.append(source)
        _link([*map(str, objects)], target)


def compile_c(source: Path, target: Path, *, sources: str) -> None:
    """Compile a C file into the shared library ``target``; ``sources`` is its digest.

    Raises
    ------
    CompileError
        If the compiler fails.
    """
    with tempfile.TemporaryDirectory(prefix="rail_native_") as folder:
        told = Path(folder, "sources.c")
        told.write_text(f'const char *rail_native_sources = "{sources}";\n', encoding="utf-8")
        _link([str(source), str(told)], target)


def _link(files: list[str], target: Path) -> None:
    """Compile and link files into a shared library, which is put in place by one rename."""
    part = target.with_name(f".{target.name}.{os.getpid()}")
    command = [*linker(), "-shared", "-fPIC", "-O2", *files, "-o", str(part), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise CompileError(f"{' '.join(command)}\n{done.stderr.strip()}")
    part.replace(target)


def _suffix(level: str) -> str:
    return "_" + level.replace("-", "_")


def _llvm_of(entry: Callable[..., Any]) -> tuple[str, str]:
    """Return the LLVM of an entry with raw pointers, and the name it has there."""
    import numba
    from numba import types

    tables = [
        types.CPointer(types.CPointer(types.float64)),
        types.CPointer(types.CPointer(types.int64)),
        types.CPointer(types.int64),
        types.CPointer(types.float64),
        types.CPointer(types.int64),
    ]
    kinds = {float: types.float64, int: types.int64, bool: types.int64, type(None): types.void}
    names: dict[str, Any] = {"carray": numba.carray, "entry": entry}
    builder = _Arguments(names)
    arguments = [builder.expression(kind) for _, kind in parameters(entry)]
    source = "def exported(reals_of, integers_of, sizes, reals, integers):\n    found = entry(\n"
    source += "".join(f"        {argument},\n" for argument in arguments) + "    )\n"
    if count := results(entry):
        source += f"    results = {builder.expression(ArrayKind('float64', 1))}\n"
        source += "".join(f"    results[{i}] = found[{i}]\n" for i in range(count))
    else:
        source += "    return found\n"
    exec(compile(source, f"<{entry.__name__}>", "exec"), names)
    made: Any = numba.cfunc(kinds[result(entry)](*tables), error_model="numpy")(names["exported"])
    return _COUNTING.sub(_NO_COUNTING, made.inspect_llvm()), made.native_name


class _Arguments:
    """Source text that takes an entry's arguments from the five tables."""

    def __init__(self, names: dict[str, Any]) -> None:
        self._names = names
        self._counters = {
            name: itertools.count()
            for name in ("reals_of", "integers_of", "sizes", "reals", "integers")
        }

    def _next(self, table: str) -> str:
        return f"{table}[{next(self._counters[table])}]"

    def expression(self, kind: Leaf | Group) -> str:
        """Return what makes an argument."""
        if isinstance(kind, Group):
            name = f"Group{len(self._names)}"
            self._names[name] = kind.kind
            return f"{name}({', '.join(self.expression(of) for _, of in kind.fields)})"
        if isinstance(kind, ArrayKind):
            table = "reals_of" if kind.dtype == "float64" else "integers_of"
            sizes = "".join(f"{self._next('sizes')}, " for _ in range(kind.ndim))
            return f"carray({self._next(table)}, ({sizes}))"
        if kind is float:
            return self._next("reals")
        return self._next("integers") + (" != 0" if kind is bool else "")


def _linked(llvm: Any, text: dict[str, tuple[str, str]], suffix: str) -> Any:
    """Return one module with all entries, everything else internal."""
    whole = None
    for code, _ in text.values():
        module = llvm.parse_assembly(code)
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    exported = {name: own for own, (_, name) in text.items()}
    for function in whole.functions:
        if function.name in exported:
            function.name = exported[function.name] + suffix
            function.linkage = "external"
        elif not function.is_declaration:
            function.linkage = "internal"
    for variable in whole.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    return whole


def _object_of(llvm: Any, module: Any, triple: str, level: str) -> bytes:
    """Optimise a module for a processor and return its object code."""
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=level, opt=3, reloc="pic", codemodel="default"
    )
    module.triple = triple
    module.data_layout = str(machine.target_data)
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization = True  # SLP: asserts in LLVM 22, and gained nothing
    builder = llvm.create_pass_builder(machine, tuning)
    for _ in range(2):  # once more for what only then is seen: that no call ever fails
        builder.getModulePassManager().run(module, builder)
    module.verify()
    _check_symbols(module)
    return machine.emit_object(module)


def _check_symbols(module: Any) -> None:
    """Refuse code that needs more than a C library."""
    foreign = sorted(
        f.name
        for f in module.functions
        if f.is_declaration and not f.name.startswith("llvm.") and f.name not in _ALLOWED
    )
    if not foreign:
        return
    where = {
        function.name
        for function in module.functions
        if not function.is_declaration and any(f"@{name}(" in str(function) for name in foreign)
    }
    raise CompileError(
        f"{', '.join(sorted(where))} need Python or numba's run time: {', '.join(foreign)}. "
        "Kernels are loops over arrays and numbers: no new arrays, no exceptions, no objects"
    )


def _interface_source(
    entries: list[Callable[..., Any]], levels: tuple[str, ...], sources: str
) -> str:
    """Return C that exports the entries and chooses the code for the processor at hand."""
    kinds = {float: "double", int: "int64_t", bool: "int64_t", type(None): "void"}
    table = "(double **a, int64_t **b, int64_t *c, double *d, int64_t *e)"
    lines = ["#include <stdint.h>", f'const char *rail_native_sources = "{sources}";']
    for entry in entries:
        kind, name = kinds[result(entry)], entry.__name__
        best, least = (f"{name}{_suffix(level)}" for level in (levels[-1], levels[0]))
        call = "(a, b, c, d, e)"
        lines += [f"{kind} {symbol}{table};" for symbol in dict.fromkeys((best, least))]
        if best == least:
            lines.append(f"{kind} {name}{table} {{ return {best}{call}; }}")
        else:
            choice = '__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")'
            lines.append(
                f"{kind} {name}{table} {{ return {choice} ? {best}{call} : {least}{call}; }}"
            )
    return "\n".join(lines) + "\n"
