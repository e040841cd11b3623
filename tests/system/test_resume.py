"""A run that was stopped goes on, and its numbers are those of one that was not."""

import os
import signal
import subprocess
import time

import numpy as np
import pytest
import rail_cosim
import xarray as xr
from product import PATIENCE
from rail_cosim.checkpoint import CheckpointError, checkpoint_path, records_path
from rail_cosim.errors import ParameterError, RailCosimError, RunInterrupted
from rail_cosim.runner import Quiet

COMMON = {"line": "HD", "speed": 300, "distance": 12.0, "irregularity": "german_low"}
CHANGING = ("date", "command", "wall_clock_seconds", "cpu_seconds", "real_time_factor")


class Stopping(Quiet):
    """Presses Ctrl-C after so many steps."""

    def __init__(self, after: int) -> None:
        self._after = after

    def progress(self, done: int, planned: int) -> None:
        if done >= self._after:
            self._after = 1 << 60
            raise KeyboardInterrupt


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    for name in one.variables:
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name
    assert set(one.attrs) == set(other.attrs)
    for name, value in one.attrs.items():
        assert name in CHANGING or value == other.attrs[name], name


@pytest.fixture(scope="module")
def whole():
    return rail_cosim.run(**COMMON)


def stopped(out, *, after=500, **changes):
    with pytest.raises(RunInterrupted) as caught:
        rail_cosim.run(**COMMON | changes, out=out, reporter=Stopping(after))
    assert (
        after <= caught.value.dataset.attrs["steps"] < caught.value.dataset.attrs["steps_planned"]
    )


def test_a_stopped_run_goes_on_bit_for_bit(tmp_path, whole):
    out = tmp_path / "run.nc"
    stopped(out)
    assert checkpoint_path(out).exists()
    same(whole, rail_cosim.run(**COMMON, out=out, resume=True))
    with xr.open_dataset(out, engine="h5netcdf") as written:
        same(whole, written.load())
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


ITERATIVE = {"algorithm": "iterative-gauss-seidel", "distance": 5.5, "macro_step": 2e-4}


@pytest.mark.parametrize(("changes", "after"), [({"algorithm": "jacobi"}, 500), (ITERATIVE, 100)])
def test_so_do_the_other_algorithms(tmp_path, changes, after):
    stopped(tmp_path / "run.nc", after=after, **changes)
    same(
        rail_cosim.run(**COMMON | changes),
        rail_cosim.run(**COMMON | changes, out=tmp_path / "run.nc", resume=True),
    )


def test_checkpoints_change_nothing(tmp_path, whole):
    out = tmp_path / "run.nc"
    same(whole, rail_cosim.run(**COMMON, out=out, checkpoint_interval=1e-6))


def test_a_run_until_steady_goes_on_counting(tmp_path):
    options = {"line": "HD", "speed": 300, "distance": 60.0, "until_steady": 0.01}
    out = tmp_path / "run.nc"
    with pytest.raises(RunInterrupted):
        rail_cosim.run(**options, out=out, reporter=Stopping(2900))
    same(rail_cosim.run(**options), rail_cosim.run(**options, out=out, resume=True))


def test_a_killed_run_goes_on_from_its_last_checkpoint(fmus, tmp_path, whole):
    out = tmp_path / "run.nc"
    command = ["run", "--line", "HD", "--speed", 300, "--irregularity", "german_low"]
    command += ["--distance", 12, "--out", out]
    process = fmus.start(
        *command, "--checkpoint-interval", 1e-3, stdout=subprocess.DEVNULL, text=True
    )
    end = time.monotonic() + PATIENCE
    while not checkpoint_path(out).exists():
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert records_path(out).exists()
    assert not out.exists()
    done = fmus.start(*command, "--resume", stdout=subprocess.PIPE, text=True)
    assert done.wait(PATIENCE) == 0
    with xr.open_dataset(out, engine="h5netcdf") as written:
        same(whole, written.load())
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_other_options_are_refused_by_name(tmp_path):
    out = tmp_path / "run.nc"
    stopped(out)
    with pytest.raises(ParameterError, match=r"--speed = .*begun with 300"):
        rail_cosim.run(**COMMON | {"speed": 310}, out=out, resume=True)
    with pytest.raises(ParameterError, match="--macro-step"):
        rail_cosim.run(**COMMON, macro_step=2e-4, out=out, resume=True)


def test_what_is_no_checkpoint_is_refused(tmp_path):
    out = tmp_path / "run.nc"
    with pytest.raises(CheckpointError, match="there is no"):
        rail_cosim.run(**COMMON, out=out, resume=True)
    for rubbish in (b"", b"PK\x03\x04 nothing", os.urandom(3000)):
        checkpoint_path(out).write_bytes(rubbish)
        with pytest.raises(CheckpointError, match="no checkpoint, or damaged"):
            rail_cosim.run(**COMMON, out=out, resume=True)
    with pytest.raises(ParameterError, match="--resume"):
        rail_cosim.run(**COMMON, resume=True)


def test_damage_anywhere_in_a_checkpoint_is_noticed(tmp_path):
    out = tmp_path / "run.nc"
    stopped(out)
    good = checkpoint_path(out).read_bytes()
    for place in range(40, len(good), len(good) // 6):
        bad = bytearray(good)
        bad[place] ^= 0x55
        checkpoint_path(out).write_bytes(bad)
        try:
            found = rail_cosim.run(**COMMON, out=out, resume=True)
        except RailCosimError:
            continue
        # A byte that nothing depends on, such as a date in the archive's directory.
        assert found.attrs["complete"]
        stopped(out)
