"""Cost of the parts of the track's step."""

import json
import subprocess
import sys

import pytest

PARTS = {"rails", "contact", "slide"}


def cost(*arguments):
    command = [sys.executable, "-m", "slab_track.cost", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_parts_make_up_the_step():
    done = cost("--json")
    assert done.returncode == 0, done.stderr
    values = json.loads(done.stdout)
    assert values.keys() == PARTS | {"total", "slide_each", "slide_share"}
    assert all(values[name] > 0.0 for name in PARTS)
    assert sum(values[name] for name in PARTS) == pytest.approx(values["total"])
    # 604 steps of 8.33 mm from slide to slide.
    assert values["slide_each"] == pytest.approx(603.84 * values["slide"])
    assert values["slide_share"] == pytest.approx(values["slide"] / values["total"])
    assert values["rails"] > values["contact"]


def test_refusals():
    wrong = cost("--track", "fastener.spacing=-1")
    assert wrong.returncode == 2
    assert "fastener.spacing" in wrong.stderr
    short = cost("--track", "window.slab_count=5")
    assert short.returncode == 1
    assert "window.slab_count" in short.stderr
