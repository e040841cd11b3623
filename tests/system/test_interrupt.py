"""Ctrl-C in the middle of a run: what was recorded is kept."""

import os
import select
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr
from product import PATIENCE

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="needs a pseudo-terminal, to see that stepping has begun"
)


def read_until(terminal: int, text: bytes) -> bytes:
    """Read a terminal until ``text`` has come."""
    seen, end = b"", time.monotonic() + PATIENCE
    while text not in seen:
        assert time.monotonic() < end, seen.decode(errors="replace")
        if select.select([terminal], [], [], 1.0)[0]:
            seen += os.read(terminal, 4096)
    return seen


def rest(terminal: int) -> bytes:
    """Read what is left when the other end is closed."""
    seen = b""
    while True:
        try:
            block = os.read(terminal, 4096)
        except OSError:  # Linux: the other end is closed
            return seen
        if not block:
            return seen
        seen += block


def interrupted(fmus, file):
    """Start a run of 50 km, press Ctrl-C when it is stepping; return status and its terminal."""
    terminal, end = os.openpty()
    process = fmus.start(
        "run", "--distance", 50e3, "--out", file, stdout=subprocess.PIPE, stderr=end, text=True
    )
    os.close(end)
    try:
        seen = read_until(terminal, b"stepping")
        records = file.with_name("run.nc.records")
        while records.stat().st_size == 0:  # the word comes just before the first step
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        seen += rest(terminal)
        out, _ = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
        process.wait()
        os.close(terminal)
    return process.returncode, (out + seen.decode(errors="replace"))


def test_ctrl_c_keeps_what_was_recorded(fmus, tmp_path):
    file = tmp_path / "run.nc"
    status, text = interrupted(fmus, file)
    assert status == 130, text
    assert "Traceback" not in text
    assert "stopped by the user" in text
    assert "marked incomplete" in text
    assert "--resume resumes there" in text
    with xr.open_dataset(file, engine="h5netcdf") as data:
        about = data.attrs
        assert about["complete"] == 0
        assert about["ended_by"].startswith("stopped by the user after ")
        assert 0 < about["steps"] < about["steps_planned"]
        assert data.sizes["time"] == about["steps"] + 1
        assert np.isfinite(data["normal_force"]).all()
    beside = ["run.nc", "run.nc.checkpoint", "run.nc.records"]
    assert sorted(path.name for path in tmp_path.iterdir()) == beside
