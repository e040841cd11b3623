"""The product as its user has it: built FMUs, the command line, and processes to run them in.

Most runs in processes of its own: a crash, also one at the end, is then a failed test, and no test
sees modules that another has loaded. Runs whose results alone are looked at are made in this one.
"""

import dataclasses
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

from typer.testing import CliRunner

PATIENCE = 3600.0
"""After this a process counts as hanging, s: far from what any takes on the busiest machine."""

_COMMAND = "import sys; from rail_cosim.cli import main; sys.argv[0] = 'rail-cosim'; main()"
_CALL = """
import importlib, pickle, sys
_, request, answer_file = sys.argv
with open(request, "rb") as file:
    module, name, arguments, keywords = pickle.load(file)
answer = getattr(importlib.import_module(module), name)(*arguments, **keywords)
with open(answer_file, "wb") as file:
    pickle.dump(answer, file)
"""


def _hear_ctrl_c() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@dataclasses.dataclass(frozen=True)
class Product:
    """Both FMUs, and the command line with the same cache."""

    folder: Path
    cache: Path

    @property
    def vehicle(self) -> Path:
        return self.folder / "HighSpeedVehicle.fmu"

    @property
    def track(self) -> Path:
        return self.folder / "InfiniteSlabTrack.fmu"

    @property
    def both(self) -> tuple[Path, Path]:
        return self.vehicle, self.track

    def environment(self) -> dict[str, str]:
        """Return an environment in which a process finds what this one finds."""
        return os.environ | {
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
            "RAIL_COSIM_CACHE": str(self.cache),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "COLUMNS": "100",
        }

    def start(self, *arguments: object, **keywords: Any) -> subprocess.Popen:
        """Start ``rail-cosim`` with these arguments."""
        command = [sys.executable, "-X", "faulthandler", "-c", _COMMAND, *map(str, arguments)]
        if hasattr(os, "posix_spawn"):  # tests in a shell's background are deaf to Ctrl-C
            keywords.setdefault("preexec_fn", _hear_ctrl_c)
        return subprocess.Popen(command, env=self.environment(), **keywords)

    def command(
        self, *arguments: object, status: tuple[int, ...] = (0,)
    ) -> subprocess.CompletedProcess[str]:
        """Run ``rail-cosim`` and demand one of these exit statuses."""
        pipe = subprocess.PIPE
        with self.start(*arguments, stdout=pipe, stderr=pipe, text=True) as process:
            try:
                out, err = process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
        assert process.returncode in status, f"exit status {process.returncode}\n{out}\n{err}"
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def invoke(
        self, *arguments: object, status: tuple[int, ...] = (0,)
    ) -> subprocess.CompletedProcess[str]:
        """Do as :meth:`command` in this process, which spares it a new one's imports."""
        from rail_cosim.cli.application import app

        words = [str(argument) for argument in arguments]
        runner = CliRunner(env={"RAIL_COSIM_CACHE": str(self.cache), "COLUMNS": "100"})
        with mock.patch.object(sys, "argv", ["rail-cosim", *words]):
            done = runner.invoke(app, words, prog_name="rail-cosim")
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        out, err = done.stdout, done.stderr
        assert done.exit_code in status, f"exit status {done.exit_code}\n{out}\n{err}"
        return subprocess.CompletedProcess(words, done.exit_code, out, err)

    def call(self, function: Callable, *arguments: Any, **keywords: Any) -> Any:
        """Call a function of a support module in a new process, which must end with status 0."""
        with tempfile.TemporaryDirectory(prefix="call_") as folder:
            request, answer = Path(folder, "request"), Path(folder, "answer")
            what = (function.__module__, function.__name__, arguments, keywords)
            request.write_bytes(pickle.dumps(what))
            done = subprocess.run(
                [sys.executable, "-X", "faulthandler", "-c", _CALL, str(request), str(answer)],
                env=self.environment(),
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            assert done.returncode == 0, f"exit status {done.returncode}\n{done.stderr}"
            return pickle.loads(answer.read_bytes())


def build(folder: Path, cache: Path) -> Product:
    """Build the FMUs into ``folder`` as a user does; unchanged ones come from the cache."""
    product = Product(folder, cache)
    product.command("build", "--out", folder)
    return product
