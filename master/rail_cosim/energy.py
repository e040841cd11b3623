"""The energy that the coupling itself adds at the interface.

What the track gives a wheelset must be what the wheelset receives. It is not,
as long as one side works with extrapolated inputs: the track's power is its
contact force times the motion it *assumed*, the vehicle's power is the force
it *assumed* times its motion. The accumulated difference is a measure of the
coupling error that needs no reference solution.

The master sees values at communication points only. Between them a slave's
inputs are taken as it is told to understand them by ``coupling.input_time``
(linear extrapolation, or interpolation); a slave without that parameter holds
them constant. The work in a step follows from the trapezoidal rule. So the
figure is an estimate, of second order in the step as the coupling is.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rail_cosim.algorithms import STEP_END
from rail_cosim.exchange import Port
from rail_cosim.initialisation import INPUT_TIME
from rail_cosim.system import SystemStructure

CONJUGATES = {
    "longitudinal_force": "longitudinal_velocity",
    "lateral_force": "lateral_velocity",
    "vertical_force": "vertical_velocity",
    "roll_moment": "roll_rate",
    "pitch_moment": "pitch_rate",
    "yaw_moment": "yaw_rate",
}
_BLOCK = 1024
Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class EnergyReport:
    """Energies accumulated over a run, in J.

    Attributes
    ----------
    defect
        What the vehicle received less what the track gave.
    absolute_defect
        Sum of the steps' absolute defects.
    exchanged
        Sum of the steps' absolute works on the vehicle.
    """

    defect: float = 0.0
    absolute_defect: float = 0.0
    exchanged: float = 0.0

    @property
    def share(self) -> float:
        """The absolute defect as a share of the energy exchanged; 0 if none was."""
        return self.absolute_defect / self.exchanged if self.exchanged else 0.0


class InterfaceEnergy:
    """Observer that accumulates the energy defect between ``track`` and ``vehicle``.

    Parameters
    ----------
    system
        The coupled slaves, initialised.
    input_times
        What instant the inputs of each slave stand for.
    step_size
        Macro step in s.

    Attributes
    ----------
    places
        Where the forces, then the motions that belong to them, are on the system's board.
    """

    def __init__(
        self, system: SystemStructure, input_times: Mapping[str, str], step_size: float
    ) -> None:
        track, vehicle = system.port("track"), system.port("vehicle")
        forces, motions = _pairs(system)
        self._board, self._count = system.board, len(forces)
        of_track = [system.place_of("track", name) for name in forces]
        of_vehicle = [system.place_of("vehicle", name) for name in motions]
        self.places = np.array(of_track + of_vehicle, dtype=np.intp)
        self._assume_motion = _assumption(track, input_times)
        self._assume_force = _assumption(vehicle, input_times)
        self._step_size = step_size
        # Rows: two points of the block before, then the points of this one.
        self._forces = np.zeros((_BLOCK + 2, len(forces)))
        self._motions = np.zeros((_BLOCK + 2, len(motions)))
        self._report = EnergyReport()
        self._row = 0
        self.observe()
        self.observe()

    def take_in(self, rows: Array) -> None:
        """Take in the values of :attr:`places` at the ends of some steps, (steps, places)."""
        for row in rows:
            self._forces[self._row] = row[: self._count]
            self._motions[self._row] = row[self._count :]
            self._row += 1
            if self._row == _BLOCK + 2:
                self._report = self.report()
                self._forces[:2], self._motions[:2] = self._forces[-2:], self._motions[-2:]
                self._row = 2

    def observe(self) -> None:
        """Take in the values at the end of a step."""
        self.take_in(self._board[self.places][None])

    def report(self) -> EnergyReport:
        """Return what has been accumulated so far."""
        rows = self._row
        forces, motions = self._forces[:rows], self._motions[:rows]
        given = self._work(forces, self._assume_motion(motions))
        received = self._work(motions, self._assume_force(forces))
        defect = received - given
        return EnergyReport(
            defect=self._report.defect + float(defect.sum()),
            absolute_defect=self._report.absolute_defect + float(np.abs(defect).sum()),
            exchanged=self._report.exchanged + float(np.abs(received).sum()),
        )

    def memory(self) -> dict[str, Array]:
        """Return what it remembers, as arrays by name."""
        totals = dataclasses.astuple(self._report)
        return {
            "totals": np.array(totals),
            "forces": self._forces[: self._row].copy(),
            "motions": self._motions[: self._row].copy(),
        }

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Take back what :meth:`memory` returned."""
        defect, absolute, exchanged = (float(value) for value in memory["totals"])
        self._report = EnergyReport(defect=defect, absolute_defect=absolute, exchanged=exchanged)
        self._row = len(memory["forces"])
        self._forces[: self._row] = memory["forces"]
        self._motions[: self._row] = memory["motions"]

    def _work(self, own: Array, assumed: tuple[Array, Array]) -> Array:
        """Work in each step, shape (steps,), by the trapezoidal rule."""
        start, end = assumed
        sums = np.sum(start * own[1:-1] + end * own[2:], axis=1)
        return 0.5 * self._step_size * sums


def _pairs(system: SystemStructure) -> tuple[list[str], list[str]]:
    names = {(c.source, c.name) for c in system.connections}
    forces: list[str] = []
    motions: list[str] = []
    for source, name in sorted(names):
        terminal, _, member = name.partition(".contact.")
        motion = f"{terminal}.{CONJUGATES.get(member, '')}"
        if source == "track" and ("vehicle", motion) in names:
            forces.append(name)
            motions.append(motion)
    return forces, motions


def _assumption(port: Port, input_times: Mapping[str, str]):
    """Return how a slave understands inputs sampled at points: values at start and end of steps."""
    at_end = input_times.get(port.slave.name) == STEP_END
    if INPUT_TIME not in port.slave.variables:
        return _hold_new if at_end else _hold_old
    return _interpolate if at_end else _extrapolate


def _extrapolate(points: Array) -> tuple[Array, Array]:
    return points[1:-1], 2.0 * points[1:-1] - points[:-2]


def _interpolate(points: Array) -> tuple[Array, Array]:
    return points[1:-1], points[2:]


def _hold_old(points: Array) -> tuple[Array, Array]:
    return points[1:-1], points[1:-1]


def _hold_new(points: Array) -> tuple[Array, Array]:
    return points[2:], points[2:]
