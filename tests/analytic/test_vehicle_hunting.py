"""Stability on a straight track with linear creep: the lateral suspension as a whole.

Each wheelset runs on conical wheels with Kalker's linear creep forces (no spin
creep, no flange), the textbook model of hunting, e.g. A. Wickens, Fundamentals
of Rail Vehicle Dynamics, 2003, chapter 2.
"""

import numpy as np
from rail_vehicle import PAPER, VehicleModel
from rail_vehicle.coordinates import FREE, WHEELSET_COORDINATES

HALF_CONTACT_SPACING = 0.7465
CREEP_COEFFICIENT = 1.0e7  # N per wheel, both directions


def largest_growth(parameters, speed, conicity):
    """Largest real part of the eigenvalues in 1/s, wheelsets held in z, roll and x."""
    model = VehicleModel(parameters.replace(speed=speed))
    system, radius = model.linear_system(), parameters.wheelset.radius
    stiffness, damping = system.stiffness.copy(), system.damping.copy()
    f, b = CREEP_COEFFICIENT, HALF_CONTACT_SPACING
    for lateral, yaw in WHEELSET_COORDINATES[:, [1, 5]]:
        # Lateral: f (y'/V - yaw) on two wheels; yaw: f b (b yaw'/V + conicity y / r) likewise.
        damping[lateral, lateral] += 2.0 * f / speed
        stiffness[lateral, yaw] -= 2.0 * f
        damping[yaw, yaw] += 2.0 * f * b**2 / speed
        stiffness[yaw, lateral] += 2.0 * f * b * conicity / radius
    lateral_damper = system.element_matrix[:, 4:6]
    damping += parameters.lateral_damper.damping * lateral_damper @ lateral_damper.T
    held = WHEELSET_COORDINATES[:, [0, 2, 3]].ravel()
    loose = np.setdiff1d(FREE, held)
    return np.linalg.eigvals(_first_order(parameters, system, stiffness, damping, loose)).real.max()


def _first_order(parameters, system, stiffness, damping, loose):
    count, pick = loose.size, np.ix_(loose, loose)
    inverse = 1.0 / np.diag(system.mass)[loose]
    yaw_damper, rows = parameters.yaw_damper, system.element_matrix[loose, :4]
    matrix = np.zeros((2 * count + 4, 2 * count + 4))
    matrix[:count, count : 2 * count] = np.eye(count)
    matrix[count : 2 * count, :count] = -inverse[:, None] * stiffness[pick]
    matrix[count : 2 * count, count : 2 * count] = -inverse[:, None] * damping[pick]
    if yaw_damper.damping > 0.0:
        spring = yaw_damper.series_stiffness
        matrix[count : 2 * count, 2 * count :] = inverse[:, None] * rows
        matrix[2 * count :, count : 2 * count] = -spring * rows.T
        matrix[2 * count :, 2 * count :] = -np.eye(4) * spring / yaw_damper.damping
    return matrix


def critical_speed(parameters, conicity):
    """Lowest speed in km/h at which a motion grows, in steps of 10 km/h; inf beyond 900."""
    for kmh in range(40, 901, 10):
        if largest_growth(parameters, kmh / 3.6, conicity) > 1e-6:
            return float(kmh)
    return np.inf


WITHOUT_YAW_DAMPERS = PAPER.replace(yaw_damper=PAPER.yaw_damper.replace(damping=0.0))


def test_stable_at_400_kmh_with_worn_wheels():
    assert largest_growth(PAPER, 400 / 3.6, 0.10) < 0.0


def test_hunts_above_a_critical_speed():
    critical = critical_speed(PAPER, 0.3)
    assert 300.0 < critical < 900.0


def test_yaw_dampers_raise_the_critical_speed():
    assert critical_speed(WITHOUT_YAW_DAMPERS, 0.15) < critical_speed(PAPER, 0.15) - 50.0
