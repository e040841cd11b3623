"""The targets of ``make fuzz`` on their seeds and on damaged copies, without atheris."""

import importlib.util
from pathlib import Path

import pytest

_SPEC = importlib.util.spec_from_file_location("fuzz_targets", Path(__file__).parent / "targets.py")
targets = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(targets)


@pytest.mark.parametrize("name", targets.TARGETS)
def test_damaged_copies_are_taken_or_refused(name):
    target = targets.TARGETS[name]
    for seed in target.seeds():
        target.check(seed)
        for data in targets.mutants(seed, 150):
            target.check(data)


def test_good_seeds_are_read(tmp_path):
    """What the seeds begin with is no refusal: faults behind the first check are within reach."""
    for name, reader in (
        ("profile", lambda data, path: targets.load_profile("wheel", path)),
        ("irregularity", lambda data, path: targets.read_file(path)),
        ("case", lambda data, path: targets.read_case(path)),
        ("sweep", lambda data, path: targets.read_specification(Path(path))),
        ("ssv", lambda data, path: targets.read_entries(data, "a")),
        ("state", lambda data, path: targets.from_bytes(data)),
    ):
        for seed in targets.TARGETS[name].seeds()[: 1 if name == "profile" else None]:
            path = tmp_path / name
            path.write_bytes(seed[1:] if name == "profile" else seed)
            assert reader(seed, str(path))
