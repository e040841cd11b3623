"""Contact geometry where it has a closed form: cones, circles; and its own consistency."""

import json
import math
from dataclasses import fields

import numpy as np
import pytest
import slab_track.contact.__main__ as command
from rail_quantities import ParameterError
from scipy.integrate import quad
from slab_track.contact import (
    ContactGeometry,
    ContactTable,
    RailPlacement,
    contact_table,
    equivalent_conicity,
    load_profile,
)
from slab_track.contact.builtin_profiles import rail_of_arcs
from slab_track.contact.overlap import CURVATURE, FLANGE, HEIGHT, RAIL_Y, SLOPE, TREAD
from slab_track.contact.profiles import ArcPiece, PiecewiseProfile, PolynomialPiece

CONE = 0.05
PLACEMENT = RailPlacement(rolling_circle_distance=1.5)


def cone_wheel():
    piece = PolynomialPiece(start=-0.05, end=0.06, coefficients=(0.0, -CONE))
    return PiecewiseProfile(name="cone", pieces=(piece,))


def hollow_wheel(radius):
    """Return a concave arc, lowest towards the flange, centred below the rolling circle."""
    piece = ArcPiece(
        start=-0.05, end=0.06, centre_y=0.05 * radius, centre_z=radius, radius=radius, side=-1.0
    )
    return PiecewiseProfile(name="hollow", pieces=(piece,))


def round_rail():
    return rail_of_arcs("round", joints=(28.0, 30.0), radii=(300.0, 80.0, 13.0))


@pytest.mark.parametrize("roll", [0.0, 3e-3])
def test_cone_on_a_round_head(roll):
    geometry = ContactGeometry(cone_wheel(), round_rail(), PLACEMENT, reference_penetration=1e-5)
    patch = geometry.patches(2e-3, roll)[TREAD]
    angle = math.atan(-CONE) + roll
    crown = geometry.rail.lateral[np.argmin(geometry.rail.height)]
    assert patch[SLOPE] == pytest.approx(math.tan(angle), abs=2e-5)
    assert patch[RAIL_Y] - crown == pytest.approx(0.3 * math.sin(angle), abs=1e-5)
    assert patch[CURVATURE] == pytest.approx(0.5 / 0.3, rel=2e-3)


@pytest.mark.parametrize("penetration", [1e-6, 1e-5, 1e-4])
def test_relative_curvature_does_not_depend_on_the_reference_for_circles(penetration):
    wheel = hollow_wheel(0.5)
    geometry = ContactGeometry(
        wheel, round_rail(), PLACEMENT, reference_penetration=penetration, spacing=2e-5
    )
    patch = geometry.patches(0.0)[TREAD]
    assert patch[CURVATURE] == pytest.approx(0.5 * (1 / 0.3 - 1 / 0.5), rel=5e-3)


@pytest.mark.parametrize("shift", [-3e-3, 0.0, 4e-3])
def test_first_touch_height_has_the_contact_slope(shift):
    # The envelope's slope is the tangent of the contact angle, away from jumps.
    geometry = ContactGeometry(
        hollow_wheel(0.5), round_rail(), PLACEMENT, reference_penetration=1e-6
    )
    step = 1e-4
    ahead, here, behind = (geometry.patches(shift + d)[TREAD] for d in (step, 0.0, -step))
    rate = (ahead[HEIGHT] - behind[HEIGHT]) / (2 * step)
    assert -rate == pytest.approx(-here[SLOPE], abs=1e-5)


def test_cone_on_round_heads_has_the_conicity_of_the_linear_theory():
    # A. H. Wickens: lambda = (R_w g / (R_w - R_r)) (l + r g) / (l - R_r g), here R_w infinite,
    # l half the distance of the contact points, g the cone's tangent.
    contact = 0.75
    linear = CONE * (contact + 0.46 * CONE) / (contact - 0.3 * CONE)
    geometry = ContactGeometry(
        cone_wheel(), round_rail(), PLACEMENT, reference_penetration=1e-6, spacing=2e-5
    )
    lateral = np.linspace(-5e-3, 5e-3, 11)
    table = contact_table(geometry, lateral)
    expected = 2.0 * linear * lateral
    assert table.rolling_radius_difference == pytest.approx(expected, rel=2e-3, abs=1e-7)
    found = equivalent_conicity(lateral, table.rolling_radius_difference, amplitude=3e-3)
    assert found == pytest.approx(linear, rel=2e-3)


def test_conicity_of_a_cubic_by_its_exact_wavelength():
    # y'' = -c y^3: quarter period B(1/4, 1/2) / (4 A sqrt(c/2)) = 1.854075 / (A sqrt(c)).
    lateral, cubic = np.linspace(-8e-3, 8e-3, 401), 700.0
    amplitude = 4e-3
    found = equivalent_conicity(lateral, cubic * lateral**3, amplitude=amplitude)
    quarter = 1.854074677 / (amplitude * math.sqrt(cubic))
    assert found == pytest.approx(0.5 * (math.pi / (2.0 * quarter)) ** 2, rel=1e-4)


