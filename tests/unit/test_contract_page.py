"""The page about own FMUs says what the code tests."""

import re
from pathlib import Path

from rail_cosim import contract
from rail_cosim.initialisation import PASSED
from rail_cosim.name_map import read_name_map
from rail_quantities.terminals import CONTACT, MOTION

PAGE = (Path(__file__).parents[2] / "docs" / "contract.md").read_text(encoding="utf-8")


def table(head):
    """Return the rows below a head, cells without code marks."""
    _, _, rest = PAGE.partition(f"\n| {head} |")
    assert rest, head
    rows = []
    for line in rest.splitlines()[2:]:
        if not line.startswith("|"):
            break
        rows.append(tuple(cell.strip().strip("`") for cell in line.strip("|").split(" | ")))
    return rows


def test_the_terminals_are_those_of_the_fmus_and_of_the_check():
    motion = table("motion, `wheelset[i].` | unit | meaning")
    forces = table("force, `wheelset[i].` | unit | meaning")
    assert motion == [tuple(member) for member in MOTION]
    assert forces == [(f"contact.{m.name}", m.unit, m.description) for m in CONTACT]
    assert {name: unit for name, unit, _ in motion} == contract.MOTION
    assert {name: unit for name, unit, _ in forces} == contract.FORCES


def test_optional_variables_are_those_of_the_check():
    for role in ("vehicle", "track"):
        shown = table(f"{role} | unit or kind | causality | without it")
        wanted = [
            (
                one.name.replace("[1]", "[i]"),
                one.unit or one.kind,
                " or ".join(one.causality),
                one.without,
            )
            for one in contract.expected(role, [1])
            if one.without
        ]
        assert shown == wanted


def test_outputs_that_are_evaluated_are_listed():
    for role in ("vehicle", "track"):
        assert table(f"{role} | unit") == list(contract.OUTPUTS[role].items())


def test_what_is_passed_on_at_the_start_is_named():
    _, _, start = PAGE.partition("## Initialisation")
    for source, target in PASSED.items():
        assert f"`{source}`" in start
        assert f"`{target}`" in start


def test_the_name_map_shown_can_be_read(tmp_path):
    (shown,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    path = tmp_path / "names.toml"
    path.write_text(shown, encoding="utf-8")
    found = {one.name: one for one in read_name_map(path)}
    assert found["speed"].to_contract(360.0) == 100.0
    assert found["wheelset[{i}].contact.vertical_force"].own == "ws{i}_Q_up_kN"
    known = contract.known_units()
    assert all(name.replace("{i}", "1") in known for name in found)
