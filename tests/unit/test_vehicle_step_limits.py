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


N = np.arange(600)
FORCES = {
    "smooth": (np.sin(0.1 * N), False),
    "one impact": (np.where(np.abs(N - 300) < 3, 5.0, 0.0), False),
    "alternating": (0.2 * (-1.0) ** N, True),
    "a wave of 4 steps": (0.2 * np.sin(2.0 * np.pi * N / 4.05 + 0.2), True),
    "corrugation of 5 steps": (0.9 * np.sin(2.0 * np.pi * N / 5.0), False),
    "too small": (0.005 * (-1.0) ** N, False),
}


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("case", FORCES)
def test_forces_that_turn_from_step_to_step_are_noticed_and_no_others(case, at_end):
    forces, wanted = FORCES[case]
    memory, found = ForceMemory(ForceHistory.begin(np.zeros((4, 6))), UNIT), False
    for force in forces:
        memory.take(np.full(24, force), 1e-4, 1e-4, 2, at_end=at_end)
        found |= memory.alternates
    assert found == wanted


def test_extrapolation_errors_are_those_of_parabola_and_line():
    """A wave of n steps: third and second difference."""
    memory, n = ForceMemory(ForceHistory.begin(np.zeros((4, 6))), UNIT), 8
    phases = 2.0 * np.pi * np.arange(4) / 4  # of the wheelsets, so that their sum is steady
    for step in range(3000):
        force = np.repeat(0.1 * np.sin(2.0 * np.pi * step / n + phases), 6)
        memory.take(force, 1e-4, 1e-4, 2, at_end=True)
    amplitude, difference = 0.1 * np.sqrt(6.0 / 2.0), 2.0 * np.sin(np.pi / n)
    expected = amplitude * difference**3, amplitude * difference**2
    assert memory.extrapolation_errors == pytest.approx(expected, rel=1e-4)
    assert expected[0] < LARGEST_EXTRAPOLATION_ERROR
