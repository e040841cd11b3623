"""The run itself: step, observe, and keep what there is when it ends early."""

from __future__ import annotations

import dataclasses
import time as clock
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rail_cosim.algorithms import Algorithm
from rail_cosim.energy import EnergyReport, InterfaceEnergy
from rail_cosim.errors import DivergenceError, RailCosimError
from rail_cosim.fmu import FmuSlave
from rail_cosim.interrupts import InterruptNote
from rail_cosim.march import LARGEST_VALUE, LONGEST, March
from rail_cosim.recorder import Recorder
from rail_cosim.steady import SteadyReport
from rail_cosim.system import SystemStructure

Progress = Callable[[int, int], None]


class StopRule(Protocol):
    """Ends a run before all its steps are done.

    Attributes
    ----------
    next_step
        The number of steps after which it wants to be asked next; grows with each asking.
    """

    next_step: int

    def memory(self) -> dict[str, NDArray]:
        """Return what it remembers."""
        ...

    def recall(self, memory: Mapping[str, NDArray]) -> None:
        """Take back what :meth:`memory` returned."""
        ...

    @property
    def report(self) -> SteadyReport:
        """What it found."""
        ...

    def check(self) -> bool:
        """Whether to stop now."""
        ...


class Driver(Protocol):
    """Sets inputs that no slave feeds."""

    def apply(self, time: float, step_size: float) -> None:
        """Set them for the step from ``time`` by ``step_size`` seconds."""
        ...


class Observer(Protocol):
    """Looks at the slaves at the start and after every step."""

    def observe(self, time: float) -> None:
        """Look at the slaves as they are at ``time`` (s)."""
        ...


class Watch(Protocol):
    """Is told between two steps, every so often, that the run goes on."""

    def offer(self, simulation: Simulation) -> None:
        """Do what is due; the slaves may be asked for their states, and nothing else."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    steps, planned
        Macro steps done, and asked for at most.
    step_size
        Macro step in s.
    error
        What ended it early, ``None`` for nothing; ``KeyboardInterrupt`` for the user.
    wall, cpu
        Time spent stepping, in s.
    begun
        Steps that were done before: those of a run that is continued.
    energy
        The interface's energy residual.
    steady
        What the stop rule found, ``None`` without one.
    """

    steps: int
    planned: int
    step_size: float
    error: RailCosimError | KeyboardInterrupt | None
    wall: float
    cpu: float
    begun: int
    energy: EnergyReport
    steady: SteadyReport | None = None

    @property
    def complete(self) -> bool:
        """Whether it was not ended by an error."""
        return self.error is None

    @property
    def simulated(self) -> float:
        """Simulated time in s."""
        return self.steps * self.step_size

    @property
    def real_time_factor(self) -> float:
        """Simulated over wall-clock seconds."""
        done = (self.steps - self.begun) * self.step_size
        return done / self.wall if self.wall > 0.0 else 0.0


