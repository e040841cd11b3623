"""The coupling algorithms through both FMUs, at the default macro step."""

import numpy as np
import pytest
from runs import run

PITCH = 8 * 0.629
OPTIONS = ["--line", "HD", "--speed", 300, "--distance", 1.25 * PITCH, "--algorithm"]
ITERATIVE = "iterative-gauss-seidel"


@pytest.fixture(scope="module")
def runs(fmus, tmp_path_factory):
    return {
        name: run(fmus, tmp_path_factory.mktemp("run"), *OPTIONS, name)
        for name in ("gauss-seidel", "jacobi", ITERATIVE)
    }


def difference(first, second):
    """Largest difference of the wheel forces over the last slab, over half the peak-to-peak."""
    late = first["distance"] > first["distance"][-1] - PITCH
    one, other = first["normal_force"][late], second["normal_force"][late]
    return np.abs(one - other).max() / (0.5 * np.ptp(other, axis=0).max())


def test_gauss_seidel_agrees_with_the_iterated_coupling(runs):
    """Iterated until the interface agrees at both ends, the coupling itself makes no error."""
    assert runs[ITERATIVE].data.attrs["algorithm"] == ITERATIVE
    assert 0.0 < difference(runs["gauss-seidel"], runs[ITERATIVE]) < 0.005


def test_jacobi_agrees_with_the_iterated_coupling(runs):
    assert 0.0 < difference(runs["jacobi"], runs[ITERATIVE]) < 0.02


def test_two_runs_are_equal_to_the_bit(runs, fmus, tmp_path):
    again = run(fmus, tmp_path, *OPTIONS, "gauss-seidel")
    first = runs["gauss-seidel"].data
    assert set(again.data.variables) == set(first.variables)
    for name, values in first.variables.items():
        assert values.equals(again.data.variables[name]), name


def test_an_unstable_step_is_an_error_of_the_fmu_with_limit_and_remedy(fmus, tmp_path):
    """Creep makes a slow wheelset stiff: the wheels would turn about with some 20 kN."""
    with pytest.raises(
        AssertionError, match=r"(?s)0\.1 ms is coarse.*0\.1 ms the coupling is unstable"
    ):
        run(fmus, tmp_path, "--speed", 60, "--distance", 2, "--algorithm", "jacobi")
