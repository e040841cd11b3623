"""``rail-cosim`` as people expect it: help, completion, run files, quiet, colours, exit status."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
import xarray as xr
from product import PATIENCE

COMMANDS = ["build", "check", "run", "sweep", "study", "bench", "verify"]
SHORT = ["--distance", 2, "--set", "track.rail.mode_count=40", "--set", "track.slab.mode_count=6"]
ESCAPE = "\x1b"


def test_without_arguments_it_shows_its_help(fmus):
    done = fmus.command()
    assert done.stdout == fmus.command("--help").stdout
    assert [name for name in COMMANDS if f"\n  {name} " not in done.stdout] == []
    assert "Exit status" in done.stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_has_examples_that_parse(fmus, name):
    done = fmus.command(name, "--help")
    examples = re.findall(rf"^ +(rail-cosim {name} .*)$", done.stdout, re.MULTILINE)
    assert examples
    for line in examples:
        options = re.findall(r" (--[\w-]+)", line)
        assert [option for option in options if f" {option} " not in done.stdout] == []
    assert done.stderr == ""


def test_help_of_run_groups_its_options(fmus):
    text = fmus.invoke("run", "--help").stdout
    groups = [line for line in text.splitlines() if re.fullmatch(r"[A-Z].*:", line)]
    assert "Motion:" in groups
    assert "Irregularity:" in groups
    start, stop = text.index("Results:"), text.index("Plots and animation:")
    assert start < text.index("--out FILE") < text.index("--variables NAME") < stop
    assert text.count("--out FILE") == 1


def test_help_keeps_names_in_brackets(fmus):
    assert "  [grid]\n      speed = {" in fmus.command("sweep", "--help").stdout


def test_version(fmus):
    done = fmus.command("--version")
    assert re.fullmatch(r"rail-cosim (\d+\.\d+\.\d+\S*|unknown)\n", done.stdout)


WRONG = {
    "flag": (["run", "--sped", 3], ["--sped", "--speed", "rail-cosim run --help"]),
    "command": (["rum"], ["'rum'", "run", "rail-cosim --help"]),
    "number": (["run", "--speed", "fast"], ["--speed"]),
    "too much": (["check", "a.fmu", "b.fmu"], ["b.fmu"]),
    "missing": (["sweep"], ["SPEC", "rail-cosim sweep --help"]),
    "before the command": (["--speed", 3], ["--speed"]),
    "value": (["run", "--distance", -1], ["--distance = -1"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_command_line_gets_one_plain_message_and_status_2(fmus, case):
    arguments, words = WRONG[case]
    done = fmus.command(*arguments, status=(2,))
    assert done.stdout == ""
    assert done.stderr.startswith("rail-cosim: error: ")
    assert done.stderr.count("\n") <= 2
    assert [word for word in words if word not in done.stderr] == []


def test_status_1_if_the_result_cannot_be_written(fmus, tmp_path):
    (tmp_path / "file").touch()
    done = fmus.invoke("run", *SHORT, "--out", tmp_path / "file" / "run.nc", status=(1,))
    assert "cannot be written" in done.stderr


CASE = """
[run]
speed = 250
distance = 300
out = "case.nc"
[set]
track.rail.mode_count = 40
track.slab.mode_count = 6
track.fastener.vertical_stiffness = 140e6
"""


def test_a_run_file_and_the_command_line_wins(fmus, tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    arguments = ["--distance", 2, "--set", "track.slab.mode_count=7"]
    fmus.invoke("run", tmp_path / "case.toml", *arguments)
    with xr.open_dataset(tmp_path / "case.nc", engine="h5netcdf") as data:
        about = data.attrs
        assert about["speed_km_h"] == pytest.approx(250.0)
        assert about["track.fastener.vertical_stiffness"] == 140e6
        assert about["track.rail.mode_count"] == 40
        assert about["track.slab.mode_count"] == 7
        assert data["distance"][-1] == pytest.approx(2.0, abs=0.1)


def test_a_run_file_that_was_written_runs_as_its_command(fmus, tmp_path):
    arguments = ["--speed", 250, *SHORT, "--out", tmp_path / "one.nc"]
    done = fmus.invoke("run", *arguments, "--write-case", tmp_path / "case.toml")
    assert done.stdout == f"{tmp_path / 'case.toml'}\n"
    assert not (tmp_path / "one.nc").exists()
    done = fmus.invoke("run", *arguments)
    assert ESCAPE not in done.stdout + done.stderr  # this is no terminal
    fmus.invoke("run", tmp_path / "case.toml", "--out", tmp_path / "two.nc")
    first, second = (
        xr.load_dataset(tmp_path / f"{n}.nc", engine="h5netcdf") for n in ("one", "two")
    )
    xr.testing.assert_equal(first, second)


def test_quiet_says_nothing_unless_something_is_wrong(fmus, tmp_path):
    done = fmus.command("run", *SHORT, "--quiet", "--out", tmp_path / "run.nc")
    assert (done.stdout, done.stderr) == ("", "")
    assert (tmp_path / "run.nc").exists()
    done = fmus.invoke("run", "-q", "--speed", -3, status=(2,))
    assert done.stdout == ""
    assert "--speed = -3" in done.stderr


def in_a_terminal(fmus, *arguments, **variables):
    """Run with standard output and error at one terminal; return what came there."""
    import pty  # not on Windows

    reader, end = pty.openpty()
    kept = {name: os.environ.pop(name, None) for name in ("NO_COLOR", "TERM")}
    os.environ.update({"TERM": "xterm-256color"} | variables)
    try:
        process = fmus.start(*arguments, stdout=end, stderr=end)
    finally:
        for name in {"TERM", *variables}:
            os.environ.pop(name)
        os.environ.update({name: value for name, value in kept.items() if value is not None})
    os.close(end)
    text = b""
    while True:
        try:
            block = os.read(reader, 4096)
        except OSError:  # Linux: the other end is closed
            break
        if not block:
            break
        text += block
    os.close(reader)
    assert process.wait(PATIENCE) == 0
    return text.decode()


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_colours_in_a_terminal_only_and_not_with_no_color(fmus):
    colour = re.compile(ESCAPE + r"\[[0-9;]*3[0-9]m")
    assert colour.search(in_a_terminal(fmus, "run", *SHORT))
    assert not colour.search(in_a_terminal(fmus, "run", *SHORT, NO_COLOR="1"))


SWEEP = """
[run]
until_steady = false
distance = {distance}
[set]
track.rail.mode_count = 40
track.slab.mode_count = 6
[grid]
speed = [200, 300]
"""


def test_a_sweep_and_its_picture_in_one_command(fmus, tmp_path):
    (tmp_path / "spec.toml").write_text(SWEEP.format(distance=2))
    out, plot = tmp_path / "sweep.nc", tmp_path / "sweep.svg"
    arguments = ["sweep", tmp_path / "spec.toml", "--workers", 1, "--out", out, "--plot", plot]
    done = fmus.command(*arguments)
    assert done.stdout.endswith(f"{out}\n{plot}\n")
    assert "</svg>" in plot.read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C")
def test_ctrl_c_ends_a_sweep_and_keeps_finished_points(fmus, tmp_path):
    spec, store = tmp_path / "spec.toml", tmp_path / "sweep.points"
    spec.write_text(SWEEP.format(distance=2).replace("[200, 300]", f"{list(range(100, 400))}"))
    arguments = ["sweep", spec, "--workers", 1, "--out", tmp_path / "sweep.nc"]
    pipe = subprocess.PIPE
    process = fmus.start(*arguments, stdout=pipe, stderr=pipe, text=True, start_new_session=True)
    end = time.monotonic() + PATIENCE
    while len(list(store.glob("*.nc"))) < 2:
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end, "no point was finished"
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to the workers too
    _, text = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, text
    assert f"finished points are in {store}" in text
    assert text.endswith("rail-cosim: error: stopped by the user\n")
    assert "Traceback" not in text
    assert len(list(store.glob("*.nc"))) >= 2


@pytest.fixture(scope="module")
def completion(fmus, tmp_path_factory):
    """Return a function that completes a line in a real bash."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("there is no bash")
    folder = tmp_path_factory.mktemp("bin")
    command = folder / "rail-cosim"
    call = "import sys; from rail_cosim.cli import main; sys.argv[0] = 'rail-cosim'; main()"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{call}" "$@"\n')
    command.chmod(0o755)
    environment = fmus.environment()
    environment["PATH"] = f"{folder}{os.pathsep}{environment['PATH']}"

    def complete(*words):
        script = (
            'eval "$(env _RAIL_COSIM_COMPLETE=source_bash rail-cosim)"\n'
            f"COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}\n"
            "_rail_cosim_completion rail-cosim\n"
            'printf "%s\\n" "${COMPREPLY[@]}"\n'
        )
        done = subprocess.run(
            [bash, "--norc", "-c", script], env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    complete.run = lambda *arguments: subprocess.run(
        [bash, "--norc", "-c", " ".join(arguments)],
        env=environment | {"HOME": str(folder)},
        capture_output=True,
        text=True,
    )
    return complete


def test_bash_completes_commands_options_and_names(completion):
    assert set(completion("rail-cosim", "s")) >= {"sweep", "study"}
    assert "run" not in completion("rail-cosim", "s")
    assert "--speed" in completion("rail-cosim", "run", "--s")
    assert completion("rail-cosim", "run", "--algorithm", "g") == ["gauss-seidel"]
    assert "critical-speed" in completion("rail-cosim", "study", "cri")


def test_completion_can_be_shown_and_installed(completion):
    shown = completion.run("rail-cosim", "--show-completion", "; true")
    assert "complete " in shown.stdout, shown.stderr
    done = completion.run("rail-cosim", "--install-completion", "; cat ~/.bashrc; true")
    assert "rail-cosim" in done.stdout, done.stderr
