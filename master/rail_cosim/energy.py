"""Energy residual of the coupling: the work that the exchange itself adds at the interface.

What the track gives a wheelset must be what the wheelset receives. It is not,
as long as a side works with extrapolated inputs: the track's power is its
contact force times the motion it *assumed*, the vehicle's power is the force
it *assumed* times its motion. The difference is a measure of the coupling error
that needs no reference solution.

The master sees values at communication points only. What a slave assumes between them is part
of the coupling contract (:mod:`rail_cosim.interpolation`). What it gives is taken as the cubic
through four values for a force, and as the cubic through positions and velocities at both ends
for a motion: both are a degree better than what is assumed. The work in a step follows from Gauss's
quadrature.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rail_cosim.algorithms import STEP_END
from rail_cosim.initialisation import INPUT_TIME
from rail_cosim.interpolation import POINTS, QUADRATURE, Velocity, hermite, polynomial, rate
from rail_cosim.slave import Slave
from rail_cosim.system import SystemStructure

CONJUGATES = {
    "longitudinal_force": ("longitudinal_velocity", "longitudinal_position"),
    "lateral_force": ("lateral_velocity", "lateral_displacement"),
    "vertical_force": ("vertical_velocity", "vertical_displacement"),
    "roll_moment": ("roll_rate", "roll_angle"),
    "pitch_moment": ("pitch_rate", ""),
    "yaw_moment": ("yaw_rate", "yaw_angle"),
}
"""Velocity and position that belong to a force; the pitch angle is not exchanged."""

FORCE_ORDER = "coupling.force_order"
USUAL_ORDER = 2
"""Of a slave that has ``coupling.input_time`` but does not tell its order."""

GOOD = 5e-3
"""Largest share of the energy residual that is good: up to it the coupling error of the wheel force
is about 1 % of the force's amplitude or less (docs/theory.md, section 10)."""

_BEFORE = len(POINTS) - 1
_BLOCK = 1024
Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class EnergyReport:
    """Energies accumulated over a run, in J.

    The first two steps do not count: the slaves have no past yet to extrapolate from.

    Attributes
    ----------
    residual
        What the vehicle received less what the track gave.
    absolute_residual
        Sum of the steps' absolute residuals.
    exchanged
        Sum of the steps' absolute works on the vehicle.
    """

    residual: float = 0.0
    absolute_residual: float = 0.0
    exchanged: float = 0.0

    @property
    def share(self) -> float:
        """The absolute residual as a share of the work exchanged; 0 if none was."""
        return self.absolute_residual / self.exchanged if self.exchanged else 0.0


