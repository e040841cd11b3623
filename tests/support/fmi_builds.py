"""FMUs for the tests, each built once, and processes to run them in."""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
import textwrap
from functools import cache
from pathlib import Path

import pytest
from product import PATIENCE
from rail_fmi.builder import build_fmu

SUPPORT = Path(__file__).parent
PACKAGES = ("rail_fmi", "rail_quantities", "mass_spring")

SECOND_ENTRY = '''
"""A second FMU on the same base."""
from rail_fmi import RailSlave, Variable


class Doubler(RailSlave):
    MODEL_NAME = "Doubler"

    def declare(self):
        return [Variable("u", causality="input"), Variable("y", causality="output")]

    def step(self, time, step_size):
        self.reals[1] = 2.0 * self.reals[0]
'''


@cache
def folder() -> Path:
    """Return a folder for this process's builds, removed at its end."""
    made = Path(tempfile.mkdtemp(prefix="fmi_builds_"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return made


@cache
def mass_spring_fmu() -> Path:
    return build_fmu(SUPPORT / "mass_spring_fmu.py", PACKAGES, folder())


@cache
def doubler_fmu() -> Path:
    script = folder() / "doubler_fmu.py"
    script.write_text(SECOND_ENTRY)
    return build_fmu(script, PACKAGES[:2], folder())


def run_host(
    code: str,
    *arguments: object,
    paths: tuple[object, ...] = (),
    bound: bool = False,
    **environment: str,
) -> str:
    """Run code in a process that has none of our packages, and return what it prints.

    Exit status 0 is demanded, so a crash at the end counts.
    """
    done = run_process(code, *arguments, paths=paths, bound=bound, **environment)
    assert done.returncode == 0, f"exit status {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def run_process(
    code: str,
    *arguments: object,
    paths: tuple[object, ...] = (),
    bound: bool = False,
    **environment: str,
) -> subprocess.CompletedProcess[str]:
    """Run code as :func:`run_host` does, whatever its exit status.

    With ``bound`` a root user is held to the files' permissions like anyone else.
    """
    root = bound and os.geteuid() == 0
    if root and shutil.which("setpriv") is None:
        pytest.skip("root may do all, and there is no setpriv to bound it")
    before = ["setpriv", "--bounding-set=-dac_override", "--"] if root else []
    search = os.pathsep.join(map(str, [*paths, SUPPORT]))
    return subprocess.run(
        [
            *before,
            sys.executable,
            "-X",
            "faulthandler",
            "-c",
            textwrap.dedent(code),
            *map(str, arguments),
        ],
        env=os.environ
        | {"PYTHONPATH": search, "RAIL_COSIM_CACHE": str(folder() / "cache")}
        | environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
