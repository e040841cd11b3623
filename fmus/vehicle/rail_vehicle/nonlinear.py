"""Constants of the non-linear elements: two dampers with blow-off, and lateral stops.

Their laws are in :mod:`rail_vehicle.kernels`.
"""

import numpy as np
from numpy.typing import NDArray

from rail_vehicle.parameters import VehicleParameters

ELEMENT_COUNT = 8
"""Four yaw dampers, two lateral dampers, two lateral stops."""


def largest_slopes(parameters: VehicleParameters, stroke: float) -> NDArray[np.float64]:
    """Largest slopes of the eight forces over elongation (8) and over its rate (8).

    The stop's slope is that at the compression ``stroke`` in m.
    """
    yaw, lateral = parameters.yaw_damper, parameters.lateral_damper
    stop = parameters.lateral_bump_stop
    slopes = np.zeros(2 * ELEMENT_COUNT)
    if yaw.damping > 0.0:
        slopes[0:4] = yaw.series_stiffness
    slopes[6:8] = stop.stiffness + 3.0 * stop.cubic_stiffness * stroke**2
    slopes[12:14] = lateral.damping
    return slopes
