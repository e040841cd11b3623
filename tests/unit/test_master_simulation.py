"""Runs that end early keep their records; recorder; interrupts."""

import os
import signal

import master_mocks as mocks
import numpy as np
import pytest
from rail_cosim.algorithms import GaussSeidel
from rail_cosim.errors import DivergenceError, ParameterError, SlaveError
from rail_cosim.initialisation import initialise
from rail_cosim.interrupts import InterruptNote
from rail_cosim.pace import step_count
from rail_cosim.recorder import Recorder
from rail_cosim.simulation import Simulation
from rail_cosim.slave import Status
from rail_cosim.system import SystemStructure

STEP = 1e-4


def simulation(track=None, vehicle=None, every=1):
    system = SystemStructure([track or mocks.MockTrack(), vehicle or mocks.MockVehicle()])
    times = GaussSeidel().input_times(["track", "vehicle"])
    initialise(system, parameters={}, input_times=times, stop_time=1.0)
    recorder = Recorder(system.ports, every=every)
    return Simulation(system, GaussSeidel(), recorder, step_size=STEP), recorder


def test_a_complete_run():
    run, recorder = simulation()
    seen = []
    outcome = run.run(450, progress=lambda done, planned: seen.append((done, planned)))
    assert outcome.complete
    assert outcome.steps == 450
    assert outcome.simulated == pytest.approx(0.045)
    assert outcome.real_time_factor == pytest.approx(0.045 / outcome.wall)
    assert seen == [(200, 450), (400, 450), (450, 450)]
    assert recorder.times == pytest.approx(np.arange(451) * STEP, abs=1e-15)


def test_inputs_are_driven_before_each_step_at_its_start():
    calls = []

    class Noting:
        def apply(self, time, step_size):
            calls.append(("driver", time, step_size))

    system = SystemStructure([mocks.MockTrack(calls=calls), mocks.MockVehicle()])
    times = GaussSeidel().input_times(["track", "vehicle"])
    initialise(system, parameters={}, input_times=times, stop_time=1.0)
    recorder = Recorder(system.ports)
    run = Simulation(system, GaussSeidel(), recorder, step_size=STEP, driver=Noting())
    assert run.run(3).complete
    told = [call for call in calls if call[0] == "driver" or call[1] == "do_step"]
    assert told == [
        call
        for step in range(3)
        for call in (("driver", step * STEP, STEP), ("track", "do_step", step * STEP, STEP))
    ]


@pytest.mark.parametrize("status", [Status.DISCARD, Status.ERROR, Status.FATAL, Status.PENDING])
def test_a_slave_that_fails_at_a_step_ends_the_run_and_the_records_before_are_kept(status):
    reference, whole = simulation()
    reference.run(300)
    run, recorder = simulation(track=mocks.MockTrack(fails_at=251, failure=status))
    outcome = run.run(1000)
    assert outcome.steps == 250
    assert not outcome.complete
    assert isinstance(outcome.error, SlaveError)
    expected = (
        f"track: fmi2DoStep failed at t = 0.025 s (status {status.name.lower()}): "
        "wheel 3 has left the rail"
    )
    assert str(outcome.error) == expected
    for slave in ("track", "vehicle"):
        kept = recorder.values(slave)[1]
        assert len(kept) == 251
        assert np.array_equal(kept, whole.values(slave)[1][:251])


def test_keyboard_interrupt_in_a_slave_ends_the_run_and_keeps_the_records():
    vehicle = mocks.MockVehicle(fails_at=31, failure=KeyboardInterrupt())
    run, recorder = simulation(vehicle=vehicle)
    outcome = run.run(1000)
    assert isinstance(outcome.error, KeyboardInterrupt)
    assert outcome.steps == 30
    assert len(recorder) == 31


class Interrupting(mocks.MockTrack):
    def advance(self, time, step_size):
        super().advance(time, step_size)
        if self.steps == 40:
            os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_waits_for_the_end_of_the_step_and_the_handler_is_put_back():
    before = signal.getsignal(signal.SIGINT)
    run, recorder = simulation(track=Interrupting())
    with InterruptNote() as note:
        outcome = run.run(1000, note=note)
    assert signal.getsignal(signal.SIGINT) is before
    assert isinstance(outcome.error, KeyboardInterrupt)
    assert outcome.steps == 40  # the step in which it came is whole
    assert len(recorder) == 41


class Exploding(mocks.MockTrack):
    def advance(self, time, step_size):
        super().advance(time, step_size)
        if self.steps > 150:
            self.data[mocks.F] = float("nan")


def test_a_value_that_is_not_finite_ends_the_run_and_is_named():
    run, recorder = simulation(track=Exploding())
    outcome = run.run(1000)
    assert isinstance(outcome.error, DivergenceError)
    assert outcome.steps == len(recorder) - 1 == 150  # in the step where it happens
    assert "track.wheelset[1].contact.vertical_force is no longer a finite" in str(outcome.error)
    assert "at t = 0.0151 s" in str(outcome.error)
    assert "smaller macro step" in str(outcome.error)


class Growing(mocks.MockTrack):
    def advance(self, time, step_size):
        super().advance(time, step_size)
        if self.steps > 20:
            self.data[mocks.F] = -1e30


def test_a_value_that_is_not_physical_ends_the_run_too():
    run, recorder = simulation(track=Growing())
    outcome = run.run(100)
    assert outcome.steps == len(recorder) - 1 == 20
    assert "vertical_force is -1e+30 at t = 0.0021 s" in str(outcome.error)


def test_every_third_record_is_the_same_as_in_the_whole_run():
    all_steps, whole = simulation()
    all_steps.run(100)
    some_steps, thinned = simulation(every=3)
    some_steps.run(100)
    assert thinned.times == pytest.approx(whole.times[::3], abs=0)
    for slave in ("track", "vehicle"):
        assert np.array_equal(thinned.values(slave)[1], whole.values(slave)[1][::3])


def test_thinned_recording_reads_only_what_is_coupled_in_between():
    track = mocks.MockTrack()
    run, _ = simulation(track=track, every=4)
    track.calls.clear()
    run.run(8)
    reads = [call[2] for call in track.calls if call[1] == "read"]
    assert reads == [1, 1, 1, 4, 1, 1, 1, 1, 4, 1]  # reals, and integers when recorded


def test_integers_are_recorded_beside_reals():
    run, recorder = simulation()
    run.run(100)
    names, values = recorder.values("track")
    assert names[-1] == "window.slide_count"
    assert values[:, -1].tolist() == [step // 10 for step in range(101)]


def test_records_go_on_over_the_edge_of_a_block():
    run, recorder = simulation()
    run.run(5000)
    names, values = recorder.values("vehicle")
    position = values[:, names.index("wheelset[1].longitudinal_position")]
    assert position == pytest.approx(mocks.SPEED * recorder.times, abs=1e-12)


def test_recording_every_zeroth_step_is_refused():
    with pytest.raises(ParameterError, match="--record-every = 0: must be at least 1"):
        Recorder([], every=0)


@pytest.mark.parametrize(
    ("distance", "speed", "step", "count"),
    [(1.0, 10.0, 0.03, 4), (3.0, 10.0, 0.1, 3), (0.3, 1.0, 0.1, 3), (1e-9, 50.0, 1e-4, 1)],
)
def test_steps_of_a_distance_reach_its_end_and_no_farther(distance, speed, step, count):
    assert step_count(distance, speed, step) == count
