"""The OSP configuration in libcosim."""

from tool_hosts import SLIDES, relative_difference, run_libcosim

TOOL = "libcosimpy"


def test_libcosim_makes_the_same_run(fmus, pair):
    """Its fixed-step algorithm is Jacobi; its time is a whole number of nanoseconds."""
    found = fmus.call(run_libcosim, pair.folder)
    assert found.pop(SLIDES)[-1] == pair[SLIDES][-1]
    for name, values in found.items():
        assert relative_difference(values, pair[name]) <= 1e-9, name
