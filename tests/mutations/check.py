"""Make every fault of faults.toml in a copy of the sources, and see whether the tests notice.

``python tests/mutations/check.py [--only 3 7 ...] [--markdown FILE] [--workshop FOLDER]``; the
status is 1 if a fault survives, 2 if the list does not fit the sources or the tests fail without
any fault. A workshop that is kept spares compiling the sound kernels the next time.
"""

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from mutations import ROOT, Fault, StaleFaultError, faults

PACKAGES = ("fmus/common", "fmus/track", "fmus/vehicle", "master")
_LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", ".*_cache", ".hypothesis", "__pycache__", "*.nb?", "results", "build"
)
_LONGEST = 900.0
"""Time for the tests of one fault, s; a fault that makes them hang is seen, too."""


class Workshop:
    """A copy of the sources in which faults are made, with numba's cache of the sound ones."""

    def __init__(self, folder: Path) -> None:
        self.tree, self.sound = folder / "tree", folder / "numba"
        self.folder = folder
        shutil.rmtree(self.tree, ignore_errors=True)
        shutil.copytree(ROOT, self.tree, ignore=_LEFT_OUT)
        self._importers = _importers(self.tree)

    def run(self, tests: list[str], numba_cache: Path) -> tuple[int, str]:
        """Run tests on the copy; return pytest's status and what it printed."""
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(str(self.tree / p) for p in (*PACKAGES, "tests/support")),
            "PYTHONDONTWRITEBYTECODE": "1",
            "NUMBA_CACHE_DIR": str(numba_cache),
            "RAIL_COSIM_CACHE": str(self.folder / "cache"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:xdist"]
        command += ["-o", f"cache_dir={self.folder / 'pytest'}", *tests]
        try:
            done = subprocess.run(
                command, cwd=self.tree, env=environment, capture_output=True, text=True,
                timeout=_LONGEST,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return 1, f"FAILED: not ready after {_LONGEST:g} s"
        return done.returncode, done.stdout + done.stderr

    def try_fault(self, fault: Fault) -> tuple[int, str]:
        """Run the tests of a fault with the fault made; the sources are whole again after it."""
        path, cache = self.tree / fault.file, self.folder / "numba-fault"
        shutil.rmtree(cache, ignore_errors=True)
        if self.sound.is_dir():
            shutil.copytree(self.sound, cache, copy_function=os.link)
        before, text = path.stat(), fault.apply(self.tree)
        if _is_compiled(text, fault.line_in(text)):
            # Numba looks at a function's own file only: what calls it must be forgotten, too.
            for module in self._callers(path.stem):
                for index in cache.rglob(f"{module}.*.nbi"):
                    index.unlink()
        else:
            _look_unchanged(path, before)
        _forget_bytecode(path)
        try:
            return self.run(list(fault.tests), cache)
        finally:
            path.write_text(text, encoding="utf-8")
            os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
            _forget_bytecode(path)

    def _callers(self, module: str) -> set[str]:
        """Return a module and all that import it, directly or not, by their last names."""
        found, new = {module}, {module}
        while new:
            new = set().union(*(self._importers.get(name, set()) for name in new)) - found
            found |= new
        return found


def _is_compiled(text: str, line: int) -> bool:
    """Say whether a line is part of a compiled function, or of what such functions may use."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef) and node.lineno <= line + 1 <= (node.end_lineno or 0):
            return bool(
                {"entry", "kernel", "stream"} & {ast.unparse(d) for d in node.decorator_list}
            )
    return True


def _forget_bytecode(path: Path) -> None:
    """Remove what an isolated process of a test may have written: it goes by time and size."""
    for file in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
        file.unlink()


def _look_unchanged(path: Path, before: os.stat_result) -> None:
    """Give a file its old size, if it is not longer, and time: then numba keeps its kernels."""
    missing = before.st_size - path.stat().st_size
    if missing >= 0:
        with path.open("a", encoding="utf-8") as file:
            file.write("\n" * missing)
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def _importers(tree: Path) -> dict[str, set[str]]:
    """Return for each module's last name those of the modules that import from it."""
    importers: dict[str, set[str]] = {}
    for path in (tree / "fmus").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                importers.setdefault(node.module.rpartition(".")[2], set()).add(path.stem)
    return importers


def _verdict(status: int, text: str) -> tuple[str, str]:
    """Return what became of a fault, and the test that told."""
    told = [line for line in text.splitlines() if line.startswith(("FAILED", "ERROR"))]
    by = told[0].split(" - ")[0].split(maxsplit=1)[-1] if told else ""
    if status == 0:
        return "survived", ""
    if status == 1 or status < 0 or (status == 2 and told):
        return "caught", by or f"the process, with status {status}"
    return "not tested", f"pytest ended with status {status}"


def _markdown(rows: list[tuple[Fault, str, str, float]]) -> str:
    lines = ["| # | file | fault | found by |", "|---|---|---|---|"]
    for fault, verdict, by, _ in rows:
        name = f"`{by.rpartition('/')[2]}`" if verdict == "caught" else f"**{verdict}**"
        where = fault.file.partition("/")[2]
        lines.append(f"| {fault.number} | `{where}` | {fault.breaks} | {name} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", type=int, nargs="+", help="numbers of the faults to make")
    parser.add_argument("--markdown", type=Path, help="write the results as a table")
    parser.add_argument("--workshop", type=Path, help="folder for the copy, kept for the next time")
    options = parser.parse_args()
    chosen = [f for f in faults() if not options.only or f.number in options.only]
    for fault in chosen:
        try:
            fault.line(ROOT)
            fault.check_tests(ROOT)
        except StaleFaultError as error:
            print(error, file=sys.stderr)
            return 2
    with tempfile.TemporaryDirectory(prefix="mutations_") as folder:
        workshop = Workshop(options.workshop.absolute() if options.workshop else Path(folder))
        tests = sorted({test for fault in chosen for test in fault.tests})
        start = time.monotonic()
        status, text = workshop.run(tests, workshop.sound)
        if status:
            print(f"the tests fail without any fault:\n{text}", file=sys.stderr)
            return 2
        print(f"without any fault: passed in {time.monotonic() - start:.0f} s", flush=True)
        rows = []
        for fault in chosen:
            start = time.monotonic()
            verdict, by = _verdict(*workshop.try_fault(fault))
            rows.append((fault, verdict, by, time.monotonic() - start))
            print(f"{fault.number:3} {verdict:10} {rows[-1][3]:5.0f} s  {fault.breaks}: {by}",
                  flush=True)  # fmt: skip
    if options.markdown:
        options.markdown.write_text(_markdown(rows), encoding="utf-8")
    missed = [fault.number for fault, verdict, _, _ in rows if verdict != "caught"]
    print(
        f"{len(rows) - len(missed)} of {len(rows)} caught", *(["missed:", *missed] * bool(missed))
    )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
