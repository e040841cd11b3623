"""What cannot be run is refused with name, value, limit and the nearest name, by exit status 2."""

import pytest
from fmu_probes import command_lines, refused_simulation

REFUSED = {
    "misspelt parameter": (
        ["--set", "track.fastener.vertical_stifness=40e6"],
        ["track.fastener.vertical_stifness = 40e6", "track.fastener.vertical_stiffness"],
    ),
    "negative stiffness": (
        ["--set", "track.fastener.vertical_stiffness=-40e6"],
        ["track.fastener.vertical_stiffness = -40e6", "0 N/m"],
    ),
    "negative stiffness of the vehicle": (
        ["--set", "vehicle.primary_suspension.vertical_stiffness=-5"],
        ["vehicle.primary_suspension.vertical_stiffness = -5", "0 N/m"],
    ),
    "beyond the upper limit": (
        ["--set", "track.fastener.spacing=1000"],
        ["track.fastener.spacing = 1000", "0.1", "5 m"],
    ),
    "not a number": (
        ["--set", "track.rail.density=nan"],
        ["track.rail.density = nan", "must be a finite number in kg/m3"],
    ),
    "no number": (
        ["--set", "vehicle.wheelset.mass=heavy"],
        ["vehicle.wheelset.mass = 'heavy'", "must be a finite number in kg"],
    ),
    "no such choice": (
        ["--set", "track.window.method=slide"],
        ["track.window.method = 'slide'", "sliding, cyclic, moving_mass", "mean sliding"],
    ),
    "half a mode": (
        ["--set", "track.rail.mode_count=1.5"],
        ["track.rail.mode_count = 1.5", "whole number"],
    ),
    "no FMU named": (
        ["--set", "fastener.spacing=0.6"],
        ["fastener.spacing = 0.6", "track.fastener.spacing"],
    ),
    "output set": (
        ["--set", "track.window.slide_residual=1"],
        ["track.window.slide_residual = 1", "only parameters can be set"],
    ),
    "unknown line": (["--line", "HDD"], ["--line = 'HDD'", "mean HD"]),
    "no such line at all": (["--line", "Tokaido"], ["--line = 'Tokaido'", "HD, ZX"]),
    "unknown vehicle": (["--vehicle", "manchester"], ["'manchester'", "mean manchester1"]),
    "unknown algorithm": (["--algorithm", "gauss"], ["--algorithm = 'gauss'", "gauss-seidel"]),
    "wrong flag": (["--sped", "300"], ["No such option: --sped", "--speed"]),
    "speed not a number": (["--speed", "nan"], ["--speed = nan", "greater than 0 km/h"]),
    "distance not a number": (["--distance", "nan"], ["--distance = nan", "greater than 0 m"]),
    "no step": (["--macro-step", "0"], ["--macro-step = 0", "greater than 0 s"]),
}


@pytest.fixture(scope="module")
def answers(fmus, tmp_path_factory):
    """Exit status and text of every case, and the folder that all results should go to."""
    folder = tmp_path_factory.mktemp("refused")
    cases = [
        ["run", "--distance", "1", "--out", str(folder / "run.nc"), *arguments]
        for arguments, _ in REFUSED.values()
    ]
    return dict(zip(REFUSED, fmus.call(command_lines, cases), strict=True)), folder


@pytest.mark.parametrize("case", REFUSED)
def test_command_line_refuses(answers, case):
    status, text = answers[0][case]
    assert status == 2, text
    assert [part for part in REFUSED[case][1] if part not in text] == []
    assert "Traceback" not in text


def test_nothing_is_written_when_refused(answers):
    assert list(answers[1].iterdir()) == []


# Rules that only the FMU knows: between parameters, and limits that FMI 2.0 cannot express.
BY_FMU = {
    "track.window.slab_count=4": ["20.3 m apart", "raise window.slab_count"],
    "vehicle.wheelset.mass=0": ["wheelset.mass = 0", "must be greater than 0 kg"],
}


@pytest.mark.parametrize("setting", BY_FMU)
def test_refusal_of_an_fmu_is_passed_on(fmus, setting):
    """In a process each: none of them crashes at its end."""
    done = fmus.command("run", "--set", setting, status=(2,))
    assert [part for part in BY_FMU[setting] if part not in done.stderr] == []
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_fmus_refuse_in_any_tool(fmus):
    """In fmpy with logging off: an exception, and the reason on stderr."""
    for fmu, name, value in (
        (fmus.track, "fastener.vertical_stiffness", -40e6),
        (fmus.vehicle, "car_body.mass", -1.0),
        (fmus.vehicle, "wheelset.mass", float("nan")),
    ):
        error, told = fmus.call(refused_simulation, fmu, **{name: value})
        assert error == "fmi2ExitInitializationMode failed with status 4 (fatal)."
        assert f"{name} = {value}: must be" in told
