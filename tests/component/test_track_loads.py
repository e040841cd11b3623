"""The example of forces of one's own on the track, against Fourier integrals."""

import importlib.util
from pathlib import Path

import pytest
from fmu_probes import example_loads

EXAMPLE = Path(__file__).parents[2] / "examples" / "track_alone" / "loads.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("loads", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def loads(fmus):
    return fmus.call(example_loads, EXAMPLE, fmus.track)


def test_moving_constant_load(loads):
    found, expected = loads["moving_load"]
    assert found == pytest.approx(expected, rel=1e-3)


def test_harmonic_load(loads):
    """In amplitude and phase."""
    found, expected = loads["harmonic_load"]
    assert abs(found - expected) < 5e-3 * abs(expected)


def test_the_closed_forms_meet_where_both_are_static(example):
    """And there they are the known one of a beam on springs, with little shear."""
    static = example.harmonic_deflection(1e-6).real
    assert example.moving_deflection(1e-6) == pytest.approx(static, rel=1e-6)
    e, _, _, _, second, _ = example.RAIL.values()
    stiffness = example.PAD_STIFFNESS / example.SPACING
    bernoulli = example.FORCE / (8**0.5 * (stiffness**3 * e * second) ** 0.25)
    assert bernoulli < static < 1.2 * bernoulli
