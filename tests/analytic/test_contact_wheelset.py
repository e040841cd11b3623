"""Contact of a wheelset: balance, symmetry, kinematics, penetration gradient, smoothness."""

import math

import numpy as np
import pytest
from slab_track.contact import (
    ContactGeometry,
    ContactParameters,
    RailPlacement,
    WheelRailContact,
    hertz_contact,
    load_profile,
)
from slab_track.contact.overlap import HEIGHT, RAIL_Y, SLOPE
from slab_track.contact.wheelset import (
    ANGLE,
    ARM_Y,
    LATERAL_CREEPAGE,
    LATERAL_FORCE,
    LONGITUDINAL_CREEPAGE,
    LONGITUDINAL_FORCE,
    NORMAL_FORCE,
    PENETRATION,
    RAIL_ARM_Y,
    RAIL_ARM_Z,
    SEMI_AXIS_A,
    SEMI_AXIS_B,
    SPIN,
    STIFFNESS,
    normal_force,
)

V = 300 / 3.6
X, Y, Z, ROLL, YAW, VX, VY, VZ, ROLL_RATE, YAW_RATE, PITCH_RATE = range(11)
LEFT, RIGHT, TREAD, FLANGE = 0, 1, 0, 1


@pytest.fixture(scope="module")
def contact():
    return WheelRailContact.build(
        ContactParameters(rail_profile="60E1"), gauge_measurement_depth=0.014
    )


def motion_of(**values):
    row = np.zeros((1, 11))
    row[0, [Z, VX, PITCH_RATE]] = 70e-6, V, -V / 0.46
    for name, value in values.items():
        row[0, globals()[name]] = value
    return row


RUNNING = {
    "Y": 1.3e-3, "Z": 75e-6, "ROLL": 2e-5, "YAW": 8e-4, "VY": 0.03, "VZ": -0.02,
    "ROLL_RATE": 0.01, "YAW_RATE": -0.02,
}  # fmt: skip
RAILS = np.array([[[1e-4, 5e-4, 4e-4, 0.01, -0.02, 0.03], [-2e-4, 6e-4, -3e-4, 0.02, 0.01, 0.0]]])
SINK = 5.6e-4


def test_forces_and_moments_balance(contact):
    motion = motion_of(**RUNNING)
    motion[0, Z] += SINK
    result = contact.evaluate(motion, RAILS)
    assert np.all(result.forces[0, :, TREAD, NORMAL_FORCE] > 1e4)
    force = result.wheelset[0, 1:3] + result.rail[0].sum(axis=0)[:2]
    assert force == pytest.approx([0.0, 0.0], abs=1e-9 * 1e5)
    # Roll moment about the centre: what the rails' forces and moments give from their axes.
    roll = result.wheelset[0, 3]
    for k in (LEFT, RIGHT):
        row = result.located[0, k, TREAD]
        axis_y, axis_z = row[ARM_Y] - row[RAIL_ARM_Y], row[4] - row[RAIL_ARM_Z]
        f_y, f_z, moment = result.rail[0, k]
        roll += moment + axis_y * f_z - axis_z * f_y
    assert roll == pytest.approx(0.0, abs=1e-9 * 1e5)


def test_mirror_image(contact):
    motion = motion_of(**RUNNING)
    motion[0, Z] += SINK
    mirrored = motion.copy()
    mirrored[0, [Y, ROLL, YAW, VY, ROLL_RATE, YAW_RATE]] *= -1.0
    rails = RAILS[:, ::-1] * np.array([-1.0, 1.0, -1.0, -1.0, 1.0, -1.0])
    one, other = contact.evaluate(motion, RAILS), contact.evaluate(mirrored, rails)
    sign = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    assert other.wheelset[0] == pytest.approx(sign * one.wheelset[0], rel=1e-9, abs=1e-5)


def test_centred_wheelset_carries_hertz_force_and_no_lateral_force(contact):
    motion = motion_of()
    result = contact.evaluate(motion)
    row = result.located[0, RIGHT, TREAD]
    assert row[PENETRATION] == pytest.approx(70e-6 * math.cos(row[ANGLE]), rel=2e-3)
    n = row[STIFFNESS] * row[PENETRATION] ** 1.5
    assert result.forces[0, :, TREAD, NORMAL_FORCE] == pytest.approx([n, n], rel=1e-12)
    assert result.wheelset[0, [1, 3, 5]] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert result.wheelset[0, 2] == pytest.approx(-2 * n * math.cos(row[ANGLE]), rel=2e-3)


def test_ellipse_is_that_of_the_exact_hertz_theory(contact):
    result = contact.evaluate(motion_of(Y=2.1e-3))
    tables = contact.tables
    for k in (LEFT, RIGHT):
        found, row = result.forces[0, k, TREAD], result.located[0, k, TREAD]
        radius = math.hypot(row[4], 0.0)
        ratio = found[SEMI_AXIS_A] / found[SEMI_AXIS_B]
        curvature_a = 0.5 * math.cos(row[ANGLE]) / radius
        exact = [
            hertz_contact(found[NORMAL_FORCE], curvature_a, b, tables.modulus)
            for b in np.geomspace(0.05, 50.0, 3001)
        ]
        nearest = min(exact, key=lambda c: abs(c.semi_axis_a / c.semi_axis_b - ratio))
        assert found[SEMI_AXIS_A] == pytest.approx(nearest.semi_axis_a, rel=2e-3)
        assert row[STIFFNESS] == pytest.approx(nearest.stiffness_constant, rel=2e-3)


