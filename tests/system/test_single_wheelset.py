"""The example of a vehicle of one's own: one wheelset, on our track."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from described_fmus import FORCES, MOTION
from runs import GOLDEN, run

EXAMPLE = Path(__file__).parents[2] / "examples" / "single_wheelset"
PITCH = 8 * 0.629
CONSTANT_LOAD = [
    *("--set", "vehicle.suspension.vertical_stiffness=0"),
    *("--set", "vehicle.suspension.vertical_damping=0"),
]


@pytest.fixture(scope="module")
def wheelset(fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("example")
    command = [sys.executable, EXAMPLE / "build.py", folder]
    subprocess.run(command, env=fmus.environment(), check=True)
    return folder / "SingleWheelset.fmu"


def test_it_satisfies_the_contract(fmus, wheelset):
    done = fmus.command("check", wheelset)
    assert "is a vehicle with 1 wheelset and satisfies the contract" in done.stdout


def test_it_is_announced_before_it_runs_unless_it_is_trusted(fmus, wheelset):
    options = ["run", "--vehicle", wheelset, "--distance", 0.1]
    assert f"{wheelset} was not built here. It is a program" in fmus.command(*options).stderr
    assert "InfiniteSlabTrack" not in fmus.command(*options).stderr
    assert fmus.command(*options, "--trust").stderr == ""


def test_another_count_than_the_vehicles_is_refused(fmus, wheelset):
    options = ["--vehicle", wheelset, "--set", "track.wheelset_count=4", "--distance", 1]
    done = fmus.invoke("run", *options, status=(2,))
    assert "track.wheelset_count = 4: the vehicle FMU has 1 wheelset; omit it" in done.stderr


def test_amplitude_is_that_of_the_finite_element_track(fmus, wheelset, tmp_path):
    """Under a constant load, against the single wheel of the independent track."""
    options = ["--vehicle", wheelset, *CONSTANT_LOAD]
    contact = ["--set", "track.contact.hertz_constant=4.221e-8"]
    done = run(fmus, tmp_path, *options, *contact, "--distance", 9 * PITCH)
    assert done["normal_force"].shape[1:] == (1, 2)
    assert done.data.attrs["track.wheelset_count"] == 1
    assert len(done.slides) >= 5
    found = done.amplitude("normal_force", PITCH)
    assert found == pytest.approx(_golden(300.0, 40e6), rel=0.01)


def _golden(speed_kmh, pad_stiffness):
    wanted = ("single_wheel", speed_kmh, pad_stiffness, 52e3)
    keys = ("vehicle", "speed_kmh", "pad_stiffness", "pad_damping")
    (case,) = [
        case
        for case in json.loads(GOLDEN.read_text())["cases"]
        if tuple(case[key] for key in keys) == wanted
    ]
    return case["wheel_force_amplitude"][0]


def test_on_its_suspension_it_carries_the_same_load(fmus, wheelset, tmp_path):
    """Gauss-Seidel and Jacobi agree, and the mean force is the static load."""
    options = ["--vehicle", wheelset, "--distance", 4 * PITCH]
    forces = []
    for algorithm in ("gauss-seidel", "jacobi"):
        folder = tmp_path / algorithm
        folder.mkdir()
        forces.append(run(fmus, folder, *options, "--algorithm", algorithm)["normal_force"])
    load = 0.5 * 9.81 * (1881.0 + 12229.0)
    assert forces[0][-600:].mean() == pytest.approx(load, rel=1e-3)
    swing = np.ptp(forces[0][-600:])
    assert np.abs(forces[0] - forces[1])[-600:].max() < 0.02 * swing


FOREIGN = {  # the same wheelset by other names, its height up in mm, the force up in kN
    'W = "wheelset[1]."': 'W = "ws1_"',
    'f"{W}contact.{name}"': 'f"{W}{name}"',
    '{W}contact.vertical_force"] +': '{W}vertical_force"] * -1e3 +',
    "start=-2.0 * load if": "start=2e-3 * load if",
    'f"{W}vertical_displacement"] = float(': 'f"{W}vertical_displacement"] = -1e3 * float(',
    "    speed: float": "    v0: float",
    "p.speed": "p.v0",
    "SingleWheelset": "Foreign",
}
NAMES = """
[names]
speed = "v0"
"wheelset[{i}].initial_vertical_displacement" = "ws{i}_initial_vertical_displacement"
"wheelset[{i}].vertical_displacement" = { name = "ws{i}_vertical_displacement", factor = -1e-3 }
"wheelset[{i}].contact.vertical_force" = { name = "ws{i}_vertical_force", factor = -1e3 }
"""


@pytest.fixture(scope="module")
def foreign(fmus, tmp_path_factory):
    """Build a copy of the example whose variables have names, signs and units of their own."""
    folder = tmp_path_factory.mktemp("foreign")
    script = (EXAMPLE / "single_wheelset_fmu.py").read_text(encoding="utf-8")
    for ours, theirs in FOREIGN.items():
        assert ours in script
        script = script.replace(ours, theirs)
    (folder / "single_wheelset_fmu.py").write_text(script, encoding="utf-8")
    build = (EXAMPLE / "build.py").read_text(encoding="utf-8")
    (folder / "build.py").write_text(build, encoding="utf-8")
    command = [sys.executable, folder / "build.py", folder]
    subprocess.run(command, env=fmus.environment(), check=True)
    lines = [
        f'"wheelset[{{i}}].{name}" = "ws{{i}}_{name}"'
        for name in MOTION
        if name != "vertical_displacement"
    ]
    lines += [
        f'"wheelset[{{i}}].{name}" = "ws{{i}}_{name.removeprefix("contact.")}"'
        for name in FORCES
        if name != "contact.vertical_force"
    ]
    (folder / "names.toml").write_text("\n".join([NAMES, *lines]), encoding="utf-8")
    return folder / "Foreign.fmu", folder / "names.toml"


def test_a_foreign_vehicle_runs_by_a_map_of_its_names(fmus, wheelset, foreign, tmp_path):
    """Other names, signs and units give the same wheel force to rounding."""
    fmu, names = foreign
    assert "neither a vehicle nor a track" in fmus.command("check", fmu, status=(1,)).stdout
    checked = fmus.command("check", fmu, "--map", names, "--run")
    assert "is a vehicle with 1 wheelset and satisfies the contract" in checked.stdout
    found = []
    for number, options in enumerate(([wheelset], [fmu, "--vehicle-map", names])):
        folder = tmp_path / str(number)
        folder.mkdir()
        more = ("--speed", 250, "--distance", 3, "--trust")
        found.append(run(fmus, folder, "--vehicle", *options, *more))
    ours, theirs = (one["normal_force"] for one in found)
    assert np.ptp(ours) > 500.0
    assert np.abs(theirs - ours).max() < 1e-6
    kept = json.loads(found[1].data.attrs["vehicle_names"])
    assert kept["wheelset[1].contact.vertical_force"]["factor"] == -1e3
    height = found[1].data["wheelset_vertical_displacement"]
    assert height.attrs["units"] == "m"
    assert np.abs(height - found[0].data["wheelset_vertical_displacement"]).max() < 1e-12
