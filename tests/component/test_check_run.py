"""``rail-cosim check --run``: FMUs whose description is right and whose behaviour is not."""

import pytest
from fmi_builds import PACKAGES, folder
from rail_cosim.check import check_fmu
from rail_cosim.trial import trial_findings
from rail_fmi.builder import build_fmu

ENTRY = """
import os
from rail_fmi import RailSlave, Variable

W = "wheelset[1]."


class {name}(RailSlave):
    MODEL_NAME = "{name}"

    def declare(self):
        units = {{"longitudinal_position": "m", "longitudinal_velocity": "m/s",
                 "pitch_rate": "rad/s"}}
        return [
            Variable(W + "contact.vertical_force", causality="input", unit="N"),
            *(Variable(W + name, causality="output", unit=unit) for name, unit in units.items()),
        ]

    def initialize(self):
        self.count = 0
        self.reals[2:4] = 50.0, -100.0
        {start}

    def step(self, time, step_size):
        self.count += 1
        self.reals[1] += self.reals[2] * step_size
        {step}

    def save(self):
        return {{"count": self.count}}

    def restore(self, state):
        self.count = {restored}
"""
GOOD = {"start": "pass", "step": "pass", "restored": 'state["count"]'}
CASES = {
    "Spinning": ({"start": "self.reals[3] = 100.0"}, "rolling is minus speed over radius"),
    "Crashing": ({"step": "os.abort()"}, "its process ended with signal 6"),
    "Leaving": ({"step": "os._exit(3)"}, "its process ended with status 3"),
    "Refusing": ({"step": 'raise ValueError("worn out")'}, "worn out"),
    "Drifting": ({"step": "self.reals[1] += 0.01"}, "where its velocity says 0.1 m"),
    "Forgetting": (
        {"step": "self.reals[3] -= self.count", "restored": "0"},
        "is another after the state was set back",
    ),
}


def faulty(name, **what):
    script = folder() / f"{name.lower()}_fmu.py"
    script.write_text(ENTRY.format(name=name, **GOOD | what))
    return build_fmu(script, PACKAGES[:2], folder())


def test_a_good_one_is_found_good():
    assert trial_findings(faulty("Rolling")) == []


@pytest.mark.parametrize("name", CASES)
def test_a_fault_is_found_and_named(name):
    what, text = CASES[name]
    found = trial_findings(faulty(name, **what))
    assert any(text in finding.text for finding in found), found
    assert all(finding.level == "fault" for finding in found)


def test_an_endless_loop_is_ended(monkeypatch):
    monkeypatch.setattr("rail_cosim.trial.LONGEST", 5.0)
    (found,) = trial_findings(faulty("Hanging", step="while True: pass"))
    assert found.text == "is not over after 5 s"


def test_the_run_is_part_of_the_report_only_if_asked_for():
    path = faulty("Raising", step='raise ValueError("worn out")')
    assert check_fmu(path).trial == ()
    report = check_fmu(path, run=True)
    assert report.trial
    assert set(report.trial) <= set(report.faults)
