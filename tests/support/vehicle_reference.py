"""Reference solution of the vehicle's equations by an adaptive Runge-Kutta method.

The equations are those of ``rail_vehicle.equations``, in continuous time.
"""

from collections.abc import Callable

import numpy as np
from rail_vehicle import VehicleModel, VehicleState
from rail_vehicle.coordinates import COORDINATE_COUNT, FREE
from rail_vehicle.equations import VehicleEquations
from scipy.integrate import solve_ivp


def dashpot_rate(force, damping, limit, after):
    """Velocity of a blow-off dashpot under a force; without damping there is no force."""
    if damping == 0.0:
        return np.zeros_like(force)
    linear = np.clip(force, -limit, limit)
    return linear / damping + (force - linear) / after


def solve(
    model: VehicleModel,
    state: VehicleState,
    forces: Callable[[float], np.ndarray],
    duration: float,
    acceleration: float = 0.0,
    tolerance: float = 1e-11,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return coordinates (50,), rates (50,) and yaw damper forces (4,) at the end."""
    p = model.parameters
    equations, yaw = VehicleEquations(p), p.yaw_damper
    moving = np.ones(COORDINATE_COUNT)
    moving[0] = 0.0
    # Damper forces as elongations of their springs: one tolerance then fits all of the state.
    force_unit = yaw.series_stiffness

    def rates(time: float, x: np.ndarray) -> np.ndarray:
        q, v, damper = np.split(x, [COORDINATE_COUNT, 2 * COORDINATE_COUNT])
        damper = damper * force_unit
        total = equations.outside(forces(time) - equations.static_forces, acceleration)
        total += equations.internal(q, v, damper)[0] - equations.C @ v - equations.K @ q
        dashpot = dashpot_rate(damper, yaw.damping, yaw.blow_off_force, yaw.blow_off_damping)
        damper_rate = yaw.series_stiffness * ((equations.N @ v)[:4] - dashpot)
        damper_rate *= yaw.damping > 0.0
        return np.concatenate([v, moving * total / equations.M, damper_rate / force_unit])

    start = np.concatenate([state.coordinates, state.rates, state.yaw_damper_forces / force_unit])
    solution = solve_ivp(
        rates,
        (0.0, duration),
        start,
        method="DOP853",
        rtol=tolerance,
        atol=tolerance * 1e-3,
        max_step=1e-3,
    )
    q, v, damper = np.split(solution.y[:, -1], [COORDINATE_COUNT, 2 * COORDINATE_COUNT])
    return q, v, damper * force_unit


def state_with(
    model: VehicleModel,
    coordinates: np.ndarray | None = None,
    rates: np.ndarray | None = None,
    speed: float | None = None,
) -> VehicleState:
    """Return a state with given coordinates and rates (50,), the wheelsets rolling."""
    vector = model.initial_state(speed=speed).vector.copy()
    if coordinates is not None:
        vector[: FREE.size] = coordinates[FREE]
    if rates is not None:
        vector[FREE.size : 2 * FREE.size] = rates[FREE]
    return VehicleState.of_vector(vector)


def mirror() -> np.ndarray:
    """Matrix (50, 50) that exchanges left and right."""
    matrix = np.zeros((COORDINATE_COUNT, COORDINATE_COUNT))
    for body in range(7):
        for direction, sign in enumerate((1.0, -1.0, 1.0, -1.0, 1.0, -1.0)):
            matrix[6 * body + direction, 6 * body + direction] = sign
    for box in range(8):
        matrix[42 + box, 42 + (box ^ 1)] = 1.0
    return matrix
