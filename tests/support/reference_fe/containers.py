"""Arrays that the compiled time stepping works on.

Axis names: family (symmetric, antisymmetric), slab, mode, seat, pad, contact, dof.
"""

from typing import NamedTuple

import numpy as np


class Scheme(NamedTuple):
    """Step in s and the constants of the generalised-alpha method (Chung and Hulbert, 1993)."""

    step: float
    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class TrackOperators(NamedTuple):
    """Constant operators of the step; the rail is the same in every family."""

    mass: np.ndarray  # (diagonal, dof)
    stiffness: np.ndarray  # (diagonal, dof)
    lower: np.ndarray  # (dof, 3): unit lower factor of the step matrix, by row
    inverse_diagonal: np.ndarray  # (dof,)
    pad_dofs: np.ndarray  # (pad,)
    pad_stiffness: float
    pad_damping: float
    pad_gain: float  # force of a pad per response of the step, N per unit acceleration
    pad_solver: np.ndarray  # (family, pad, pad)
    seat_shape: np.ndarray  # (family, seat, mode)
    slab_stiffness: np.ndarray  # (family, mode)
    slab_damping: np.ndarray  # (family, mode)
    slab_inverse: np.ndarray  # (family, mode)
    family_sign: np.ndarray  # (side, family)
    element_length: float
    shapes: np.ndarray  # (power, element dof)
    bending_stiffness: float
    shear_stiffness: float


class VehicleOperators(NamedTuple):
    """Matrices of `RollingStock` and the inverse of its step matrix."""

    inverse_mass: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    inverse: np.ndarray
    load: np.ndarray
    contact: np.ndarray
    multiplicity: float
    hertz_constant: float


class State(NamedTuple):
    """Everything that a step carries over, changed in place."""

    rail: np.ndarray  # (displacement/velocity/acceleration, family, dof)
    rail_force: np.ndarray  # (family, dof)
    slab: np.ndarray  # (displacement/velocity/acceleration, family, slab, mode)
    slab_force: np.ndarray  # (family, slab, mode)
    body: np.ndarray  # (displacement/velocity/acceleration, dof)
    force: np.ndarray  # (contact,)
    penetration: np.ndarray  # (contact,)


class Columns(NamedTuple):
    """Responses of the step to unit forces at the dofs of the elements under the wheels."""

    first: np.ndarray  # (wheelset,): first dof of the element
    rail: np.ndarray  # (wheelset, 4, dof): rail alone
    at_pads: np.ndarray  # (4 * wheelset, pad)
    pad_force: np.ndarray  # (family, 4 * wheelset, pad)
    compliance: np.ndarray  # (family, 4 * wheelset, 4 * wheelset): with pads and slabs


class Record(NamedTuple):
    """What a run keeps, one row per instant."""

    force: np.ndarray  # (time, contact)
    deflection: np.ndarray  # (time, contact)
    body: np.ndarray  # (time, dof)
    body_acceleration: np.ndarray  # (time, dof)
    power: np.ndarray  # (time, 2): dissipated, driving


class Workspace(NamedTuple):
    """Intermediate values of one step, kept to save allocation."""

    right: np.ndarray  # (family, dof): known right-hand side of the rail
    free: np.ndarray  # (family, dof): rail acceleration without new interface forces
    blend: np.ndarray  # (dof,)
    slab_right: np.ndarray  # (family, slab, mode)
    pad_force: np.ndarray  # (family, pad)
    nodal: np.ndarray  # (family, dof): interface forces on the rail


class Footing(NamedTuple):
    """Rail shapes under each wheelset."""

    weights: np.ndarray  # (wheelset, 4)
    slopes: np.ndarray  # (wheelset, 4), 1/m
    local: np.ndarray  # (wheelset,): local compliance, m/N
    local_slope: np.ndarray  # (wheelset,), 1/N
