"""The slave in a host that is not Python: no crash at the end, cheap calls."""

import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest
from fmi_builds import SUPPORT, folder, mass_spring_fmu
from product import PATIENCE

LIBRARY = Path(
    sysconfig.get_config_var("LIBDIR") or "", sysconfig.get_config_var("LDLIBRARY") or "missing"
)

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux")
    or shutil.which("cc") is None
    or LIBRARY.suffix != ".so"
    or not LIBRARY.is_file(),
    reason="needs Linux, a C compiler and a shared Python library",
)


@pytest.fixture(scope="module")
def host():
    program = folder() / "c_host"
    source = SUPPORT / "c_host.c"
    subprocess.run(["cc", "-O1", "-Wall", "-o", program, source, "-ldl"], check=True)
    place = folder() / "for_c_host"
    with zipfile.ZipFile(mass_spring_fmu()) as archive:
        archive.extractall(place)

    def run(
        steps: int,
        bad_text: bool = False,
        logging: bool = True,
        mass: float = 0.0,
        before: Sequence[str] = (),
        **environment: str,
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [
                *before,
                program,
                place / "binaries" / "linux64" / "MassSpring.so",
                (place / "resources").as_uri(),
                str(steps),
                str(int(bad_text)),
                str(int(logging)),
                str(mass),
            ],
            env=os.environ
            | {
                "LD_PRELOAD": str(LIBRARY),
                "PYTHONHOME": sys.base_prefix,
                "PYTHONPATH": sysconfig.get_path("purelib"),
                "RAIL_COSIM_CACHE": str(folder() / "cache"),
            }
            | environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )

    return run


def test_runs_and_ends_without_a_crash(host):
    done = host(50)
    assert done.returncode == 0, done.stderr
    status, force, mass, stiffness, _, left = done.stdout.split()
    assert (status, left) == ("0", "0")
    assert (float(force), float(mass), float(stiffness)) == (1.0, 100.0, 1.0e4)
    assert "started at 100 %" in done.stderr


def test_text_that_is_not_utf8_is_an_error(host):
    done = host(1, bad_text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("4 ")
    assert "is not UTF-8" in done.stderr


@pytest.mark.parametrize("logging", [False, True])
def test_refused_parameter_is_a_status_and_a_text(host, logging):
    """A host that goes on all the same, and frees the instance, does not crash."""
    done = host(3, logging=logging, mass=-1.0)
    assert done.returncode == 0, done.stderr
    assert (done.stdout.split()[0], done.stdout.split()[-1]) == ("4", "4")
    reason = "MassSpring (c host): mass = -1.0: must be from 0 to 1e+06 kg"
    assert done.stderr.count(reason) == (4 if logging else 1), done.stderr


def test_calls_keep_the_thread_state(host):
    """Making one costs some 10 us, which is paid once and not in every call."""
    done = host(50)
    assert done.stderr.count("first step of a thread state") == 1


# glibc's loader reads paths eight bytes at a time, in the last one beyond their end.
KNOWN = """
{
   loader
   Memcheck:Addr8
   fun:strncmp
   fun:is_dst
}
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="needs valgrind")
def test_valgrind_finds_no_wrong_use_of_memory(host, tmp_path):
    """No access to freed memory and no double free, from the load to the end of the process.

    Whether values are initialised is not asked: Python's own import code raises false alarms.
    """
    known = tmp_path / "known.supp"
    known.write_text(KNOWN)
    options = ["--leak-check=no", "--undef-value-errors=no", "--error-exitcode=99", "-q"]
    done = host(
        20,
        bad_text=True,  # 19 steps, and errors in two calls
        before=["valgrind", *options, f"--suppressions={known}"],
        PYTHONMALLOC="malloc",  # Python's own pools would hide it
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("4 ")
