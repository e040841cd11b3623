"""fmpy's validation and its reader of SSP (the FMUs alone in it: tests/component)."""

import zipfile

import pytest
from fmpy import read_model_description
from fmpy.ssp.ssd import find_components, get_connections, read_ssd, read_ssv
from tool_hosts import STEPS, refusal_of_fmpy_ssp, run_fmpy_ssp

SETS = {"track": ("HD", "ZX", "paper", "start"), "vehicle": ("paper", "manchester1", "start")}


def test_the_fmus_of_the_package_are_those_that_fmpy_validates(pair, fmus):
    """In tests/system/test_contract.py."""
    with zipfile.ZipFile(pair.ssp) as archive:
        for path in fmus.both:
            assert archive.read(f"resources/{path.name}") == path.read_bytes()


def test_package_satisfies_the_ssp_schemas(pair):
    ssd = read_ssd(str(pair.ssp))  # validates, the bound parameter sets too
    components = {c.name: c for c in find_components(ssd.system)}
    assert sorted(components) == ["track", "vehicle"]
    assert len(list(get_connections(ssd.system))) == 4 * (11 + 6)
    bound = [b.source for b in components["track"].parameterBindings]
    assert bound == ["resources/track-HD.ssv", "resources/track-start.ssv"]
    for owner in ("track", "vehicle"):  # a value for what nothing is connected with, too
        start = read_ssv(str(pair.ssp), resource=f"resources/{owner}-start.ssv")
        with zipfile.ZipFile(pair.ssp) as archive, archive.open(components[owner].source) as fmu:
            about = read_model_description(fmu)
        inputs = {
            v.name for v in about.modelVariables if (v.causality, v.type) == ("input", "Real")
        }
        assert inputs <= {parameter.name for parameter in start.parameters}
        experiment = about.defaultExperiment
        assert (experiment.stopTime, experiment.stepSize) == ("1.0", "0.0001")


@pytest.mark.parametrize(("owner", "name"), [(o, n) for o, names in SETS.items() for n in names])
def test_parameter_sets_are_valid_and_declare_their_units(pair, owner, name):
    found = read_ssv(str(pair.ssp), resource=f"resources/{owner}-{name}.ssv")
    assert found.parameters
    with zipfile.ZipFile(pair.ssp) as archive:
        text = archive.read(f"resources/{owner}-{name}.ssv").decode()
    for parameter in found.parameters:
        unit = getattr(parameter, "unit", None)
        if unit:
            assert f'<ssc:Unit name="{unit}">' in text
    assert ' unit="' in text


def test_simulate_ssp_makes_the_same_run(fmus, pair):
    """Its algorithm is Jacobi, but for the first step, in which it gives every input 0.0.

    The set ``system-start`` has the FMUs keep what they know of each other.
    """
    for name, values in fmus.call(run_fmpy_ssp, pair.ssp).items():
        assert len(values) == STEPS
        assert (values == pair[name][1:]).all(), name


def test_simulate_ssp_without_the_set_is_refused(fmus, pair):
    """All positions are 0.0 then: four wheelsets in one place."""
    assert "longitudinal_position jumps" in fmus.call(refusal_of_fmpy_ssp, pair.ssp)
