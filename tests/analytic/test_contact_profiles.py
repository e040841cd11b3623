"""Built-in profiles: their joints close, their derivatives are those of their heights."""

import numpy as np
import pytest
from slab_track.contact.builtin_profiles import (
    rail_60e1,
    rail_60e1_manchester,
    rail_chn60,
    wheel_s1002,
)
from slab_track.contact.profiles import curvature

PROFILES = [wheel_s1002(), rail_60e1(), rail_60e1_manchester(), rail_chn60()]
NAMES = [profile.name for profile in PROFILES]


@pytest.mark.parametrize("profile", PROFILES, ids=NAMES)
def test_pieces_meet_and_are_tangent(profile):
    for left, right in zip(profile.pieces[:-1], profile.pieces[1:], strict=True):
        joint = np.array([left.end])
        assert left.end == right.start
        # EN 13715 prints the coefficients of S1002 to a joint of 1.2e-4 mm.
        assert left.derivative(joint, 0) == pytest.approx(right.derivative(joint, 0), abs=2e-7)
        if abs(left.derivative(joint, 1)[0]) < 10.0 and left.end > -0.0625:
            slopes = left.derivative(joint, 1), right.derivative(joint, 1)
            assert np.arctan(slopes[0]) == pytest.approx(np.arctan(slopes[1]), abs=2e-4)


@pytest.mark.parametrize("profile", PROFILES, ids=NAMES)
@pytest.mark.parametrize("order", [1, 2])
def test_derivatives(profile, order):
    step = 1e-7
    for piece in profile.pieces:
        y = np.linspace(piece.start, piece.end, 12)[1:-1]
        ahead = profile.derivative(y + step, order - 1)
        behind = profile.derivative(y - step, order - 1)
        found = profile.derivative(y, order)
        scale = 1.0 + np.abs(found)
        assert (ahead - behind) / (2 * step) / scale == pytest.approx(found / scale, abs=3e-4)


def test_rail_60e1_head_is_72_mm_wide_at_14_3_mm():
    corner = rail_60e1().pieces[-1].start
    assert corner == pytest.approx(36.0e-3, abs=1e-6)
    assert float(rail_60e1().derivative(corner)) == pytest.approx(14.3e-3, abs=1e-6)


def test_rail_chn60_head_is_70_8_mm_wide_where_its_flank_begins():
    assert 2 * rail_chn60().pieces[-1].start == pytest.approx(70.8e-3, abs=0.05e-3)


@pytest.mark.parametrize(("y", "radius"), [(0.004, 0.3), (0.018, 0.08), (-0.031, 0.013)])
def test_curvature_of_the_arcs(y, radius):
    assert curvature(rail_60e1(), y) == pytest.approx(1.0 / radius, rel=1e-9)


def test_wheel_s1002_flange_is_28_mm_high_and_70_degrees_steep():
    wheel = wheel_s1002()
    y = np.linspace(-0.0695, 0.03, 20000)
    assert wheel.derivative(y).max() == pytest.approx(28e-3, abs=0.01e-3)
    assert float(wheel.derivative(0.0)) == 0.0
    assert np.degrees(np.arctan(-wheel.derivative(-0.039, 1))) == pytest.approx(70.0, abs=0.01)


def test_outside_is_not_a_number():
    assert np.isnan(wheel_s1002().derivative(0.07))