class Simulation:
    """Steps an initialised system and feeds the observers.

    Parameters
    ----------
    system, algorithm, recorder
        What is stepped, how, and where it is recorded.
    step_size
        Macro step in s.
    driver
        Sets inputs of slaves before each step; ``None`` for nothing.
    stop
        Ends the run before all its steps are done; ``None`` for nothing.
    observer
        Looks at the slaves after every step; ``None`` for nothing.
    compiled
        Whether steps are made in compiled code where that can be (see
        :mod:`rail_cosim.march`); the numbers are the same.
    """

    def __init__(
        self,
        system: SystemStructure,
        algorithm: Algorithm,
        recorder: Recorder,
        *,
        step_size: float,
        driver: Driver | None = None,
        stop: StopRule | None = None,
        observer: Observer | None = None,
        compiled: bool = True,
    ) -> None:
        self._system, self._algorithm, self.recorder = system, algorithm, recorder
        self._step_size, self._driver, self._stop = step_size, driver, stop
        self._observer = observer
        times = algorithm.input_times([slave.name for slave in system.slaves])
        self._energy = InterfaceEnergy(system, times, step_size)
        alone = driver is None and observer is None
        self._march = self._compiled() if compiled and alone else None
        self._done = 0
        self._exchanged = [(port, port.outputs.values[: port.coupled]) for port in system.ports]

    def _compiled(self) -> March | None:
        order = self._algorithm.order
        # Compiled steps hand the FMUs' numbers on as they are.
        fmus = all(
            isinstance(slave, FmuSlave) and not slave.scales for slave in self._system.slaves
        )
        if not fmus or order not in ("sequential", "simultaneous"):
            return None
        return March(
            self._system,
            sequential=order == "sequential",
            recorder=self.recorder,
            watched=self._energy.places,
        )

    def run(
        self,
        steps: int,
        *,
        note: InterruptNote | None = None,
        progress: Progress = lambda done, planned: None,
        watch: Watch | None = None,
    ) -> Outcome:
        """Go on until ``steps`` macro steps are done in all, or as many as can be done.

        Never raises for what happens in a step: a slave's error, a value that
        is no longer finite and Ctrl-C are in the outcome, so that the records
        can be written first.
        """
        note = note or InterruptNote()
        error: RailCosimError | KeyboardInterrupt | None = None
        stop, begun = self._stop, self._done
        wall, cpu = clock.perf_counter(), clock.process_time()
        try:
            if self._done == 0 and len(self.recorder) == 0:
                self.recorder.record(0.0)
                if self._observer is not None:
                    self._observer.observe(0.0)
            while self._done < steps:
                until = min(steps, self._done + LONGEST, stop.next_step if stop else steps)
                self._block(until - self._done, note)
                progress(self._done, steps)
                if stop and self._done == stop.next_step and stop.check():
                    break
                if watch is not None:
                    watch.offer(self)
        except (RailCosimError, KeyboardInterrupt) as caught:
            error = caught
        return Outcome(
            steps=self._done,
            planned=steps,
            step_size=self._step_size,
            error=error,
            wall=clock.perf_counter() - wall,
            cpu=clock.process_time() - cpu,
            begun=begun,
            energy=self._energy.report(),
            steady=stop.report if stop else None,
        )

    def memory(self) -> dict[str, NDArray]:
        """Return all that the coming steps depend on, but for the slaves' own states.

        Arrays by name; between two steps only.
        """
        own: dict[str, NDArray] = {"done": np.array(self._done)}
        for port in self._system.ports:
            own[f"{port.slave.name}.outputs"] = port.outputs.values.copy()
            own[f"{port.slave.name}.counters"] = port.counters.values.copy()
        parts = {"energy": self._energy, "algorithm": self._algorithm, "stop": self._stop}
        for name, part in parts.items():
            if part is not None:
                own |= {f"{name}.{key}": value for key, value in part.memory().items()}
        return own

    def recall(self, memory: Mapping[str, NDArray]) -> None:
        """Take back what :meth:`memory` returned."""
        self._done = int(memory["done"])
        for port in self._system.ports:
            port.outputs.values[:] = memory[f"{port.slave.name}.outputs"]
            port.counters.values[:] = memory[f"{port.slave.name}.counters"]
        parts = {"energy": self._energy, "algorithm": self._algorithm, "stop": self._stop}
        for name, part in parts.items():
            if part is not None:
                prefix = f"{name}."
                part.recall(
                    {
                        key.removeprefix(prefix): value
                        for key, value in memory.items()
                        if key.startswith(prefix)
                    }
                )

    def _block(self, count: int, note: InterruptNote) -> None:
        if self._march is None:
            self._one_by_one(count, note)
            return
        note.check()
        try:
            self._march.run(self._done, count, self._step_size)
        finally:
            self._done, seen = self._march.finished
            self._energy.take_in(seen)
        self._check_exchanged((self._done + 1) * self._step_size)  # where the march stopped

    def _one_by_one(self, count: int, note: InterruptNote) -> None:
        ports, step_size = self._system.ports, self._step_size
        recorder, algorithm, energy = self.recorder, self._algorithm, self._energy
        observer = self._observer
        for step in range(self._done + 1, self._done + count + 1):
            note.check()
            due = recorder.due(step)
            for port in ports:
                port.recorded = due
            if self._driver is not None:
                self._driver.apply((step - 1) * step_size, step_size)
            algorithm.step(ports, (step - 1) * step_size, step_size)
            self._check_exchanged(step * step_size)
            energy.observe()
            if due:
                recorder.record(step * step_size)
            self._done = step
            if observer is not None:
                observer.observe(step * step_size)

    def _check_exchanged(self, time: float) -> None:
        """Refuse a connected output that is no physical value, before any other slave sees more."""
        for port, exchanged in self._exchanged:
            if exchanged.dot(exchanged) < LARGEST_VALUE**2:  # false for what is not a number, too
                continue
            sound = np.abs(exchanged) < LARGEST_VALUE
            if sound.all():
                continue
            place = int(np.argmin(sound))
            value = float(exchanged[place])
            what = f"is {value:g}" if np.isfinite(value) else "is no longer a finite number"
            raise DivergenceError(
                f"{port.slave.name}.{port.outputs.names[place]} {what} at t = {time:.6g} s; the "
                "coupling has diverged: take a smaller macro step, or see what this FMU does "
                "at that time"
            )
