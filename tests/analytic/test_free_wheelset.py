"""A free wheelset with creep forces: Klingel's wavelength, momentum and energy."""

import math

import numpy as np
import pytest
from free_wheelset import WORK, WORST_POWER, Wheelset, energy, motion_row, run, start
from slab_track.contact import ContactParameters, WheelRailContact
from slab_track.contact.wheelset import ARM_Y, ARM_Z

CONICITY, RADIUS, LOAD = 0.05, 0.46, 2.0 * 69.21e3
BODY = Wheelset(mass=1780.0, load=LOAD, diametral=967.0, polar=123.0)
HERTZ = 4.221e-8


@pytest.fixture(scope="module")
def contact(tmp_path_factory):
    """Cones of 1:20 without flange on 60E1."""
    path = tmp_path_factory.mktemp("cone") / "cone.txt"
    y = np.arange(-50.0, 35.01, 0.5)
    np.savetxt(path, np.column_stack([y, -CONICITY * y]))
    parameters = ContactParameters(
        wheel_profile=str(path), rail_profile="60E1", hertz_constant=HERTZ
    )
    return WheelRailContact.build(parameters, gauge_measurement_depth=0.014)


def settled(contact, y):
    """Return height and roll at which a wheelset held at y carries its load without roll moment."""
    height, roll = 70e-6, 0.0
    for _ in range(200):
        row = np.zeros((1, 11))
        row[0, [1, 2, 3, 5, 10]] = y, height, roll, 5.0, -5.0 / RADIUS
        force = contact.evaluate(row).wheelset[0]
        missing = LOAD + force[2]
        height += 0.3 * missing / 2.9e9
        roll += 0.3 * force[3] / (2.9e9 * 0.7465**2)
    assert abs(missing) < 1.0
    assert abs(force[3]) < 1.0
    return height, roll


def test_klingel_wavelength_of_conical_wheels(contact):
    """2 pi sqrt(r b / gamma) at walking pace.

    Left are: the contact point wanders on the rail's crown as the axle rolls, which raises
    the conicity by gamma R_rail / b (2 %, 1 % of the wavelength), and inertia, below 0.5 %
    at 5 m/s. With the conicity of the contact points themselves, over the displacement at
    rail level (the axle's less r times its roll), the agreement is within 0.5 %.
    """
    y, speed = 2e-3, 5.0
    height, roll = settled(contact, y)
    body = BODY._replace(dashpot=2e5)
    found = run(
        contact,
        body,
        start(body, y=y, z=height, roll=roll, speed=speed, spin=-speed / RADIUS),
        steps=24000,
        step=1.5e-4,
    )
    x, lateral = found[:, 0], found[:, 1]
    crossing = np.nonzero(np.diff(np.sign(lateral)))[0]
    place = x[crossing] - lateral[crossing] * (x[crossing + 1] - x[crossing]) / (
        lateral[crossing + 1] - lateral[crossing]
    )
    wavelength = 2.0 * float(np.mean(np.diff(place[:3])))
    row, _ = motion_row(body, start(body, y=y, z=height, roll=roll, speed=speed, spin=0.0))
    tread = contact.evaluate(row[None]).located[0, :, 0]
    arm = 0.5 * (tread[1, ARM_Y] - tread[0, ARM_Y])
    radii = tread[:, ARM_Z] * math.cos(roll) - tread[:, ARM_Y] * math.sin(roll)
    conicity = (radii[1] - radii[0]) / (2.0 * (y - RADIUS * roll))
    assert wavelength == pytest.approx(2 * math.pi * math.sqrt(RADIUS * arm / conicity), rel=0.005)
    assert wavelength == pytest.approx(
        2 * math.pi * math.sqrt(RADIUS * 0.7465 / CONICITY), rel=0.02
    )
    # Yaw follows the path: no lateral creepage to speak of.
    yaw = np.arctan2(-found[:, 6], found[:, 7])
    slope = np.gradient(lateral - RADIUS * np.arcsin(found[:, 8]), x)
    assert np.max(np.abs(yaw - slope)[4000:]) < 0.01 * np.max(np.abs(slope))


@pytest.mark.parametrize("slip", [0.002, -0.002])
def test_spinning_wheelset_shares_its_momentum(contact, slip):
    """Linear and angular momentum in free rolling: m v - I spin / r is kept."""
    speed, height = 10.0, settled(contact, 0.0)[0]
    spin = -speed / RADIUS * (1.0 + slip)
    found = run(contact, BODY, start(BODY, z=height, speed=speed, spin=spin), steps=400, step=2e-5)
    row, _ = motion_row(BODY, found[-1])
    arm = contact.evaluate(row[None]).located[0, 0, 0, ARM_Z]
    expected = (BODY.mass * speed - BODY.polar * spin / arm) / (BODY.mass + BODY.polar / arm**2)
    assert found[-1, 3] - speed == pytest.approx(expected - speed, rel=0.01)
    assert row[10] == pytest.approx(-row[5] / arm, rel=1e-5)
    assert abs(found[-1, 1]) < 1e-12


@pytest.mark.parametrize(
    "disturbance",
    [{"y": 3e-3}, {"yaw": 3e-3}, {"y": 1e-3, "yaw": -2e-3, "roll": 2e-5}],
)
def test_energy_goes_only_into_creep(contact, disturbance):
    """Change of kinetic, potential and Hertz energy = work of the creep forces at the patches."""
    speed, height = 20.0, settled(contact, disturbance.get("y", 0.0))
    given = {"z": height[0], "roll": height[1], **disturbance}
    first = start(BODY, **given, speed=speed, spin=-speed / RADIUS * 1.001)
    found = run(contact, BODY, first, steps=10000, step=2e-5)
    work = found[-1, WORK]
    change = energy(contact, BODY, found[-1]) - energy(contact, BODY, first)
    assert work < -4.0
    assert found[-1, WORST_POWER] <= 0.0
    assert change == pytest.approx(work, rel=0.005)
    halfway = energy(contact, BODY, found[4999]) - energy(contact, BODY, first)
    assert halfway == pytest.approx(found[4999, WORK], rel=0.005)
