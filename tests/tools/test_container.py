"""Vehicle and track in one FMU, made by fmu-manipulation-toolbox."""

import pytest
from fmpy.validation import validate_fmu
from tool_hosts import SLIDES, make_container, relative_difference, run_one_fmu

TOOL = "fmu_manipulation_toolbox"


@pytest.fixture(scope="module")
def container(fmus, pair, tmp_path_factory):
    folder = tmp_path_factory.mktemp("container")
    return fmus.call(make_container, folder, pair.ssp, fmus.both)


def test_container_runs_as_one_fmu(fmus, pair, container):
    found = fmus.call(run_one_fmu, container)
    assert (found.pop(SLIDES) == pair[SLIDES]).all()
    for name, values in found.items():
        # Before the first step a container hands 0 to what is linked inside, so the vehicle
        # shows accelerations without contact forces there. The first step has the right ones.
        assert relative_difference(values[1:], pair[name][1:]) <= 1e-9, name


def test_container_is_valid(container):
    assert validate_fmu(str(container)) == []
