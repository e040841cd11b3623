"""Records on disk: what is read is what was written, and nothing is lost by a full disk."""

import resource
import signal
import sys

import numpy as np
import pytest
from rail_cosim.errors import ResultsError
from rail_cosim.spool import Spool

ROWS = np.arange(60.0).reshape(20, 3)


def test_rows_come_back_as_they_were(tmp_path):
    spool = Spool(tmp_path / "r", 3)
    spool.append(ROWS[:7])
    spool.append(ROWS[7:])
    assert len(spool) == 20
    assert np.array_equal(spool.rows(0, 20), ROWS)
    assert np.array_equal(spool.rows(5, 9), ROWS[5:9])
    assert spool.rows(4, 4).shape == (0, 3)


def test_going_on_drops_the_rows_after_the_checkpoint(tmp_path):
    first = Spool(tmp_path / "r", 3)
    first.append(ROWS)
    first.close()
    second = Spool(tmp_path / "r", 3, rows=11)
    second.append(-ROWS[:2])
    assert np.array_equal(second.rows(0, 13), np.concatenate([ROWS[:11], -ROWS[:2]]))


def test_a_new_spool_is_empty_whatever_lay_there(tmp_path):
    (tmp_path / "r").write_bytes(b"x" * 1000)
    assert len(Spool(tmp_path / "r", 3)) == 0
    assert (tmp_path / "r").stat().st_size == 0


def test_a_file_that_is_too_short_is_refused(tmp_path):
    (tmp_path / "r").write_bytes(bytes(8 * 3 * 4))
    with pytest.raises(ResultsError, match="fewer than the 5 records"):
        Spool(tmp_path / "r", 3, rows=5)


@pytest.mark.skipif(sys.platform == "win32", reason="locks are those of POSIX")
def test_two_runs_do_not_write_into_one_file(tmp_path):
    spool = Spool(tmp_path / "r", 3)
    spool.append(ROWS)
    with pytest.raises(ResultsError, match="another run is writing there"):
        Spool(tmp_path / "r", 3)
    assert np.array_equal(spool.rows(0, 20), ROWS)


@pytest.mark.skipif(sys.platform == "win32", reason="limits are those of POSIX")
def test_a_full_disk_leaves_what_was_there(tmp_path):
    spool = Spool(tmp_path / "r", 3)
    spool.append(ROWS)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (24 * 25, before[1]))
        with pytest.raises(ResultsError, match="could not be written"):
            spool.append(ROWS)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert len(spool) == 20
    spool.append(ROWS[:1])
    assert np.array_equal(spool.rows(0, 21), np.concatenate([ROWS, ROWS[:1]]))
