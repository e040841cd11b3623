"""The examples as a reader starts them, over short distances: what they print and leave behind.

Those of a vehicle of one's own and of the FMUs alone have test files of their own.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from product import PATIENCE

EXAMPLES = Path(__file__).parents[2] / "examples"
LOAD = 69.21  # kN, of a wheel at rest


@pytest.fixture
def example(fmus, tmp_path):
    """Return a function that runs an example in a folder of its own and gives what it prints."""

    def run(name, *arguments):
        done = subprocess.run(
            [sys.executable, EXAMPLES / name, *map(str, arguments)],
            env=fmus.environment(),
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def numbers(pattern, text):
    """Return the groups of all matches as numbers."""
    found = re.findall(pattern.replace("#", r"(-?\d+\.?\d*)"), text)
    assert found, text
    return [tuple(map(float, one if isinstance(one, tuple) else (one,))) for one in found]


def test_all_examples_are_short_and_listed():
    scripts = sorted(EXAMPLES.glob("*.py"))
    listed = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert len(scripts) >= 6
    for script in scripts:
        assert len(script.read_text().splitlines()) < 60
        assert f"({script.name})" in listed


def test_nominal_run(example, tmp_path):
    text = example("nominal_run.py", 20)
    wheels = numbers(r"wheelset #: mean # kN, at # Hz \+- # N", text)
    assert [wheel[0] for wheel in wheels] == [1, 2, 3, 4]
    for _, mean, frequency, amplitude in wheels:
        assert mean == pytest.approx(LOAD, rel=1e-3)
        assert frequency == pytest.approx(300 / 3.6 / 0.629, abs=0.05)
        assert 800 < amplitude < 1600  # 1.2 kN in the steady state
    with xr.open_dataset(tmp_path / "nominal_run.nc", engine="h5netcdf") as data:
        assert data.sizes["wheelset"] == 4
    assert (tmp_path / "nominal_run.png").stat().st_size > 10_000


def test_winter_pads(example):
    """Frozen pads at the speed of their resonance: more than ten times as much."""
    text = example("winter_pads.py", 20)
    assert "summer: 40 MN/m, 75.1 Hz" in text
    assert "winter: 140 MN/m, 75.1 Hz" in text
    ((ratio,),) = numbers("winter is # times summer", text)
    assert ratio > 8


def test_rail_joint(example):
    text = example("rail_joint.py", 14)
    ((at_rest,),) = numbers("at rest # kN", text)
    ((largest, place),) = numbers("largest # kN at # m", text)
    ((factor,),) = numbers("dynamic factor #", text)
    assert at_rest == pytest.approx(LOAD, rel=1e-3)
    assert factor == pytest.approx(largest / at_rest, abs=1e-3)
    assert factor > 2.0
    assert 12.0 < place < 13.1  # at mid-span, 12.58 m


def test_own_irregularity(example, tmp_path):
    text = example("own_irregularity.py", 20)
    smooth, dip = numbers(r": # to # kN, largest at # m", text)
    assert (tmp_path / "my_line.csv").exists()
    assert smooth[1] < 1.05 * LOAD
    assert dip[1] > 1.2 * LOAD
    assert dip[0] < 0.85 * LOAD
    assert 10.0 < dip[2] < 13.5  # the dip goes from 10 to 13 m


def test_sweep(example, tmp_path):
    text = example("sweep_pads.py", 6)
    summer, winter = numbers(r"# MN/m: largest # m/s2 at # km/h", text)
    assert (summer[0], winter[0]) == (40, 140)
    assert winter[1] > 3 * summer[1]
    assert winter[2] == 170
    assert (tmp_path / "sweep_pads.png").stat().st_size > 10_000
    with xr.open_dataset(tmp_path / "sweep_pads.nc", engine="h5netcdf") as data:
        assert (data["error"] == "").all()


def test_track_component(example):
    text = example("track_component.py")
    (summer, winter) = numbers(r"# nm/N over a fastener, # between", text)
    assert summer[0] < summer[1]
    assert winter[0] < winter[1]
    # A beam on springs gives 1/(2 sqrt 2 (E I)^(1/4) k^(3/4)) per rail. The pads are in series with
    # the layer and the slab, which the stiffer pads leave a larger share of: less than 3.5^(3/4).
    assert 2.0 < summer[0] / winter[0] < 3.5**0.75
    bending, foundation = 2.059e11 * 3.217e-5, 40e6 / 0.629
    beam = 1e9 / (2 * 2**0.5 * bending**0.25 * foundation**0.75)
    assert summer[0] == pytest.approx(beam, rel=0.1)
    softest = [value for (value,) in numbers("softest at # Hz", text)]
    assert softest[0] < softest[1]
