"""Every option of every command with values that cannot be used: one plain message each.

The options are those that the commands declare, so none is forgotten. Nothing may be run: what
begins a simulation or a study is replaced by a failure.
"""

import pytest
import typer
from command_lines import invoke
from rail_cosim import bench, runner, studies, verification
from rail_cosim.cli.application import app

NUMBER = ("abc", "nan", "inf", "-inf", "0", "-1", "1e400", "")
COUNT = (*NUMBER, "1.5")
SPEC = "[grid]\nspeed = [300]\n[keep]\nnormal_force = ['max']\n"

# What kind of value an option takes, and what else its command needs.
OPTIONS = {
    "build": {"out": "folder", "line": "name", "vehicle": "name"},
    "check": {"fmu": "fmu", "names": "map"},
    "run": {
        "system": "package",
        "line": "name",
        "vehicle": "name",
        "track": "fmu",
        "vehicle_map": "map",
        "track_map": "map",
        "speed": NUMBER,
        "distance": NUMBER,
        "until_steady": NUMBER,
        "final_speed": NUMBER,
        "irregularity": "name",
        "settings": "setting",
        "macro_step": NUMBER,
        "algorithm": "name",
        "record_every": COUNT,
        "out": "file",
        "variables": "names",
        "plot": "picture",
        "animate": "picture",
        "slow_motion": NUMBER,
        "exaggeration": NUMBER,
        "checkpoint_interval": NUMBER,
        "case": "file",
    },
    "report": {"runs": "dataset", "out": "page"},
    "sweep": {
        "specification": "toml",
        "scheduler": "address",
        "workers": COUNT,
        "out": "file",
        "store": "folder",
        "plot": "picture",
    },
    "study": {"name": "study", "out": "folder", "settings": "setting"},
    "bench": {"speed": NUMBER, "macro_step": NUMBER, "settings": "setting", "reference": "script"},
    "verify": {"out": "folder"},
}
FLAGS = {"quiet", "at_rest", "trust", "resume", "quick", "as_json", "full"}


def commands():
    return typer.main.get_command(app).commands


def test_no_option_is_forgotten():
    for name, command in commands().items():
        declared = {p.name for p in command.params} - FLAGS
        if name == "check":
            declared -= {"run"}  # a flag of this name
        assert declared == set(OPTIONS[name]), name


def bad_values(kind, folder):
    """Return bad values of a kind; files and folders are made in ``folder``."""
    if isinstance(kind, tuple):
        return kind
    empty, garbage, text = (folder / name for name in ("empty", "garbage", "text"))
    empty.write_bytes(b"")
    garbage.write_bytes(bytes(range(256)) * 20)
    text.write_text("neither TOML nor XML: {[\n")
    inside_a_file = text / "x"
    read = (str(folder / "missing"), str(folder), str(empty), str(garbage), str(text))
    return {
        "name": ("no-such-thing",),
        "names": ("no-such-thing", ",", ""),
        "study": ("no-such-thing", ""),
        "setting": (
            "",
            "=",
            "x=1",
            "track.=1",
            "track.rail.density",
            "track.rail.density=",
            "track.rail.density=nan",
            "track.rail.density=1e999",
            "track.rail.density=heavy",
            "track.wheelset_count=2.5",
            "car.mass=1",
        ),
        "fmu": read,
        "package": read,
        "dataset": read,
        "toml": read,
        "map": tuple(path for path in read if path != str(empty)),  # one that changes no name
        "script": (str(folder / "missing"), str(folder)),
        "address": ("nowhere:1", "tcp://", "::"),
        "file": (str(inside_a_file), str(folder)),
        "page": (str(inside_a_file), str(folder)),
        "picture": (str(folder / "p.doc"), str(folder / "p"), str(folder)),
        "folder": (str(inside_a_file), str(text)),
    }[kind]


def argument(command, option, value, folder, fmus):
    """Return the command line that gives ``option`` this value."""
    flags = {p.name: p.opts[0] for p in commands()[command].params}
    words = [command]
    given = value if not flags[option].startswith("-") else None
    if command == "report" and option != "runs":
        words.append(str(folder / "run.nc"))
    if command == "sweep" and option != "specification":
        path = folder / "spec.toml"
        path.write_text(SPEC)
        words.append(str(path))
    if option == "names":
        words.append(str(fmus.vehicle))
    if option in ("vehicle_map", "track_map"):
        part = option.partition("_")[0]
        words += [f"--{part}", str(getattr(fmus, part))]
    if command == "study" and option != "name":
        words.append("contact-geometry")
    if command == "run" and option in ("slow_motion", "exaggeration"):
        words += ["--animate", str(folder / "film.gif")]
    return [*words, given] if given is not None else [*words, f"{flags[option]}={value}"]


@pytest.fixture
def nothing_runs(monkeypatch, fmus):
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(fmus.cache))

    def reached(*_, **__):
        raise AssertionError("the value was accepted")

    monkeypatch.setattr(runner, "simulate", reached)
    monkeypatch.setattr(bench, "benchmark", reached)
    monkeypatch.setattr(studies, "run_study", reached)
    monkeypatch.setattr(verification, "execute_verification", reached)


CASES = [(command, option) for command, options in OPTIONS.items() for option in options]
# What is only found out when the work begins is left to it: it is not replaced there.
LATER = {
    "bench": {"settings", "reference"},
    "study": {"settings", "out", "name"},
    "verify": {"out"},
}


def all_lines(command, option, folder, fmus):
    values = bad_values(OPTIONS[command][option], folder)
    return [argument(command, option, value, folder, fmus) for value in values]


@pytest.fixture(scope="module")
def sweeps(fmus, tmp_path_factory):
    """Run all bad sweeps in a process of their own: Dask leaves traces in it."""
    folders = {option: tmp_path_factory.mktemp(option) for option in OPTIONS["sweep"]}
    lines = {option: all_lines("sweep", option, f, fmus) for option, f in folders.items()}
    found = iter(fmus.call(invoke, [words for part in lines.values() for words in part]))
    return {option: (folders[option], part, [next(found) for _ in part])
            for option, part in lines.items()}  # fmt: skip


MADE = {"empty", "garbage", "text", "spec.toml"}


@pytest.mark.parametrize(("command", "option"), CASES)
def test_bad_values_are_refused(
    command, option, tmp_path, fmus, nothing_runs, monkeypatch, request
):
    if option in LATER.get(command, ()):
        monkeypatch.undo()
        monkeypatch.setenv("RAIL_COSIM_CACHE", str(fmus.cache))
    if command == "sweep":
        folder, lines, found = request.getfixturevalue("sweeps")[option]
    else:
        monkeypatch.chdir(tmp_path)
        folder, lines = tmp_path, all_lines(command, option, tmp_path, fmus)
        found = invoke(lines)
    for words, (status, text, raised) in zip(lines, found, strict=True):
        shown = f"{words}: {status}\n{text}\n{raised}"
        assert status in (1, 2), shown
        assert not raised, shown
        assert "Traceback" not in text, shown
        assert 0 < len(text.strip().splitlines()) <= 12, shown
    assert {path.name for path in folder.rglob("*")} <= MADE