def test_separation_gives_no_force(contact):
    result = contact.evaluate(motion_of(Z=-1e-4))
    assert np.all(result.wheelset == 0.0)
    assert np.all(result.located[0, :, TREAD, PENETRATION] < 0.0)


# At 4.2 mm two contact points swap: the averaged angle and the deepest point's differ most.
@pytest.mark.parametrize(("y", "tolerance"), [(0.0, 0.004), (-3e-3, 0.004), (4.2e-3, 0.025)])
@pytest.mark.parametrize("body", ["wheel", "rail"])
def test_penetration_gradient(contact, y, tolerance, body):
    """``-sin(g) u_y + cos(g) u_z``: the slope that an implicit integrator needs."""
    motion, rails = motion_of(Y=y, Z=90e-6), np.zeros((1, 2, 6))
    before = contact.evaluate(motion, rails).located[0, RIGHT, TREAD]
    step = 2e-6
    for column, coefficient in ((Y, -math.sin(before[ANGLE])), (Z, math.cos(before[ANGLE]))):
        moved, carried = motion.copy(), rails.copy()
        if body == "wheel":
            moved[0, column] += step
        else:
            carried[0, RIGHT, column - 1] -= step
        after = contact.evaluate(moved, carried).located[0, RIGHT, TREAD]
        rate = (after[PENETRATION] - before[PENETRATION]) / step
        assert rate == pytest.approx(coefficient, abs=tolerance)


def test_wheelset_and_track_turned_together_change_nothing(contact):
    """Both rails and the wheelset turned as one body: the same contact in turned axes."""
    roll, tables = 2e-3, contact.tables
    base = contact.evaluate(motion_of(Y=1e-3, Z=8e-5))
    motion, rails = motion_of(Y=1e-3, Z=8e-5), np.zeros((1, 2, 6))
    cosine, sine = math.cos(roll), math.sin(roll)
    height = 8e-5 + tables.touch_height - tables.wheel_radius
    motion[0, Y] = cosine * 1e-3 - sine * height
    motion[0, Z] += sine * 1e-3 + cosine * height - height
    motion[0, ROLL] = roll
    for k, side in ((LEFT, -1.0), (RIGHT, 1.0)):
        y, z = side * tables.axis_y, tables.axis_z
        rails[0, k, :3] = cosine * y - sine * z - y, sine * y + cosine * z - z, roll
    turned = contact.evaluate(motion, rails)
    for k in (LEFT, RIGHT):
        one, other = base.located[0, k, TREAD], turned.located[0, k, TREAD]
        assert other[PENETRATION] == pytest.approx(one[PENETRATION], abs=1e-12)
        assert other[ANGLE] - roll == pytest.approx(one[ANGLE], abs=1e-9)


def test_moving_together_makes_no_creepage(contact):
    motion, rails = motion_of(VY=0.2, VZ=0.1), np.zeros((1, 2, 6))
    rails[0, :, 3], rails[0, :, 4] = 0.2, 0.1
    still = contact.evaluate(motion_of()).forces
    together = contact.evaluate(motion, rails).forces
    assert together == pytest.approx(still, rel=1e-9, abs=1e-9)


def test_creepages_of_elementary_motions(contact):
    still = contact.evaluate(motion_of()).forces[0, RIGHT, TREAD]
    row = contact.evaluate(motion_of()).located[0, RIGHT, TREAD]
    lateral = contact.evaluate(motion_of(VY=0.1)).forces[0, RIGHT, TREAD]
    eta = lateral[LATERAL_CREEPAGE] - still[LATERAL_CREEPAGE]
    assert eta == pytest.approx(0.1 * math.cos(row[ANGLE]) / V, rel=1e-3)
    yawed = contact.evaluate(motion_of(YAW=1e-3)).forces[0, RIGHT, TREAD]
    assert yawed[LATERAL_CREEPAGE] == pytest.approx(-1e-3, rel=0.02)
    yawing = contact.evaluate(motion_of(YAW_RATE=0.05)).forces[0, RIGHT, TREAD]
    xi = yawing[LONGITUDINAL_CREEPAGE] - still[LONGITUDINAL_CREEPAGE]
    assert xi == pytest.approx(-0.05 * row[ARM_Y] / V, rel=1e-2)
    assert still[SPIN] == pytest.approx(-math.sin(row[ANGLE]) * (-V / 0.46) / V, rel=1e-3)


