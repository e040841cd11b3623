"""The vehicle's vertical behaviour against the article's model of ten degrees of freedom."""

import numpy as np
import pytest
from rail_vehicle import PAPER, VehicleModel
from rail_vehicle.coordinates import FREE, WHEELSET_COORDINATES

# Car body z, pitch; bogies z, pitch; wheelsets z. Written from Table 2 alone.
MASS = np.diag([44039.0, 1.69e6, 2439.0, 1846.0, 2439.0, 1846.0, *[1881.0] * 4])


def ten_by_ten(primary, secondary):
    """Matrix of the elements (per wheelset, per bogie), shape (10, 10)."""
    matrix = np.zeros((10, 10))
    for bogie, x in ((2, 8.9), (4, -8.9)):
        row = np.zeros(10)
        # A pitch angle lifts what is ahead: z grows downwards.
        row[[0, 1, bogie]] = 1.0, -x, -1.0
        matrix += secondary * np.outer(row, row)
        for axle, dx in ((0, 1.25), (1, -1.25)):
            row = np.zeros(10)
            row[[bogie, bogie + 1, 6 + (bogie - 2) + axle]] = 1.0, -dx, -1.0
            matrix += primary * np.outer(row, row)
    return matrix


STIFFNESS = ten_by_ten(2 * 9.0e6, 2 * 0.24e6)
DAMPING = ten_by_ten(2 * 10.5e3, 2 * 25.0e3)


def receptance(mass, damping, stiffness, frequency):
    omega = 2.0 * np.pi * frequency
    return np.linalg.inv(stiffness + 1j * omega * damping - omega**2 * mass)


@pytest.mark.parametrize(
    ("frequency", "tolerance"),
    # At 2 Hz levers of the longitudinal suspension and the toppling weight take part.
    [
        *((2.0, 0.07), (10.0, 3e-3), (17.0, 5e-3), (28.0, 0.02), (44.2, 3e-3)),
        *((60.0, 3e-4), (88.0, 1e-4), (132.0, 1e-5), (150.0, 1e-5), (500.0, 1e-5)),
    ],
)
def test_wheelsets_answer_vertical_forces_as_in_the_article(frequency, tolerance):
    """Beyond the bogies' resonances, where sleepers pass, nothing but Table 2 is felt."""
    simple = receptance(MASS, DAMPING, STIFFNESS, frequency)[6:, 6:]
    system = VehicleModel(PAPER).linear_system()
    pick = np.ix_(FREE, FREE)
    full = receptance(system.mass[pick], system.damping[pick], system.stiffness[pick], frequency)
    vertical = np.searchsorted(FREE, WHEELSET_COORDINATES[:, 2])
    found = full[np.ix_(vertical, vertical)]
    assert np.abs(found - simple).max() < tolerance * np.abs(simple).max()
