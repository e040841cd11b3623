"""Exact propagation of the linear part over a step, operators kept per step size.

Over a step of length h the contact forces are a quadratic in ``s = t/h``,

``u = u0 + (u1 - u0) s + c s (s - 1)``,

the internal forces are linear, and the frame's acceleration is constant. Then
``x(h)`` is linear in all of them, with matrices from one matrix exponential of
the system extended by a chain of integrators.
"""

from collections import OrderedDict

import numpy as np
from scipy.linalg import expm

from rail_vehicle.kernels import Operators
from rail_vehicle.linear_system import FirstOrderSystem
from rail_vehicle.multibody import Array


def make_operators(system: FirstOrderSystem, step: float) -> Operators:
    """Compute the operators of one step size in s."""
    inputs = np.column_stack([system.force_input, system.acceleration_input, system.internal_input])
    states, count = inputs.shape
    size = states + 3 * count
    chain = np.zeros((size, size))
    chain[:states, :states] = system.dynamics * step
    chain[:states, states : states + count] = inputs * step
    for level in (0, 1):
        start = states + level * count
        chain[start : start + count, start + count : start + 2 * count] = np.eye(count)
    propagated = np.asarray(expm(chain)[:states], dtype=np.float64)
    # Integrals of exp(A (h-t)) B against 1, s and s^2/2.
    constant, ramp, parabola = np.split(propagated[:, states:], 3, axis=1)
    forces = slice(0, system.force_input.shape[1])
    internal = slice(forces.stop + 1, count)
    from_start, from_end, bow = constant - ramp, ramp, 2.0 * parabola - ramp
    known = np.column_stack(
        [
            propagated[:, :states],
            from_start[:, forces],
            from_end[:, forces],
            bow[:, forces],
            constant[:, forces.stop],
            from_start[:, internal],
        ]
    )
    return Operators(
        known=np.ascontiguousarray(known.T),
        internal=np.ascontiguousarray(from_end[:, internal].T),
        signals=np.ascontiguousarray(system.signals.T),
        feedback=np.ascontiguousarray((system.signals @ from_end[:, internal]).T),
    )


class OperatorCache:
    """Operators of the step sizes used last; a step size is told by nine digits.

    Nine digits absorb the rounding of communication times; the change they
    make to a step is below what the forces' interpolation leaves.
    """

    def __init__(self, system: FirstOrderSystem, capacity: int = 8) -> None:
        self._system = system
        self._capacity = capacity
        self._kept: OrderedDict[float, Operators] = OrderedDict()
        self._last: tuple[float, Operators | None] = 0.0, None

    def __getitem__(self, step: float) -> Operators:
        """Return the operators of a step size in s, computed if need be."""
        last_step, last = self._last
        if last is not None and step == last_step:
            return last
        key = float(f"{step:.8e}")
        operators = self._kept.get(key)
        if operators is None:
            operators = make_operators(self._system, key)
            self._kept[key] = operators
            if len(self._kept) > self._capacity:
                self._kept.popitem(last=False)
        else:
            self._kept.move_to_end(key)
        self._last = step, operators
        return operators


def contraction(operators: Operators, slopes: Array) -> float:
    """Bound on the convergence factor of the fixed-point iteration of a step.

    ``slopes`` are the largest slopes of the element forces over elongation (8)
    and over its rate (8).
    """
    return float(np.max(np.abs(np.linalg.eigvals(element_gains(operators, slopes)))))


def element_gains(operators: Operators, slopes: Array) -> Array:
    """Largest change of each element's force for one newton of each other's, shape (8, 8)."""
    count = slopes.size // 2
    feedback = np.abs(operators.feedback.T)
    by_elongation = slopes[:count, None] * feedback[:count, :count]
    by_rate = slopes[count:, None] * feedback[count : 2 * count, :count]
    return by_elongation + by_rate
