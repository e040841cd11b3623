"""The list of deliberate faults fits the sources; ``make mutations`` makes them."""

import pytest
from mutations import ROOT, Fault, StaleFaultError, faults


@pytest.mark.parametrize("fault", faults(), ids=lambda fault: str(fault.number))
def test_a_fault_is_in_the_sources_and_so_are_its_tests(fault):
    fault.line(ROOT)
    fault.check_tests(ROOT)
    assert fault.tests


def test_there_are_enough_all_over_the_physics():
    files = [fault.file for fault in faults()]
    assert len(files) >= 36
    for folder in ("fmus/vehicle", "fmus/track", "fmus/common", "master"):
        assert any(file.startswith(folder) for file in files)


def test_entries_that_do_not_fit_are_told(tmp_path):
    source = tmp_path / "a.py"
    source.write_text("x = 1\ny = 2\n    y = 2\n")
    fault = Fault(number=1, file="a.py", before="x = 1", after="x = 2", breaks="x", tests=())
    assert fault.apply(tmp_path) == "x = 1\ny = 2\n    y = 2\n"
    assert source.read_text() == "x = 2\ny = 2\n    y = 2\n"
    for before, after in (("x = 1", "x = 3"), ("y = 2", "y = 3"), ("x = 2", "x = 2")):
        with pytest.raises(StaleFaultError):
            Fault(number=1, file="a.py", before=before, after=after, breaks="x", tests=()).line(
                tmp_path
            )
    with pytest.raises(StaleFaultError):
        Fault(
            number=1, file="a.py", before="x = 2", after="x = 3", breaks="x", tests=("b.py",)
        ).check_tests(tmp_path)
