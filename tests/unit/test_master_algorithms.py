"""Algorithms on mock slaves: order of calls, order of accuracy, rollback, energy."""

import master_mocks as mocks
import numpy as np
import pytest
from rail_cosim.algorithms import GaussSeidel, IterativeGaussSeidel, Jacobi, make_algorithm
from rail_cosim.errors import DivergenceError, ParameterError
from rail_cosim.initialisation import initialise
from rail_cosim.recorder import Recorder
from rail_cosim.simulation import Simulation
from rail_cosim.system import SystemStructure

DURATION = 0.02


def coupled(algorithm, *, calls=None, timed=True, parameters=None):
    track = mocks.MockTrack(timed=timed, calls=calls)
    vehicle = mocks.MockVehicle(timed=timed, calls=calls)
    system = SystemStructure([track, vehicle])
    initialise(
        system,
        parameters=parameters or {},
        input_times=algorithm.input_times(["track", "vehicle"]),
        stop_time=DURATION,
    )
    return system


def simulate(algorithm, steps, **more):
    system = coupled(algorithm, **more)
    recorder = Recorder(system.ports)
    simulation = Simulation(system, algorithm, recorder, step_size=DURATION / steps)
    outcome = simulation.run(steps)
    assert outcome.complete, outcome.error
    names, values = recorder.values("track")
    return recorder.times, values[:, names.index(mocks.F)], outcome


def error(algorithm, steps, **more):
    """Root mean square of the contact force's difference."""
    times, force, _ = simulate(algorithm, steps, **more)
    return np.sqrt(np.mean((force - mocks.monolithic(times)[1]) ** 2))


@pytest.mark.parametrize(
    ("make", "timed", "expected"),
    [
        (GaussSeidel, True, 2.0),
        (Jacobi, True, 2.0),
        (IterativeGaussSeidel, True, 2.0),
        (GaussSeidel, False, 1.0),
        (Jacobi, False, 1.0),
    ],
)
def test_observed_order_against_the_monolithic_solution(make, timed, expected):
    errors = [error(make(), steps, timed=timed) for steps in (400, 800, 1600)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(expected, abs=0.03)


def test_gauss_seidel_is_more_exact_than_jacobi_and_iteration_than_both():
    assert error(GaussSeidel(), 400) < error(Jacobi(), 400)
    assert error(IterativeGaussSeidel(), 400) < error(GaussSeidel(), 400)


def one_step(algorithm):
    calls = []
    system = coupled(algorithm, calls=calls)
    for port in system.ports:
        port.recorded = False
    calls.clear()
    algorithm.step(system.ports, 0.0, 1e-4)
    kept = ("do_step", "write", "read", "save_state", "restore_state", "free_state")
    return [call[:2] for call in calls if call[1] in kept]


def test_gauss_seidel_steps_the_track_first_and_gives_its_new_forces_to_the_vehicle():
    assert one_step(GaussSeidel()) == [
        ("track", "write"),
        ("track", "do_step"),
        ("track", "read"),
        ("vehicle", "write"),
        ("vehicle", "do_step"),
        ("vehicle", "read"),
    ]


def test_jacobi_sets_all_inputs_before_any_step():
    assert one_step(Jacobi()) == [
        ("track", "write"),
        ("vehicle", "write"),
        ("track", "do_step"),
        ("track", "read"),
        ("vehicle", "do_step"),
        ("vehicle", "read"),
    ]


def test_iteration_goes_back_before_each_repetition_and_releases_the_states():
    done = [call for _, call in one_step(IterativeGaussSeidel())]
    passes = done.count("do_step") // 2
    assert done[:2] == ["save_state", "save_state"]
    assert passes >= 2
    assert done.count("restore_state") == 2 * (passes - 1)
    assert done[-2:] == ["free_state", "free_state"]


def test_input_time_is_what_the_algorithm_says():
    for algorithm, track, vehicle in (
        (GaussSeidel(), "step_start", "step_end"),
        (Jacobi(), "step_start", "step_start"),
        (IterativeGaussSeidel(), "step_end", "step_end"),
    ):
        system = coupled(algorithm)
        assert system["track"].data["coupling.input_time"] == track
        assert system["vehicle"].data["coupling.input_time"] == vehicle


def test_input_time_set_by_the_user_wins():
    given = {"vehicle": {"coupling.input_time": "step_start"}}
    system = coupled(GaussSeidel(), parameters=given)
    assert system["vehicle"].data["coupling.input_time"] == "step_start"


def test_iteration_reaches_its_fixed_point():
    loose, tight = IterativeGaussSeidel(tolerance=1e-9), IterativeGaussSeidel(tolerance=1e-13)
    _, first, _ = simulate(loose, 100)
    _, second, _ = simulate(tight, 100)
    assert first == pytest.approx(second, rel=0, abs=2e-7 * np.max(np.abs(second)))
    assert 2.0 <= loose.report()["passes_per_step"] < tight.report()["passes_per_step"] < 12.0


def test_iteration_that_does_not_converge_is_an_error_with_time_and_remedy():
    algorithm = IterativeGaussSeidel(tolerance=1e-15, limit=2)
    system = coupled(algorithm)
    recorder = Recorder(system.ports)
    outcome = Simulation(system, algorithm, recorder, step_size=1e-4).run(10)
    assert isinstance(outcome.error, DivergenceError)
    assert "t = 0 s does not converge: after 2 repetitions" in str(outcome.error)
    assert "smaller macro step" in str(outcome.error)


def test_energy_residual_falls_with_the_step_and_from_algorithm_to_algorithm():
    residuals = [simulate(GaussSeidel(), n)[2].energy.absolute_residual for n in (400, 800, 1600)]
    orders = np.log2(np.divide(residuals[:-1], residuals[1:]))
    assert np.all(orders > 2.5)
    energy = simulate(GaussSeidel(), 400)[2].energy
    assert 0.0 < abs(energy.residual) <= energy.absolute_residual < energy.exchanged
    iterated = simulate(IterativeGaussSeidel(), 400)[2].energy
    parallel = simulate(Jacobi(), 400)[2].energy
    assert 0.0 < iterated.share < energy.share < parallel.share


def test_energy_residual_of_slaves_that_hold_their_inputs_is_of_first_order():
    found = [simulate(GaussSeidel(), n, timed=False)[2].energy for n in (800, 1600)]
    order = np.log2(found[0].absolute_residual / found[1].absolute_residual)
    assert order == pytest.approx(1.0, abs=0.1)


def test_input_time_that_the_user_set_counts_for_the_energy_residual():
    given = {"vehicle": {"coupling.input_time": "step_start"}}
    usual = simulate(GaussSeidel(), 400)[2].energy
    other = simulate(GaussSeidel(), 400, parameters=given)[2].energy
    assert other.absolute_residual > 2.0 * usual.absolute_residual


def test_energy_exchanged_is_the_work_done_on_the_wheel():
    times, force, outcome = simulate(GaussSeidel(), 1600)
    wheel = mocks.monolithic(times)[0]
    # Every step's work counts by its magnitude.
    works = 0.5 * (force[1:] + force[:-1]) * np.diff(wheel)
    assert outcome.energy.exchanged == pytest.approx(np.sum(np.abs(works)), rel=1e-3)


def test_unknown_algorithm_is_refused_with_the_nearest():
    with pytest.raises(ParameterError, match="did you mean jacobi"):
        make_algorithm("jakobi")


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-9])
def test_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(ParameterError, match="greater than 0 and less than 1"):
        IterativeGaussSeidel(tolerance=tolerance)