def test_creep_force_opposes_creepage_and_obeys_coulomb(contact):
    for values in ({"VY": 0.05}, {"YAW": 2e-3}, {"YAW_RATE": 0.5}, {"Y": 4e-3, "VY": -0.3}):
        found = contact.evaluate(motion_of(**values)).forces[0, :, TREAD]
        work = found[:, LONGITUDINAL_FORCE] * found[:, LONGITUDINAL_CREEPAGE]
        work += found[:, LATERAL_FORCE] * found[:, LATERAL_CREEPAGE]
        assert np.all(work < 0.0)
        size = np.hypot(found[:, LONGITUDINAL_FORCE], found[:, LATERAL_FORCE])
        assert np.all(size <= 0.3 * found[:, NORMAL_FORCE] * 1.005)


def test_running_backwards_is_the_image_of_running_forwards(contact):
    forwards = contact.evaluate(motion_of(Y=1e-3, VY=0.05))
    backwards = contact.evaluate(motion_of(Y=1e-3, VY=0.05, VX=-V, PITCH_RATE=V / 0.46))
    # The lateral slip is the same, the longitudinal one reversed.
    assert backwards.wheelset[0, [0, 4]] == pytest.approx(-forwards.wheelset[0, [0, 4]], rel=1e-6)
    assert backwards.wheelset[0, 1:4] == pytest.approx(forwards.wheelset[0, 1:4], rel=1e-6)


def test_flange_and_tread_carry_together(contact):
    motion = motion_of(Y=10.0e-3, Z=-624e-6, ROLL=-6e-4)
    result = contact.evaluate(motion)
    forces = result.forces[0, RIGHT, :, NORMAL_FORCE]
    assert np.all(forces > 0.0)
    assert math.degrees(-result.located[0, RIGHT, FLANGE, ANGLE]) > 55.0
    assert result.wheelset[0, 1] < 0.0  # pushed back to the left


@pytest.mark.parametrize(("roll", "yaw"), [(0.0, 0.0), (1.37e-3, 0.0), (-0.6e-3, 1e-3)])
def test_tables_agree_with_the_direct_computation(contact, roll, yaw):
    parameters = ContactParameters(rail_profile="60E1")
    direct = ContactGeometry(
        load_profile("wheel", "S1002"), load_profile("rail", "60E1"), RailPlacement(),
        reference_penetration=parameters.reference_penetration,
    )  # fmt: skip
    b, radius = 0.7465, 0.46
    for y in np.linspace(-6e-3, 5.8e-3, 14):
        shift = y + math.cos(yaw) * (b * math.cos(roll) - radius * math.sin(roll)) - b
        exact = direct.patches(shift, roll, yaw)[TREAD]
        lowering = b * math.sin(roll) + radius * (math.cos(roll) - 1.0)
        touch = exact[HEIGHT] - lowering - contact.tables.touch_height
        depth = 40e-6
        motion = motion_of(Y=y, Z=touch + depth, ROLL=roll, YAW=yaw)
        row = contact.evaluate(motion).located[0, RIGHT, TREAD]
        assert row[PENETRATION] == pytest.approx(depth * math.cos(row[ANGLE]), abs=1.0e-6)
        assert row[ANGLE] == pytest.approx(math.atan(exact[SLOPE]), abs=2e-3)
        assert row[ARM_Y] + y == pytest.approx(exact[RAIL_Y], abs=0.2e-3)


def test_forces_are_continuous_over_the_lateral_displacement(contact):
    """No jump anywhere, the flange included: increments shrink with the step."""
    largest = []
    for step in (2e-6, 1e-6):
        y = np.arange(-6.5e-3, 6.5e-3, step)
        motion = np.repeat(motion_of(Z=60e-6), y.size, axis=0)
        motion[:, Y] = y
        force = contact.evaluate(motion).wheelset
        largest.append(np.abs(np.diff(force, axis=0)).max(axis=0))
    vertical_stiffness = 2.0e9
    assert largest[0][2] < 0.7 * vertical_stiffness * 2e-6
    assert np.all(largest[1] < 0.65 * largest[0])


def test_out_of_the_tables_is_told(contact):
    assert contact.evaluate(motion_of(Y=5e-3)).inside
    assert not contact.evaluate(motion_of(Y=30e-3)).inside


def test_hertz_constant_overrides_the_profiles():
    parameters = ContactParameters(hertz_constant=4.221e-8)
    row = WheelRailContact.build(parameters).evaluate(motion_of(Z=71.1e-6)).located[0, LEFT, TREAD]
    force, slope = normal_force(row[STIFFNESS], row[PENETRATION])
    # Eq. (1): 69.21 kN at 71.1 um, stiffness 1.459e9 N/m, both along the normal.
    assert force == pytest.approx((row[PENETRATION] / 4.221e-8) ** 1.5, rel=1e-9)
    assert force == pytest.approx(69.21e3, rel=3e-3)
    assert slope == pytest.approx(1.459e9, rel=2e-3)


def test_irregularity_is_a_displaced_rail(contact):
    offsets, rails = np.zeros((1, 2, 2)), np.zeros((1, 2, 6))
    offsets[0, RIGHT] = 3e-4, -2e-5
    rails[0, RIGHT, :2] = 3e-4, -2e-5
    by_offset = contact.evaluate(motion_of(), None, offsets)
    by_rail = contact.evaluate(motion_of(), rails)
    assert by_offset.wheelset == pytest.approx(by_rail.wheelset, rel=1e-12, abs=1e-9)
