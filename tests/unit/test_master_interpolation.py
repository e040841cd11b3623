"""What the master says of a step is what the FMUs do in it."""

import numpy as np
import pytest
from rail_cosim.interpolation import NODES, POINTS, QUADRATURE, hermite, polynomial, rate
from rail_vehicle.coupling import ForceHistory
from slab_track.kernels.motion import extrapolate

H = 2e-4
TIMES = H * np.array(POINTS)


def motion(time):
    """Positions and velocities of one wheelset, and a pitch rate, (1, 11)."""
    row = np.zeros((1, 11))
    for channel, omega in enumerate((300.0, 900.0, 1500.0, 2500.0, 4000.0)):
        row[0, channel] = np.sin(omega * time + channel)
        row[0, 5 + channel] = omega * np.cos(omega * time + channel)
    row[0, 10] = np.sin(2000.0 * time)
    return row


@pytest.mark.parametrize("newest", [0, 1])
def test_motion_is_that_which_the_track_takes(newest):
    now, before = motion(newest * H), motion((newest - 1) * H)
    points = np.array([motion(time)[0] for time in TIMES])
    for node, s in enumerate(NODES):
        taken = np.zeros((1, 11))
        extrapolate((s - newest) * H, H, now, before, np.ones(5), taken)
        weights = hermite(newest)
        velocity = weights.of_velocities[node] @ points[:, 5:10]
        velocity += weights.of_positions[node] @ points[:, :5] / H
        assert velocity == pytest.approx(taken[0, 5:10], rel=1e-9)
        spin = rate(polynomial(newest, 1)).of_velocities[node] @ points[:, 10]
        assert spin == pytest.approx(taken[0, 10], rel=1e-12)


@pytest.mark.parametrize("newest", [0, 1])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_force_is_that_which_the_vehicle_takes(newest, order):
    values = np.random.default_rng(1).normal(size=(len(POINTS), 4, 6))
    history = ForceHistory.begin(values[newest])
    for point in range(newest + 1, newest + 3):
        history = history.append(values[point], H)
    taken = history.interpolate(order) if newest else history.extrapolate(H, order)
    for node, s in enumerate(NODES):
        expected = taken.start + (taken.end - taken.start) * s + taken.quadratic * s * (s - 1.0)
        found = np.tensordot(polynomial(newest, order)[node], values, axes=1)
        assert found == pytest.approx(expected, rel=1e-9)


def test_quadrature_is_exact_for_a_cubic_times_a_cubic():
    for power in range(7):
        assert QUADRATURE @ NODES**power == pytest.approx(1.0 / (power + 1), rel=1e-13)
