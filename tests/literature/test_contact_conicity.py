"""Equivalent conicity against the reference results of EN 15302."""

import numpy as np
import pytest
from slab_track.contact import (
    ContactGeometry,
    RailPlacement,
    contact_table,
    equivalent_conicity,
    load_profile,
)

# Benchmark case E1 of EN 15302: rolling radius difference in mm every 0.1 mm of lateral
# displacement, and the reference conicities with their tolerance; both as tabulated in the
# public data of the project B_ECC-Equivalent-Conicity-Calculation (files dr_ce_E1, ben_E1).
DIFFERENCE = [
    0.0, 0.032, 0.051, 0.071, 0.092, 0.116, 0.142, 0.167, 0.197, 0.227, 0.257, 0.292, 0.328, 0.361,
    0.402, 0.443, 0.481, 0.527, 0.574, 0.616, 0.667, 0.719, 0.766, 0.822, 0.879, 0.931, 0.992,
    1.055, 1.111, 1.177, 1.236, 1.299, 1.346, 1.407, 1.471, 1.539, 1.598, 1.673, 1.752, 1.834,
    1.906, 1.995, 2.088, 2.185, 2.286, 2.373, 2.481, 2.593, 2.709, 2.808, 2.931, 3.058, 3.189,
    3.324, 3.440, 3.582, 3.729, 3.879, 4.008, 4.166, 4.328, 4.494,
]  # fmt: skip
REFERENCE = [(1.0, 0.125), (2.0, 0.155), (3.0, 0.188), (4.0, 0.216), (5.0, 0.254), (6.0, 0.303)]


@pytest.mark.parametrize(("amplitude", "conicity"), REFERENCE)
def test_reference_conicities_of_en_15302(amplitude, conicity):
    right = np.array(DIFFERENCE) * 1e-3
    lateral = 1e-4 * np.arange(-right.size + 1, right.size)
    difference = np.concatenate([-right[:0:-1], right])
    found = equivalent_conicity(lateral, difference, amplitude=amplitude * 1e-3)
    # The standard accepts 0.05; its tabulated values have three decimals.
    assert found == pytest.approx(conicity, abs=0.001)


def test_s1002_on_60e1_has_the_conicity_known_for_new_profiles():
    geometry = ContactGeometry(
        load_profile("wheel", "S1002"),
        load_profile("rail", "60E1"),
        RailPlacement(rolling_circle_distance=1.5),
        reference_penetration=1e-6,
        spacing=2e-5,
    )
    lateral = np.linspace(-4e-3, 4e-3, 33)
    table = contact_table(geometry, lateral)
    conicity = equivalent_conicity(lateral, table.rolling_radius_difference, amplitude=3e-3)
    # 0.17 to 0.18 is the usual statement for gauge 1435, inclination 1:40, 1360 mm between wheels.
    assert conicity == pytest.approx(0.175, abs=0.01)
