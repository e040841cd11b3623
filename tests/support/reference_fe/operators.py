"""Constant operators of the time step, made once per run."""

import numpy as np
import scipy.linalg

from .beam import HALF_BANDWIDTH, shape_coefficients
from .containers import Columns, Scheme, TrackOperators, VehicleOperators
from .kernel import solve_factored
from .line import Line
from .rolling_stock import RollingStock

FAMILY_SIGN = np.array([[1.0, 1.0], [1.0, -1.0]])
"""Motion of a side (row) = sum over families (column) of sign times the family's motion."""


def make_scheme(step: float, spectral_radius: float) -> Scheme:
    """Constants of the generalised-alpha method."""
    alpha_m = (2 * spectral_radius - 1) / (spectral_radius + 1)
    alpha_f = spectral_radius / (spectral_radius + 1)
    return Scheme(
        step=step,
        alpha_m=alpha_m,
        alpha_f=alpha_f,
        beta=0.25 * (1 - alpha_m + alpha_f) ** 2,
        gamma=0.5 - alpha_m + alpha_f,
    )


def track_operators(lines: list[Line], scheme: Scheme) -> TrackOperators:
    """Factor the rail's step matrix and eliminate the slabs down to the pads."""
    line, track = lines[0], lines[0].track
    bu, gu = scheme.beta * scheme.step**2, scheme.gamma * scheme.step
    old, new = 1 - scheme.alpha_m, 1 - scheme.alpha_f
    step_matrix = old * line.rail_mass + new * bu * line.rail_stiffness
    lower, inverse_diagonal = _factor(step_matrix)
    pads = line.pad_dofs
    rail_at_pads = np.zeros((len(pads), len(pads)))
    for p, dof in enumerate(pads):
        column = np.zeros(line.rail_dofs)
        column[dof] = 1.0
        solve_factored(lower, inverse_diagonal, column)
        rail_at_pads[p] = column[pads]
    pad_gain = new * (track.pad_stiffness * bu + track.pad_damping * gu)
    inverses, solvers = [], []
    for half in lines:
        slab = half.slab
        inverse = 1 / (old + new * (gu * slab.damping + bu * slab.stiffness))
        seats = slab.seat_shape * inverse @ slab.seat_shape.T
        total = rail_at_pads + np.kron(np.eye(half.slab_count), seats)
        solvers.append(np.linalg.inv(np.eye(len(pads)) + pad_gain * total))
        inverses.append(inverse)
    return TrackOperators(
        mass=line.rail_mass,
        stiffness=line.rail_stiffness,
        lower=lower,
        inverse_diagonal=inverse_diagonal,
        pad_dofs=pads,
        pad_stiffness=track.pad_stiffness,
        pad_damping=track.pad_damping,
        pad_gain=pad_gain,
        pad_solver=np.array(solvers),
        seat_shape=np.array([half.slab.seat_shape for half in lines]),
        slab_stiffness=np.array([half.slab.stiffness for half in lines]),
        slab_damping=np.array([half.slab.damping for half in lines]),
        slab_inverse=np.array(inverses),
        family_sign=FAMILY_SIGN[: len(lines), : len(lines)].copy(),
        element_length=line.element_length,
        shapes=shape_coefficients(line.section, line.element_length),
        bending_stiffness=line.section.bending_stiffness,
        shear_stiffness=line.section.shear_stiffness,
    )


def _factor(diagonals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factor a banded matrix: unit lower factor by rows (dof, 3) and inverse diagonal."""
    size = diagonals.shape[1]
    cholesky = scipy.linalg.cholesky_banded(diagonals[HALF_BANDWIDTH:], lower=True)
    lower = np.zeros((size, HALF_BANDWIDTH))
    for d in range(1, HALF_BANDWIDTH + 1):
        lower[d:, d - 1] = cholesky[d, :-d] / cholesky[0, :-d]
    return lower, cholesky[0] ** -2


def vehicle_operators(stock: RollingStock, scheme: Scheme) -> VehicleOperators:
    """Invert the step matrix of the vehicle."""
    new = 1 - scheme.alpha_f
    matrix = (1 - scheme.alpha_m) * stock.mass
    matrix = matrix + new * scheme.gamma * scheme.step * stock.damping
    matrix = matrix + new * scheme.beta * scheme.step**2 * stock.stiffness
    return VehicleOperators(
        inverse_mass=np.linalg.inv(stock.mass),
        mass=stock.mass,
        damping=np.ascontiguousarray(stock.damping),
        stiffness=np.ascontiguousarray(stock.stiffness),
        inverse=np.linalg.inv(matrix),
        load=stock.load,
        contact=np.ascontiguousarray(stock.contact),
        multiplicity=stock.multiplicity,
        hertz_constant=stock.hertz_constant,
    )


def empty_columns(lines: list[Line], wheels: int) -> Columns:
    """Columns of wheels that have not met an element yet."""
    pads = len(lines[0].pad_dofs)
    return Columns(
        first=np.zeros(wheels, dtype=np.int64),
        rail=np.zeros((wheels, 4, lines[0].rail_dofs)),
        at_pads=np.zeros((4 * wheels, pads)),
        pad_force=np.zeros((len(lines), 4 * wheels, pads)),
        compliance=np.zeros((len(lines), 4 * wheels, 4 * wheels)),
    )
