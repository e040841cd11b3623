"""``rail-cosim check`` on the built FMUs, and on copies of them that were spoiled."""

import re
import zipfile

import pytest
from fmu_probes import command_lines


def spoiled(source, target, edit):
    """Copy an FMU with its description changed; the change must be one."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                changed = edit(content.decode()).encode()
                assert changed != content
                content = changed
            new.writestr(name, content)
    return target


def renamed(text):
    return text.replace('name="wheelset[3].yaw_rate"', 'name="wheelset[3].yaw_speed"')


def in_kilonewton(text):
    pattern = r'(name="wheelset\[2\]\.contact\.lateral_force".*?unit=")N"'
    return re.sub(pattern, r'\1kN"', text, count=1, flags=re.DOTALL)


def without_unknowns(text):
    return re.sub(r"<InitialUnknowns>.*?</InitialUnknowns>", "", text, flags=re.DOTALL)


def no_longer_input(text):
    pattern = r'(name="wheelset\[1\]\.roll_angle".*?causality=")input"'
    return re.sub(pattern, r'\1local"', text, count=1, flags=re.DOTALL)


@pytest.fixture(scope="module")
def answers(fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("spoiled")
    cases = {
        "vehicle": fmus.vehicle,
        "track": fmus.track,
        "vehicle run": fmus.vehicle,
        "track run": fmus.track,
        "renamed": spoiled(fmus.vehicle, folder / "a.fmu", renamed),
        "unit": spoiled(fmus.track, folder / "b.fmu", in_kilonewton),
        "unknowns": spoiled(fmus.track, folder / "c.fmu", without_unknowns),
        "causality": spoiled(fmus.track, folder / "d.fmu", no_longer_input),
        "no FMU": folder,
        "text": __file__,
    }
    options = {name: ["--run"] if name.endswith("run") else [] for name in cases}
    commands = [["check", *options[name], str(path)] for name, path in cases.items()]
    said = fmus.call(command_lines, commands)
    return dict(zip(cases, said, strict=True))


@pytest.mark.parametrize("name", ["vehicle", "track", "vehicle run", "track run"])
def test_ours_satisfy_the_contract(answers, name):
    status, text = answers[name]
    assert status == 0
    assert f"is a {name.split()[0]} with 4 wheelsets and satisfies the contract" in text
    assert "fault" not in text


@pytest.mark.parametrize(
    ("case", "words"),
    [
        ("renamed", ["wheelset[3].yaw_rate", "missing; must be an output in rad/s"]),
        ("unit", ["wheelset[2].contact.lateral_force", "is in kN; must be in N", "unit kN"]),
        ("unknowns", ["ModelStructure/InitialUnknowns", "does not list"]),
        ("causality", ["wheelset[1].roll_angle", "is local of kind real"]),
    ],
)
def test_spoiled_copies_fail_by_name(answers, case, words):
    status, text = answers[case]
    assert status == 1
    # The table breaks long words and lines.
    flat = re.sub(r"[\s│┃┏┓┗┛┡┩╇━─├┤┼└┘┴┌┐┬]+", "", text)
    for word in words:
        assert word.replace(" ", "") in flat
    assert "doesnotsatisfythecontract" in flat


@pytest.mark.parametrize("case", ["no FMU", "text"])
def test_no_fmu_is_another_status(answers, case):
    status, text = answers[case]
    assert status == 2
    assert "FMU" in text
