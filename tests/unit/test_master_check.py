"""``rail-cosim check`` on made-up descriptions: one fault each, and what is said of it."""

import pytest
from described_fmus import fmu, track, vehicle
from rail_cosim.check import check_fmu, check_table, verdict
from rail_cosim.errors import FmuFileError
from rich.console import Console

POSITION = "wheelset[1].longitudinal_position"
FORCE = "wheelset[1].contact.vertical_force"


def check(tmp_path, variables, **more):
    return check_fmu(fmu(tmp_path / "One.fmu", variables, **more))


def faults(report):
    return {(f.subject, f.text) for f in report.faults}


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize(("role", "made"), [("vehicle", vehicle), ("track", track)])
def test_bare_terminals_are_enough(tmp_path, role, made, count):
    report = check(tmp_path, made(count))
    assert (report.role, report.wheelsets, report.faults) == (role, count, [])
    assert report.passed
    optional = {f.subject for f in report.contract}
    assert {"static_wheel_load", "coupling.input_time"} <= optional
    height = {"vehicle": "initial", "track": "static"}[role]
    assert f"wheelset[{count}].{height}_vertical_displacement" in optional


def without(name):
    return {key: about for key, about in vehicle().items() if key != name}


@pytest.mark.parametrize(
    ("variables", "subject", "text"),
    [
        (without(POSITION), POSITION, "missing; must be an output in m"),
        (without(FORCE), FORCE, "missing; must be an input in N"),
        (vehicle() | {POSITION: ("output", "mm")}, POSITION, "is in mm; must be in m"),
        (vehicle() | {POSITION: ("output", "")}, POSITION, "declares no unit; must be in m"),
        (
            vehicle() | {POSITION: ("local", "m")},
            POSITION,
            "is local of kind real; must be output of kind real",
        ),
        (
            vehicle() | {POSITION: ("output", None)},
            POSITION,
            "is output of kind integer; must be output of kind real",
        ),
        (
            vehicle() | {"static_wheel_load": ("parameter", "m")},
            "static_wheel_load",
            "is in m; must be in N",
        ),
        (
            vehicle() | {"wheelset_count": ("parameter", None, "2")},
            "wheelset_count",
            "starts with 2, but there are 1 terminals",
        ),
        (
            vehicle() | {"wheelset_count": ("output", None)},
            "wheelset_count",
            "is output of kind integer; must be a parameter of kind integer",
        ),
        (
            {k: v for k, v in track().items() if k != "wheelset_count"},
            "wheelset_count",
            "missing; an integer parameter says how many of the terminals are in use",
        ),
        (
            {k.replace("[1]", "[2]"): v for k, v in vehicle().items()},
            "wheelset[i]",
            "terminals [2]; they count from 1 without a gap, up to 4",
        ),
        (
            vehicle(5),
            "wheelset[i]",
            "terminals [1, 2, 3, 4, 5]; they count from 1 without a gap, up to 4",
        ),
    ],
)
def test_contract_faults(tmp_path, variables, subject, text):
    report = check(tmp_path, variables)
    assert (subject, text) in faults(report)
    assert not report.passed
    assert "does not satisfy" in verdict(report)


def test_neither_vehicle_nor_track(tmp_path):
    report = check(tmp_path, {"speed": ("output", "m/s")})
    assert report.role is None
    assert [f.subject for f in report.faults] == ["wheelset[i].*"]
    assert "neither a vehicle nor a track" in verdict(report)


@pytest.mark.parametrize(
    ("old", "new", "subject", "text"),
    [
        ('<Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>', "", "unit N", "is used, but not"),
        ('<Real unit="N" start="0"/>', '<Real unit="N"/>', FORCE, "has no start value"),
        ('<Real unit="m"/>', '<Real unit="m" start="0"/>', POSITION, "is calculated, but has"),
        (
            '<Real unit="N" start="0"/>',
            '<Real unit="N" start="0" min="1"/>',
            FORCE,
            "starts with 0, outside its limits 1 to inf",
        ),
        (
            '<InitialUnknowns><Unknown index="1"/>',
            "<InitialUnknowns>",
            "ModelStructure/InitialUnknowns",
            f"does not list {POSITION}",
        ),
        (
            '<Outputs><Unknown index="1"/>',
            "<Outputs>",
            "ModelStructure/Outputs",
            f"does not list {POSITION}",
        ),
        (
            '<Outputs><Unknown index="1"/>',
            '<Outputs><Unknown index="1"/><Unknown index="99"/>',
            "ModelStructure/Outputs",
            "lists index 99, which does not belong there",
        ),
        ('guid="g"', 'guid=""', "guid", "missing or empty"),
        (
            f'name="{FORCE}"',
            f'name="{FORCE}" variability="fixed"',
            FORCE,
            "input with variability fixed; allowed: discrete, continuous",
        ),
        (
            'name="wheelset[1].lateral_displacement"',
            f'name="{POSITION}"',
            POSITION,
            "declared 2 times",
        ),
    ],
)
def test_fmi_faults(tmp_path, old, new, subject, text):
    def edit(description):
        assert old in description
        return description.replace(old, new)

    report = check(tmp_path, vehicle(), edit=edit)
    assert any(s == subject and t.startswith(text) for s, t in faults(report)), faults(report)


def test_a_binary_for_this_platform_is_needed(tmp_path):
    report = check(tmp_path, vehicle(), binary="amiga/M.so")
    (finding,) = report.faults
    assert finding.subject == "binaries"
    assert finding.text.endswith("there are amiga")


def test_table_puts_equal_findings_in_one_row(tmp_path):
    several = {name: (c, "km" if u == "m" else u) for name, (c, u) in vehicle(4).items()}
    report = check(tmp_path, several)
    console = Console(width=400)
    with console.capture() as said:
        console.print(check_table(report))
    rows = [row for row in said.get().splitlines() if "is in km; must be in m" in row]
    assert len(rows) == 1
    assert "and 8 more" in rows[0]
    assert POSITION in rows[0]


def test_no_fmu(tmp_path):
    with pytest.raises(FmuFileError, match="no such file"):
        check_fmu(tmp_path / "none.fmu")