def test_conicity_of_a_hollow_wheel_is_defined_beyond_the_hollow_only():
    # y'' = c y - d y^3: turning points at A only where the potential -c y^2/2 + d y^4/4 exceeds 0.
    lateral, c = np.linspace(-8e-3, 8e-3, 401), 0.02
    d = 2.0 * c / 4e-3**2  # the potential is 0 at 4 mm again
    difference = d * lateral**3 - c * lateral
    with pytest.raises(ParameterError, match=r"amplitude = 0\.003: no kinematic motion.*hollow"):
        equivalent_conicity(lateral, difference, amplitude=3e-3)
    amplitude = 5e-3
    found = equivalent_conicity(lateral, difference, amplitude=amplitude)

    def slowness(y):
        energy = 0.25 * d * (amplitude**4 - y**4) - 0.5 * c * (amplitude**2 - y**2)
        return 1.0 / math.sqrt(2.0 * energy)

    ends = {"points": [0.0], "limit": 200}
    half_wave = quad(slowness, -amplitude * (1 - 1e-12), amplitude * (1 - 1e-12), **ends)[0]
    assert found == pytest.approx(0.5 * (math.pi / half_wave) ** 2, rel=2e-3)


def test_the_command_says_why_a_conicity_is_not_defined(tmp_path, monkeypatch, capsys):
    def hollow(geometry, lateral):
        sides = {"contact_angle", "wheel_position", "rail_position"}
        columns = {f.name: np.zeros((9, 2) if f.name in sides else 9) for f in fields(ContactTable)}
        columns |= {"lateral_displacement": lateral, "rolling_radius_difference": -0.02 * lateral}
        return ContactTable(**columns)

    monkeypatch.setattr(command, "contact_table", hollow)
    assert command.main(["--points", "9", "--out", str(tmp_path / "hollow.json")]) == 0
    assert "conicity at 3 mm: not defined: no kinematic motion" in capsys.readouterr().out
    about = json.loads((tmp_path / "hollow.json").read_text())["about"]
    assert "hollow tread" in about["equivalent_conicity_not_defined"]


@pytest.fixture(scope="module")
def s1002_on_60e1():
    return ContactGeometry(
        load_profile("wheel", "S1002"),
        load_profile("rail", "60E1"),
        PLACEMENT,
        reference_penetration=1e-6,
        spacing=2e-5,
    )


def test_table_of_s1002_on_60e1_is_antisymmetric(s1002_on_60e1):
    lateral = np.array([-8e-3, -5.5e-3, -3e-3, -1e-3, 0.0, 1e-3, 3e-3, 5.5e-3, 8e-3])
    table = contact_table(s1002_on_60e1, lateral)
    assert table.rolling_radius_difference == pytest.approx(
        -table.rolling_radius_difference[::-1], abs=1e-8
    )
    assert table.roll_angle == pytest.approx(-table.roll_angle[::-1], abs=1e-9)
    assert table.rail_position[:, 0] == pytest.approx(table.rail_position[::-1, 1], abs=1e-7)
    # To the right the right wheel climbs its flange: larger radius, steep.
    assert table.rolling_radius_difference[-1] > 15e-3
    assert table.contact_angle[-1, 1] > 0.9 > 0.02 > table.contact_angle[-1, 0]
    assert np.all(np.diff(table.rolling_radius_difference) > 0.0)


def test_flange_is_a_patch_of_its_own(s1002_on_60e1):
    before, after = (s1002_on_60e1.patches(shift) for shift in (6.0e-3, 7.5e-3))
    assert before[FLANGE, HEIGHT] > before[TREAD, HEIGHT]
    assert after[FLANGE, HEIGHT] < after[TREAD, HEIGHT]
    assert math.degrees(math.atan(-after[FLANGE, SLOPE])) == pytest.approx(70.0, abs=1.0)


def test_gauge_and_inclination_are_those_asked_for():
    geometry = ContactGeometry(
        cone_wheel(), load_profile("rail", "60E1"), RailPlacement(gauge=1.440, gauge_depth=0.014)
    )
    rail = geometry.rail
    inner = rail.lateral < rail.lateral[np.argmin(rail.height)]
    face = np.interp(-0.014, -rail.height[inner], rail.lateral[inner])
    assert 2 * face == pytest.approx(1.440, abs=2e-6)
    # The crown's normal is vertical: 300 mm * 1/40 beside the rail's own axis, to the field side.
    crown = rail.lateral[np.argmin(rail.height)]
    own_axis = rail.axis[0] - math.sin(math.atan(0.025)) * 0.095
    assert crown - own_axis == pytest.approx(0.3 * math.sin(math.atan(0.025)), abs=6e-5)
