"""``python -m rail_native PACKAGE ...``: compile the cores of packages that are not fresh."""

import importlib
import os
import subprocess
import sys

from rail_native.core import COMPILING, Library
from rail_native.errors import NativeError

# Numba shall know nothing of this machine's processor and optimise nothing: that is done once, for
# all entries together and for each target.
_ENVIRONMENT = {
    COMPILING: "1",
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NUMBA_OPT": "0",
}


# The path as it is here: an isolated build's is not that of a new process.
_CHILD = """import sys
sys.path[:] = sys.argv[2:]
from rail_native.__main__ import compile_here
compile_here(sys.argv[1])"""


def core_of(package: str) -> Library:
    """Return the core of a package: ``core`` in its module ``core``."""
    return importlib.import_module(f"{package}.core").core


def make(package: str) -> bool:
    """Compile the core of a package in a process of its own; False if it is fresh.

    Raises
    ------
    NativeError
        With what the compiler said.
    """
    core = core_of(package)
    if is_fresh(core):
        return False
    done = subprocess.run(
        [sys.executable, "-c", _CHILD, package, *sys.path],
        env=os.environ | _ENVIRONMENT,
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        raise NativeError(f"the core of {package} could not be compiled:\n{done.stderr.strip()}")
    return True


def is_fresh(core: Library) -> bool:
    """Tell whether there is a library, made from the present sources."""
    return core.path.is_file() and core.digest.encode() in core.path.read_bytes()


def compile_here(package: str) -> None:
    """Compile, in a process that was started for it."""
    core = core_of(package)
    core.path.parent.mkdir(exist_ok=True)
    core.make()


def main(arguments: list[str]) -> int:
    """Compile what is asked for; return the exit status."""
    if not arguments or arguments[0].startswith("-"):
        print("usage: python -m rail_native PACKAGE ...", file=sys.stderr)
        return 2
    for package in arguments:
        try:
            print(f"{package}: {'compiled' if make(package) else 'up to date'}")
        except (NativeError, ImportError) as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