class InterfaceEnergy:
    """Observer that accumulates the energy residual between ``track`` and ``vehicle``.

    Parameters
    ----------
    system
        The coupled slaves, initialised.
    input_times
        What instant the inputs of each slave stand for, by the algorithm; where the slave has
        the parameter ``coupling.input_time``, its value counts.
    step_size
        Macro step in s.

    Attributes
    ----------
    places
        Where forces, the velocities that belong to them, and the positions of those that have
        one are on the system's board.
    """

    def __init__(
        self, system: SystemStructure, input_times: Mapping[str, str], step_size: float
    ) -> None:
        self._board, self._step_size = system.board, step_size
        forces, velocities, positions = _exchanged(system)
        places = [system.place_of("track", name) for name in forces]
        places += [system.place_of("vehicle", name) for name in velocities]
        self._with_position = np.array([bool(name) for name in positions], dtype=bool)
        places += [system.place_of("vehicle", name) for name in positions if name]
        self.places = np.array(places, dtype=np.intp)
        self._count = len(forces)
        track, vehicle = system["track"], system["vehicle"]
        self._force = polynomial(1, _BEFORE), _assumed_force(vehicle, input_times)
        self._motions = (
            (hermite(1), rate(polynomial(1, 1))),
            _assumed_motions(track, input_times),
        )
        # Rows: three points of the block before, then the points of this one.
        self._values = np.zeros((_BLOCK + _BEFORE, len(places)))
        self._report = EnergyReport()
        self._row = 0
        self.observe()

    def take_in(self, rows: Array) -> None:
        """Take in the values of :attr:`places` at the ends of some steps, (steps, places)."""
        for row in rows:
            self._values[self._row] = row
            self._row += 1
            if self._row == len(self._values):
                self._report = self.report()
                self._values[:_BEFORE] = self._values[-_BEFORE:]
                self._row = _BEFORE

    def observe(self) -> None:
        """Take in the values at the end of a step."""
        self.take_in(self._board[self.places][None])

    def report(self) -> EnergyReport:
        """Return what has been accumulated so far."""
        steps = self._row - _BEFORE
        if steps <= 0 or self._count == 0:
            return self._report
        n = self._count
        windows = np.stack([self._values[k : k + steps] for k in range(len(POINTS))])
        forces, velocities, positions = np.split(windows, [n, 2 * n], axis=2)
        given, assumed = (_over_step(weights, forces) for weights in self._force)
        own, taken = (self._velocity(kinds, velocities, positions) for kinds in self._motions)
        received = self._work(assumed, own)
        residual = received - self._work(given, taken)
        return EnergyReport(
            residual=self._report.residual + float(residual.sum()),
            absolute_residual=self._report.absolute_residual + float(np.abs(residual).sum()),
            exchanged=self._report.exchanged + float(np.abs(received).sum()),
        )

    def memory(self) -> dict[str, Array]:
        """Return what it remembers, as arrays by name."""
        totals = np.array(dataclasses.astuple(self._report))
        return {"totals": totals, "values": self._values[: self._row].copy()}

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Take back what :meth:`memory` returned."""
        residual, absolute, exchanged = (float(value) for value in memory["totals"])
        self._report = EnergyReport(
            residual=residual, absolute_residual=absolute, exchanged=exchanged
        )
        self._row = len(memory["values"])
        self._values[: self._row] = memory["values"]

    def _velocity(
        self, kinds: tuple[Velocity, Velocity], velocities: Array, positions: Array
    ) -> Array:
        """Velocities at the nodes, (nodes, steps, pairs); ``kinds``: with position, without."""
        with_position, alone = kinds
        found = _over_step(alone.of_velocities, velocities)
        there = self._with_position
        found[..., there] = _over_step(with_position.of_velocities, velocities[..., there])
        # Differences from the start of the step: positions along the line are large.
        moved = (positions - positions[POINTS.index(0)]) / self._step_size
        found[..., there] += _over_step(with_position.of_positions, moved)
        return found

    def _work(self, force: Array, velocity: Array) -> Array:
        """Work in each step, shape (steps,)."""
        power = np.einsum("qsp,qsp->qs", force, velocity)
        return self._step_size * (QUADRATURE @ power)


def _over_step(weights: Array, values: Array) -> Array:
    return np.tensordot(weights, values, axes=1)


def _exchanged(system: SystemStructure) -> tuple[list[str], list[str], list[str]]:
    """Return the exchanged forces, and the velocity and position (or "") of each."""
    names = {(c.source, c.name) for c in system.connections}
    found: list[tuple[str, str, str]] = []
    for source, name in sorted(names):
        terminal, _, member = name.partition(".contact.")
        velocity, position = (f"{terminal}.{part}" for part in CONJUGATES.get(member, ("", "")))
        if source == "track" and ("vehicle", velocity) in names:
            found.append((name, velocity, position if ("vehicle", position) in names else ""))
    forces, velocities, positions = zip(*found, strict=True) if found else ((), (), ())
    return list(forces), list(velocities), list(positions)


def _newest(slave: Slave, input_times: Mapping[str, str]) -> int:
    """Return the point that the newest inputs in a step stand for, 0 or 1."""
    if INPUT_TIME in slave.variables:
        return int(slave.get([INPUT_TIME])[INPUT_TIME] == STEP_END)
    return int(input_times.get(slave.name) == STEP_END)


def _assumed_force(vehicle: Slave, input_times: Mapping[str, str]) -> Array:
    order = 0
    if INPUT_TIME in vehicle.variables:
        order = USUAL_ORDER
        if FORCE_ORDER in vehicle.variables:
            order = int(vehicle.get([FORCE_ORDER])[FORCE_ORDER])
    return polynomial(_newest(vehicle, input_times), order)


def _assumed_motions(track: Slave, input_times: Mapping[str, str]) -> tuple[Velocity, Velocity]:
    newest = _newest(track, input_times)
    if INPUT_TIME not in track.variables:
        held = rate(polynomial(newest, 0))
        return held, held
    return hermite(newest), rate(polynomial(newest, 1))
