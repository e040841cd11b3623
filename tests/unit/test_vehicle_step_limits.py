"""Communication steps of a coupled vehicle: stability of the discrete loop, and what is said."""

import dataclasses

import numpy as np
import pytest
from force_memory import ForceMemory
from rail_vehicle import ForceHistory, VehicleParameters
from rail_vehicle.step_limits import _STABLE, LARGEST_EXTRAPOLATION_ERROR, StepLimits

UNIT = (1.0,) * 6
PAPER = VehicleParameters()


def polynomial(forces, at_end):
    """Start, end and quadratic part of a force over a step, from the values newest first."""
    first, second, third = forces
    bow = 0.5 * (first - 2.0 * second + third)
    if at_end:
        return second, first, bow
    return first, 3.0 * first - 3.0 * second + third, bow


def move(position, velocity, force):
    """Integrate exactly over a step of 1 s a unit mass under a force that is a parabola."""
    start, end, bow = force
    position += velocity + start / 3.0 + end / 6.0 - bow / 12.0
    return position, velocity + 0.5 * (start + end) - bow / 6.0


def on_a_spring(state, at_end, product):
    """Make one step of a mass on the contact's spring; the spring extrapolates the motion."""
    z, v, z0, v0, *forces = state
    gap, slope = z0 - z + v, v - v0
    ahead = z + v + (3.0 * gap - slope) + (2.0 * gap - slope)
    new = -(product**2) * ahead
    used = (new, *forces[:2]) if at_end else forces
    return [*move(z, v, polynomial(used, at_end)), z, v, new, *forces[:2]]


def in_creep(state, at_end, product):
    """Make one step of a wheelset that spins and runs on, held by its slip."""
    w, w0, x, v, x0, v0, *forces = state
    spinning = (0.46**2 / 146.0) / (0.46**2 / 146.0 + 1.0 / 1881.0)
    gap, slope = x0 - x + v, v - v0
    ahead = v + 2.0 * (3.0 * gap - slope) + 3.0 * (2.0 * gap - slope)
    new = -product * (2.0 * w - w0 + ahead)
    used = (new, *forces[:2]) if at_end else forces
    force = np.array(polynomial(used, at_end))
    spun = move(0.0, w, spinning * force)[1]
    return [spun, w, *move(x, v, (1.0 - spinning) * force), x, v, new, *forces[:2]]


def largest_eigenvalue(step, size, at_end, product):
    matrix = np.array([step(unit, at_end, product) for unit in np.eye(size)]).T
    return np.max(np.abs(np.linalg.eigvals(matrix)))


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize(("step", "size", "which"), [(on_a_spring, 7, 0), (in_creep, 9, 1)])
def test_limits_are_those_of_the_discrete_loop(step, size, which, at_end):
    limit = _STABLE[at_end][which]
    assert largest_eigenvalue(step, size, at_end, 0.97 * limit) < 1.001
    assert largest_eigenvalue(step, size, at_end, 1.1 * limit) > 1.02


def with_wheelset(**changes):
    return dataclasses.replace(PAPER, wheelset=dataclasses.replace(PAPER.wheelset, **changes))


def test_limits_follow_from_mass_stiffness_and_speed():
    usual, heavy = StepLimits(PAPER, True), StepLimits(with_wheelset(mass=4 * 1881.0), True)
    stiffness = (heavy.contact_stiffness / usual.contact_stiffness) ** 0.5  # of the higher load
    assert heavy.accurate * stiffness == pytest.approx(2.0 * usual.accurate, rel=1e-9)
    slow = StepLimits(dataclasses.replace(PAPER, speed=10.0), False)
    slower = StepLimits(dataclasses.replace(PAPER, speed=5.0), False)
    assert slow.stable == pytest.approx(2.0 * slower.stable)
    assert slow.accurate == slow.stable  # creep, not the wheelset on its contact


def test_coarse_steps_are_named_with_limit_and_remedy():
    jacobi, seidel = StepLimits(PAPER, at_end=False), StepLimits(PAPER, at_end=True)
    assert 1.0e-4 < jacobi.accurate < 1.2e-4 < 2e-4 < seidel.accurate < 2.5e-4
    assert "1 ms is coarse" in seidel.warning(1e-3)
    assert "take at most 0.1 ms (error 1 %; stable to some 0.35 ms)" in jacobi.error(1e-3)
    assert "step_end" in jacobi.error(1e-3)


@pytest.mark.parametrize("at_end", [False, True])
def test_extrapolation_error_is_small_for_what_is_followed_and_large_for_what_turns(at_end):
    """One impact among smooth forces stays far from the limit."""
    found = {}
    smooth = np.sin(0.1 * np.arange(600))
    impact = smooth + np.where(np.abs(np.arange(600) - 300) < 3, 5.0, 0.0)
    for name, forces in {
        "smooth": smooth,
        "impact": impact,
        "turning": 0.2 * (-1.0) ** np.arange(600),
    }.items():
        memory, largest = ForceMemory(ForceHistory.begin(np.zeros((4, 6))), UNIT), 0.0
        for force in forces:
            memory.take(np.full(24, force), 1e-4, 1e-4, 2, at_end=at_end)
            largest = max(largest, memory.extrapolation_error)
        found[name] = largest
    assert found["smooth"] < 0.01
    assert found["impact"] < 0.5 * LARGEST_EXTRAPOLATION_ERROR
    assert found["turning"] > 0.9
