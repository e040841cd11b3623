"""The package in ecos: from Python, and in its compiled command."""

import numpy as np
import pytest
from tool_hosts import SLIDES, relative_difference, run_ecos_command, run_ecospy, shared_python

TOOL = "ecospy"


def test_ecospy_makes_the_same_run(fmus, pair):
    """Jacobi on both sides: equal to the rounding of times."""
    found = fmus.call(run_ecospy, pair.ssp)
    assert found.pop(SLIDES)[-1] == pair[SLIDES][-1]
    for name, values in found.items():
        assert relative_difference(values, pair[name]) <= 1e-9, name


@pytest.mark.skipif(shared_python() is None, reason="this Python has no shared library to preload")
def test_the_compiled_command_makes_the_same_run(fmus, pair, tmp_path):
    """A host that is not Python; its CSV has six digits after the point."""
    found = fmus.call(run_ecos_command, pair.ssp, tmp_path)
    assert (found.pop(SLIDES) == pair[SLIDES]).all()
    for name, values in found.items():
        assert np.abs(values - pair[name]).max() < 0.51e-6, name
