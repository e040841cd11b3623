"""Detection of the steady state: the measure, the step that fits, the stop rule in a run."""

import math

import master_mocks as mocks
import numpy as np
import pytest
from rail_cosim.algorithms.base import Forgetful
from rail_cosim.errors import ParameterError
from rail_cosim.recorder import Recorder
from rail_cosim.simulation import Simulation
from rail_cosim.steady import SteadyReport, SteadyState, fitted_step, relative_change
from rail_cosim.system import SystemStructure

PITCH, SPEED = 5.032, 300.0 / 3.6


def decaying(factor, periods=2, count=600):
    """Two signals that repeat, and a disturbance of the second that shrinks with each period."""
    phase = np.arange(periods * count) / count
    repeat = np.stack([np.sin(16 * np.pi * phase), np.cos(2 * np.pi * phase)], axis=1)
    repeat[:, 1] += factor ** np.floor(phase) * np.sin(2 * np.pi * phase)
    return 70e3 + 1e3 * repeat


def test_what_repeats_does_not_change():
    assert relative_change(decaying(1.0)) < 1e-12


def test_change_is_relative_to_the_fluctuation():
    """Of mean squares 1/2 and (1 + f^2)/2: the difference is (1 - f) sin in one of two signals."""
    factor = 0.9
    expected = math.sqrt((1 - factor) ** 2 / 2 / (1 / 2 + (1 + factor**2) / 2))
    assert relative_change(decaying(factor)) == pytest.approx(expected, rel=1e-9)


def test_a_constant_signal_is_steady_and_one_that_is_not_finite_never():
    assert relative_change(np.full((40, 2), 70e3)) == 0.0
    assert relative_change(np.full((40, 2), math.nan)) == math.inf


@pytest.mark.parametrize(("largest", "every"), [(1e-4, 1), (1e-4, 7), (1.0064e-4, 1)])
def test_a_pitch_is_a_whole_number_of_records(largest, every):
    step = fitted_step(PITCH, SPEED, largest, every)
    records = PITCH / SPEED / (step * every)
    assert records == pytest.approx(round(records), abs=1e-9)
    assert 0.95 * largest < step <= largest * (1 + 1e-9)


def test_a_step_that_fits_stays_as_it_is():
    assert fitted_step(PITCH, SPEED, PITCH / SPEED / 600) == PITCH / SPEED / 600


def test_too_few_records_in_a_pitch_are_refused():
    with pytest.raises(ParameterError, match=r"--macro-step = 0\.01: .* only 7 records"):
        fitted_step(PITCH, SPEED, 1e-2)


class Settling(mocks.MockVector):
    """Output that repeats every 50 steps but for a part that halves with each of them."""

    def read(self, count=None):
        step = self.slave.steps
        self.values[:] = 1.0 + math.sin(2 * math.pi * step / 50) + 0.5 ** (step / 50)


class Wheel(mocks.MockSlave):
    def vector(self, names, kind="real"):
        return Settling(self, names, kind) if names else mocks.MockVector(self, names, kind)


def settling(*, tolerance, spacing=True, output="wheelset[1].left.normal_force"):
    """Return a system whose motion repeats ever better, its recorder and its stop rule."""
    variables = [mocks.variable(output)]
    if spacing:
        variables += [
            mocks.variable("fastener.spacing", "parameter", "m", start=0.625),
            mocks.variable("fastener.count_per_slab", "parameter", kind="integer", start=8),
        ]
    taker = mocks.MockSlave("vehicle", [mocks.variable(output, "input")])
    system = SystemStructure([Wheel("track", variables), taker])
    recorder = Recorder(system.ports)
    rule = SteadyState(system, recorder, tolerance=tolerance, speed=50.0, step_size=2e-3)
    return system, recorder, rule


class Stepping(Forgetful):
    order = "mine"

    def input_times(self, names):
        return dict.fromkeys(names, "step_start")

    def step(self, ports, time, step_size):
        for port in ports:
            port.slave.do_step(time, step_size)
            port.outputs.read()


def run(system, recorder, rule, steps):
    return Simulation(system, Stepping(), recorder, step_size=2e-3, stop=rule).run(steps)


def expected_change(pitch):
    """Of the disturbance 2^-t, t in pitches, against sine and disturbance, in pitch ``pitch``."""
    t = pitch - 1 + np.arange(1, 51) / 50
    change = 0.5**t - 0.5 ** (t - 1)
    whole = np.sin(2 * np.pi * t) + 0.5**t
    return np.sqrt(np.mean(change**2) / np.mean((whole - whole.mean()) ** 2))


def test_the_run_ends_after_two_pitches_within_the_tolerance():
    tolerance = 0.01
    first = next(k for k in range(2, 40) if expected_change(k) <= tolerance)
    system, recorder, rule = settling(tolerance=tolerance)
    outcome = run(system, recorder, rule, 5000)
    assert outcome.complete
    assert outcome.steps == 50 * (first + 1)
    assert outcome.steady.steady
    assert outcome.steady.change == pytest.approx(expected_change(first + 1), rel=1e-9)


def test_a_run_that_is_too_short_says_that_it_is_not_steady():
    system, recorder, rule = settling(tolerance=1e-6)
    outcome = run(system, recorder, rule, 420)
    assert outcome.complete
    assert outcome.steps == 420
    expected = SteadyReport(
        tolerance=1e-6, change=pytest.approx(expected_change(8), rel=1e-9), steady=False
    )
    assert outcome.steady == expected


def test_a_run_of_less_than_two_pitches_has_no_change():
    system, recorder, rule = settling(tolerance=1e-6)
    assert run(system, recorder, rule, 99).steady.change == math.inf


def test_what_cannot_be_detected_is_refused():
    with pytest.raises(ParameterError, match=r"--until-steady.*no parameters fastener\.spacing"):
        settling(tolerance=1e-3, spacing=False)
    with pytest.raises(ParameterError, match="none of the outputs normal_force"):
        settling(tolerance=1e-3, output="window.start_position")


def test_latest_records_over_the_edge_of_a_block():
    system, recorder, rule = settling(tolerance=1e-9)
    run(system, recorder, rule, 5000)
    whole = recorder.values("track")[1]
    for count in (1, 900, 910, 4500, 6000):
        assert np.array_equal(recorder.latest("track", [0], count), whole[-count:])
