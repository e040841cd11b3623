"""Run files: what they say, from where their paths are seen, what is refused; written and read."""

from pathlib import Path

import pytest
from rail_cosim import read_case
from rail_cosim.case import write_case
from rail_cosim.errors import ParameterError
from rail_cosim.options import RunOptions
from rail_cosim.toml_files import assignments


def case(folder, text):
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_options_and_parameters_by_their_names(tmp_path):
    given = read_case(
        case(
            tmp_path,
            """
            [run]
            line = "ZX"
            speed = 170
            until-steady = 1e-3
            [set]
            track.fastener.vertical_stiffness = 140e6
            "track.rail_head[1].left.vertical_force" = 5
            [set.vehicle.wheelset]
            mass = 1500
            """,
        )
    )
    assert given == {
        "line": "ZX",
        "speed": 170,
        "until_steady": 1e-3,
        "settings": {
            "track.fastener.vertical_stiffness": 140e6,
            "track.rail_head[1].left.vertical_force": 5,
            "vehicle.wheelset.mass": 1500,
        },
    }


def test_paths_are_seen_from_the_file(tmp_path, monkeypatch):
    (tmp_path / "lines").mkdir()
    (tmp_path / "lines" / "worn.csv").touch()
    monkeypatch.chdir(tmp_path)
    text = """
        [run]
        irregularity = "worn.csv"
        vehicle = "my/tram.fmu"
        track = "/absolute/track.fmu"
        out = "run.nc"
        line = "HD"
        [set]
        track.irregularity.file.path = "worn.csv"
        track.contact.rail_profile = "60E1"
        track.contact.wheel_profile = "absent.prf"
        """
    given = read_case(Path(case(tmp_path / "lines", text).relative_to(tmp_path)))
    folder = tmp_path / "lines"
    assert given["irregularity"] == str(folder / "worn.csv")
    assert given["vehicle"] == str(folder / "my" / "tram.fmu")
    assert given["track"] == Path("/absolute/track.fmu")
    assert given["out"] == folder / "run.nc"
    assert given["line"] == "HD"
    assert given["settings"] == {
        "track.irregularity.file.path": str(folder / "worn.csv"),
        "track.contact.rail_profile": "60E1",
        "track.contact.wheel_profile": "absent.prf",  # no file: a name of the FMU's, perhaps
    }


def test_a_name_of_an_irregularity_is_no_path(tmp_path):
    (tmp_path / "german_low").touch()
    given = read_case(case(tmp_path, '[run]\nirregularity = "german_low"\nuntil_steady = false\n'))
    assert given == {"irregularity": "german_low", "until_steady": None, "settings": {}}


REFUSED = {
    "unknown option": ("[run]\nspede = 3\n", r"run\.spede = 3: .*mean speed"),
    "unknown section": ("[runs]\nspeed = 3\n", r"runs = .*mean run"),
    "option outside": ("speed = 3\n", r"speed = 3: is an option of a run; write it below \[run\]"),
    "parameters outside": (
        "[track]\nrail.density = 1\n",
        r"write track\.NAME = VALUE below \[set\]",
    ),
    "no FMU named": (
        "[set]\nrail.density = 1\n",
        r"set\.rail\.density = 1: .*track\.rail\.density",
    ),
    "no section": ("run = 3\n", r"run = 3: must be a section; write \[run\]"),
    "no TOML": ("[run\n", "is no TOML file"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(tmp_path, name):
    text, message = REFUSED[name]
    with pytest.raises(ParameterError, match=message):
        read_case(case(tmp_path, text))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ParameterError, match=r"absent\.toml.*cannot be read"):
        read_case(tmp_path / "absent.toml")


WRONG = {
    "speed": ("fast", "--speed = 'fast': must be a number"),
    "record_every": (1.5, "--record-every = 1.5: must be a whole number"),
    "line": (3, "--line = 3: must be a text"),
    "macro_step": (True, "--macro-step = True: must be a number"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_value_of_the_wrong_type_is_refused(name):
    value, message = WRONG[name]
    with pytest.raises(ParameterError, match=message):
        RunOptions(**{name: value})


def options(folder):
    irregularity = folder / "worn.csv"
    irregularity.touch()
    return RunOptions(
        line="ZX",
        vehicle="manchester1",
        speed=170.0,
        distance=12.5,
        irregularity=str(irregularity),
        macro_step=5e-5,
        record_every=2,
        out=folder / "out" / "run.nc",
        variables=["normal_force", "axle_box_*"],
        plot=folder.parent / 'with "quotes" \\ and ä.png',
        settings=[
            "track.fastener.vertical_stiffness=140e6",
            "track.contact.rail_profile=60E1",
            "track.rail_head[1].left.vertical_force = -1.5",
            "track.something.true=true",
            "track.something.padded=007",
            "track.contact.rail_profile=CHN60",
        ],
    )


def test_what_is_written_is_read_as_the_same(tmp_path):
    given = options(tmp_path)
    path = tmp_path / "case.toml"
    write_case(path, given)
    found = read_case(path)
    assert found["variables"] == ["normal_force", "axle_box_*"]
    assert set(assignments(found.pop("settings"))) == {
        "track.fastener.vertical_stiffness=140000000.0",
        "track.contact.rail_profile=CHN60",  # given twice: the last one wins
        "track.rail_head[1].left.vertical_force=-1.5",
        "track.something.true=true",
        "track.something.padded=007",
    }
    assert RunOptions(**found, settings=given.settings) == given
    text = path.read_text(encoding="utf-8")
    assert 'out = "out/run.nc"' in text
    assert 'irregularity = "worn.csv"' in text
    assert '# algorithm = "gauss-seidel"' in text
