"""Steps in compiled code give what steps in Python give, bit for bit."""

import contextlib
import ctypes

import numpy as np
import pytest
from rail_cosim import packed
from rail_cosim.algorithms import make_algorithm
from rail_cosim.errors import SlaveError
from rail_cosim.fmu import FmuSlave
from rail_cosim.initialisation import initialise
from rail_cosim.options import RunOptions
from rail_cosim.recorder import Recorder
from rail_cosim.runner import find_fmus, gather_parameters
from rail_cosim.simulation import Simulation
from rail_cosim.system import SystemStructure

STEP = 1e-4


@contextlib.contextmanager
def simulation(compiled, algorithm="gauss-seidel", every=1, **options):
    asked = RunOptions(speed=300, **options)
    descriptions, presets = find_fmus(asked)
    coupling = make_algorithm(algorithm)
    with contextlib.ExitStack() as stack:
        slaves = [
            stack.enter_context(FmuSlave(about.path, name, description=about))
            for name, about in descriptions.items()
        ]
        system = SystemStructure(slaves)
        initialise(
            system,
            parameters=gather_parameters(asked, descriptions, presets),
            input_times=coupling.input_times([slave.name for slave in slaves]),
            stop_time=10.0,
        )
        recorder = Recorder(system.ports, every=every)
        yield Simulation(system, coupling, recorder, step_size=STEP, compiled=compiled), system


def outcome_of(compiled, steps, **options):
    with simulation(compiled, **options) as (run, _):
        outcome = run.run(steps)
        return outcome, run.recorder.rows(0, len(run.recorder))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"algorithm": "jacobi"},
        {"every": 7, "irregularity": "german_low"},
        {"settings": ["track.wheelset_count=4", "track.contact.model=vertical"]},
    ],
)
def test_compiled_steps_are_the_same(options):
    steps = 707  # with slides, and no whole number of blocks
    fast, slow = outcome_of(True, steps, **options), outcome_of(False, steps, **options)
    assert fast[0].error is None
    assert fast[0].steps == slow[0].steps == steps
    assert len(fast[1]) == 1 + steps // options.get("every", 1)
    assert np.array_equal(fast[1], slow[1])
    assert fast[0].energy == slow[0].energy


def test_a_refused_step_ends_both_at_the_same_place():
    """The track's window is told to be where the vehicle is not: the position jumps."""
    found = []
    for compiled in (True, False):
        with simulation(compiled) as (run, system):
            run.run(333)
            vehicle = system.port("vehicle")
            place = vehicle.outputs.names.index("wheelset[1].longitudinal_position")
            vehicle.outputs.values[place] += 1e6
            outcome = run.run(1000)
            found.append((outcome, run.recorder.rows(0, len(run.recorder))))
    (fast, fast_rows), (slow, slow_rows) = found
    assert isinstance(fast.error, SlaveError)
    assert str(fast.error) == str(slow.error)
    assert fast.steps == slow.steps == 333
    assert np.array_equal(fast_rows, slow_rows)


def test_a_step_may_be_taken_in_compiled_code_after_one_in_python():
    with simulation(True) as (run, _):
        run.run(100)
        run._march, march = None, run._march
        run.run(150)
        run._march = march
        run.run(707)
        rows = run.recorder.rows(0, len(run.recorder))
    assert np.array_equal(rows, outcome_of(False, 707)[1])


def test_outputs_are_read_as_one_text_of_each():
    with simulation(True) as (run, system):
        run.run(10)
        numbers = [len(port.outputs.names) + len(port.counters.names) for port in system.ports]
        assert run._march.text_counts == numbers


class Untrue(FmuSlave):
    """An FMU whose text says something else than its variables."""

    def get(self, names):
        values = super().get(names)
        if packed.NAME in values:
            values[packed.NAME] = self.text(values[packed.NAME])
        return values


@pytest.mark.parametrize(
    "text", [lambda text: "", lambda text: "z" + text[1:], lambda text: "f" + text[1:]]
)
def test_a_text_that_is_not_the_outputs_is_not_used(monkeypatch, text):
    monkeypatch.setattr(Untrue, "text", staticmethod(text), raising=False)
    monkeypatch.setattr(f"{__name__}.FmuSlave", Untrue)
    with simulation(True) as (run, _):
        run.run(250)
        assert run._march.text_counts == [0, 0]
        rows = run.recorder.rows(0, len(run.recorder))
    assert np.array_equal(rows, outcome_of(False, 250)[1])


@pytest.mark.parametrize("length", [0, 1, 16, -1])
def test_a_text_that_is_too_short_ends_the_run(length):
    with simulation(True) as (run, _):
        whole = b"0" * 16 * run._march.text_counts[0]

        @ctypes.CFUNCTYPE(
            ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t,
            ctypes.POINTER(ctypes.c_char_p),
        )  # fmt: skip
        def given(_component, _references, _count, texts):
            texts[0] = whole[:length]
            return 0

        run._march._fmus[0].get_string = ctypes.cast(given, ctypes.c_void_p)
        outcome = run.run(10)
    assert isinstance(outcome.error, SlaveError)
    assert outcome.steps == 0
