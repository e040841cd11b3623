"""The linear part of the vehicle as matrices, and as a first-order system."""

import dataclasses
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from rail_vehicle.arrangement import (
    Bodies,
    gyroscopic_matrix,
    linear_elements,
    make_bodies,
    mass_matrix,
    nonlinear_directions,
)
from rail_vehicle.coordinates import (
    BODY_COUNT,
    CAR_BODY,
    COORDINATE_COUNT,
    FREE,
    ROLL,
    WHEELSET_COORDINATES,
    YAW,
    X,
    coordinate,
)
from rail_vehicle.multibody import Array, damping_matrix, stiffness_matrix
from rail_vehicle.nonlinear import ELEMENT_COUNT
from rail_vehicle.parameters import VehicleParameters

FREE_COUNT = FREE.size
STATE_COUNT = 2 * FREE_COUNT
FORCE_COUNT = 24
INTERNAL_COUNT = ELEMENT_COUNT + 8
"""Forces found within the step: 8 elements, 4 roll and 4 yaw gyroscopic moments."""
SIGNAL_COUNT = 2 * ELEMENT_COUNT + 8
"""What they depend on: 8 elongations, 8 rates, 4 roll and 4 yaw rates."""


class LinearSystem(NamedTuple):
    """``M q'' + C q' + K q = B f + N n`` in all 50 coordinates.

    ``C`` contains the gyroscopic terms at the parameter ``speed``. ``B`` takes
    the 24 contact forces less the static ones, in the order of the array
    (4, 6); ``N`` takes the eight forces of the non-linear elements, with
    ``N.T @ q`` their elongations with the sign changed. The car body's x is to
    be held.

    Attributes
    ----------
    mass, damping, stiffness
        M, C and K, shape (50, 50), in SI units.
    input_matrix, element_matrix
        B, shape (50, 24), and N, shape (50, 8); levers in m.
    free
        Indices of the coordinates other than the car body's x and the spins, shape (45,).
    """

    mass: Array
    damping: Array
    stiffness: Array
    input_matrix: Array
    element_matrix: Array
    free: np.ndarray


@dataclasses.dataclass(frozen=True, kw_only=True)
class FirstOrderSystem:
    """``x' = A x + B u`` of the 45 free coordinates, ``x = (q, q')``.

    Attributes
    ----------
    dynamics
        A, shape (90, 90).
    force_input
        Columns of B for the 24 contact forces, shape (90, 24).
    acceleration_input
        Column for the acceleration of the moving frame, shape (90,).
    internal_input
        Columns for element forces and gyroscopic moments, shape (90, 16).
    signals
        Rows that give what the internal forces depend on, shape (24, 90).
    spin_inertia
        Inertia of a wheelset about its axle, kg m2.
    """

    dynamics: Array
    force_input: Array
    acceleration_input: Array
    internal_input: Array
    signals: Array
    spin_inertia: float


def assemble(parameters: VehicleParameters) -> tuple[LinearSystem, Bodies]:
    """Assemble the matrices of the 50 coordinates."""
    bodies = make_bodies(parameters)
    elements = linear_elements(parameters, bodies)
    spin = -parameters.speed / parameters.wheelset.radius
    input_matrix = np.zeros((COORDINATE_COUNT, FORCE_COUNT))
    input_matrix[WHEELSET_COORDINATES.ravel(), np.arange(FORCE_COUNT)] = 1.0
    system = LinearSystem(
        mass=mass_matrix(parameters),
        damping=damping_matrix(elements) + gyroscopic_matrix(parameters, spin),
        stiffness=stiffness_matrix(elements),
        input_matrix=input_matrix,
        element_matrix=-nonlinear_directions(parameters, bodies).T,
        free=FREE.copy(),
    )
    return system, bodies


def first_order(parameters: VehicleParameters, system: LinearSystem) -> FirstOrderSystem:
    """Reduce to the free coordinates and write as a first-order system."""
    inverse_mass = 1.0 / np.diag(system.mass)[FREE]
    pick = np.ix_(FREE, FREE)
    dynamics = np.zeros((STATE_COUNT, STATE_COUNT))
    dynamics[:FREE_COUNT, FREE_COUNT:] = np.eye(FREE_COUNT)
    dynamics[FREE_COUNT:, :FREE_COUNT] = -inverse_mass[:, None] * system.stiffness[pick]
    dynamics[FREE_COUNT:, FREE_COUNT:] = -inverse_mass[:, None] * system.damping[pick]

    def lower_half(columns: Array) -> Array:
        return np.vstack([np.zeros((FREE_COUNT, columns.shape[1])), columns])

    accelerated = [coordinate(body, X) for body in range(BODY_COUNT) if body != CAR_BODY]
    inertia = -np.isin(FREE, accelerated).astype(float)
    rolls, yaws = WHEELSET_COORDINATES[:, ROLL], WHEELSET_COORDINATES[:, YAW]
    moments = np.zeros((COORDINATE_COUNT, 8))
    moments[np.concatenate([rolls, yaws]), np.arange(8)] = 1.0
    internal = np.hstack([system.element_matrix, moments])[FREE]
    return FirstOrderSystem(
        dynamics=dynamics,
        force_input=lower_half(inverse_mass[:, None] * system.input_matrix[FREE]),
        acceleration_input=np.concatenate([np.zeros(FREE_COUNT), inertia]),
        internal_input=lower_half(inverse_mass[:, None] * internal),
        signals=_signals(system.element_matrix, [*map(int, rolls), *map(int, yaws)]),
        spin_inertia=parameters.wheelset.pitch_inertia,
    )


def _signals(element_matrix: Array, angles: Iterable[int]) -> Array:
    signals = np.zeros((SIGNAL_COUNT, STATE_COUNT))
    directions = -element_matrix.T[:, FREE]
    signals[:ELEMENT_COUNT, :FREE_COUNT] = directions
    signals[ELEMENT_COUNT : 2 * ELEMENT_COUNT, FREE_COUNT:] = directions
    for row, angle in enumerate(angles):
        column = FREE_COUNT + int(np.searchsorted(FREE, angle))
        signals[2 * ELEMENT_COUNT + row, column] = 1.0
    return signals
