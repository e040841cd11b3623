"""What the command line prints reaches its reader whole, on a narrow terminal and in a file."""

import pytest
from rail_cosim.cli import application
from rich.console import Console, Group
from rich.table import Table

HEADS = [f"quantity {number}" for number in range(20)]


def wide_table():
    table = Table()
    for head in HEADS:
        table.add_column(head, no_wrap=True)
    table.add_row(*["-123.456"] * len(HEADS))
    return Group(table, "a remark")


@pytest.mark.parametrize("columns", ["40", "80", "400"])
def test_a_piped_table_is_as_wide_as_its_content(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    application.show(wide_table())
    out = capsys.readouterr().out
    assert [head for head in HEADS if head not in out] == []
    assert out.count("-123.456") == len(HEADS)
    widths = {len(line.rstrip()) for line in out.splitlines() if "│" in line or "┃" in line}
    assert widths == {sum(len(head) + 3 for head in HEADS) + 1}


def test_a_narrow_terminal_cuts_no_number(capsys, monkeypatch):
    monkeypatch.setattr(application, "_out", Console(force_terminal=True, width=60))
    application.show(wide_table())
    out = capsys.readouterr().out
    assert out.count("-123.456") == len(HEADS)
    assert "…" not in out


def test_quiet_shows_no_table(capsys, monkeypatch):
    monkeypatch.setattr(application, "_out", Console(quiet=True))
    application.show(wide_table())
    assert capsys.readouterr().out == ""
