"""``rail-cosim study all``: goes on after a study that fails, and says so in the end."""

from rail_cosim import cli, studies
from rail_cosim.errors import RailCosimError
from rail_cosim.studies import StudyResult
from rich.table import Table
from typer.testing import CliRunner


def done_with(monkeypatch, failing):
    seen = []

    def run_study(name, options, reporter):
        seen.append((name, options.quick))
        if name in failing:
            raise RailCosimError("the wheel broke")
        return StudyResult(table=Table(), conclusion=f"{name} is done", files=[])

    monkeypatch.setattr(studies, "run_study", run_study)
    result = CliRunner().invoke(cli.app, ["study", "all", "--quick"])
    assert seen == [(name, True) for name in studies.STUDIES]
    return result


def test_a_failed_study_does_not_end_the_others(monkeypatch):
    result = done_with(monkeypatch, ["p2", "fig11"])
    count = len(studies.STUDIES)
    assert result.exit_code == 1
    assert f"{count - 2} of {count} studies were done" in result.output
    assert "table3 is done" in result.output
    assert "p2 is done" not in result.output


def test_all_done_is_status_0(monkeypatch):
    assert done_with(monkeypatch, []).exit_code == 0
