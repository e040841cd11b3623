"""The vehicle: static equilibrium, pure step, outputs."""

import dataclasses
import math
import threading
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rail_quantities import flatten

from rail_vehicle import limits
from rail_vehicle.arrangement import wheelset_positions
from rail_vehicle.constants import step_constants
from rail_vehicle.coordinates import (
    COORDINATE_COUNT,
    FREE,
    LATERAL,
    ROLL,
    WHEELSET_COORDINATES,
    YAW,
    Y,
    Z,
)
from rail_vehicle.coupling import ForceHistory
from rail_vehicle.errors import ExtrapolationError, StepError
from rail_vehicle.integration import OperatorCache, contraction, element_gains
from rail_vehicle.kernels import (
    BEYOND,
    DAMPER_FORCES,
    FORCE_COUNT,
    GOOD,
    NOT_FOLLOWED,
    PITCH_ANGLES,
    PITCH_RATES,
    POSITION,
    SPEED,
    VECTOR_COUNT,
    Constants,
    Operators,
    coupled_step,
    evaluate,
    step,
    workspace,
)
from rail_vehicle.linear_system import FREE_COUNT, LinearSystem, assemble, first_order
from rail_vehicle.nonlinear import largest_slopes
from rail_vehicle.outputs import MOTION_COUNT, Output, make_output_map
from rail_vehicle.parameters import VehicleParameters
from rail_vehicle.step_limits import LARGEST_EXTRAPOLATION_ERROR

Array = NDArray[np.float64]

MAX_INTERNAL_STEP = 1e-3
"""Longest internal step in s; longer communication steps are divided."""

_MOST_PARTS = 100_000
_LARGEST_CONTRACTION = 0.2
_STOP_STROKE = 0.05
"""Compression in m up to which the stops' slope is kept well within the iteration's reach."""


def _flat(forces: Array) -> Array:
    """Return contact forces (4, 6) as the kernel takes them, shape (24,)."""
    return np.ascontiguousarray(forces, dtype=np.float64).reshape(24)


@dataclasses.dataclass(frozen=True)
class VehicleState:
    """State of the vehicle as one vector of 104 numbers; never changed in place.

    Attributes
    ----------
    vector
        Shape (104,), in SI units, laid out as in :mod:`rail_vehicle.kernels`. It is all
        that saving and restoring needs.
    """

    vector: Array

    @property
    def position(self) -> float:
        """Position of the car body's centre along the line, m."""
        return float(self.vector[POSITION])

    @property
    def speed(self) -> float:
        """Speed of the car body, m/s."""
        return float(self.vector[SPEED])

    @property
    def coordinates(self) -> Array:
        """All 50 coordinates, shape (50,), m and rad."""
        values = np.zeros(COORDINATE_COUNT)
        values[FREE] = self.vector[:FREE_COUNT]
        values[WHEELSET_COORDINATES[:, 4]] = self.vector[PITCH_ANGLES : PITCH_ANGLES + 4]
        return values

    @property
    def rates(self) -> Array:
        """Rates of the 50 coordinates, shape (50,), m/s and rad/s."""
        values = np.zeros(COORDINATE_COUNT)
        values[FREE] = self.vector[FREE_COUNT : 2 * FREE_COUNT]
        values[WHEELSET_COORDINATES[:, 4]] = self.vector[PITCH_RATES : PITCH_RATES + 4]
        return values

    @property
    def yaw_damper_forces(self) -> Array:
        """Forces of the yaw dampers (bogie 1 left, right, bogie 2 left, right), N."""
        return self.vector[DAMPER_FORCES : DAMPER_FORCES + 4].copy()

    @classmethod
    def of_vector(cls, vector: ArrayLike) -> Self:
        """Make a state of a saved ``vector``, shape (104,), in SI units.

        Raises
        ------
        ValueError
            If it has not 104 finite entries.
        """
        values = np.array(vector, dtype=float)
        if values.shape != (VECTOR_COUNT,) or not np.isfinite(values).all():
            raise ValueError(f"a vehicle's state has {VECTOR_COUNT} finite entries")
        return cls(values)


@dataclasses.dataclass(frozen=True)
class VehicleOutputs:
    """Values of all outputs.

    Attributes
    ----------
    vector
        Shape (outputs,), in the order and the units of ``VehicleModel.output_table``.
    index
        Place of each output in it, by FMI name.
    """

    vector: Array
    index: dict[str, int]

    @property
    def motion(self) -> Array:
        """Motion of the wheelsets in the order of the terminal, shape (4, 11)."""
        return self.vector[: 4 * MOTION_COUNT].reshape(4, MOTION_COUNT)

    def __getitem__(self, name: str) -> float:
        """Return the output of this FMI name."""
        return float(self.vector[self.index[name]])


class VehicleModel:
    """A vehicle of given parameters. It holds no state: ``step`` is pure.

    Attributes
    ----------
    parameters
        The parameters it was built from.
    output_table
        Name, unit and meaning of each output.
    internal_step
        Longest step that is not divided, s.
    """

    def __init__(self, parameters: VehicleParameters) -> None:
        self.parameters = parameters
        self._linear, bodies = assemble(parameters)
        system = first_order(parameters, self._linear)
        self._operators = OperatorCache(system)
        self._of_thread = threading.local()
        outputs = make_output_map(parameters, bodies, system)
        self._constants = step_constants(parameters, system, outputs)
        self.output_table: tuple[Output, ...] = outputs.table
        self._index = {output.name: place for place, output in enumerate(self.output_table)}
        self.internal_step = self._longest_step()

    def _rolling_spin(self, speed: float) -> float:
        return -speed / self.parameters.wheelset.radius

    def _longest_step(self) -> float:
        """Halve the internal step until the iteration for the element forces contracts well."""
        slopes = largest_slopes(self.parameters, _STOP_STROKE)
        step = MAX_INTERNAL_STEP
        while contraction(self._operators[step], slopes) > _LARGEST_CONTRACTION:
            step *= 0.5
            if step < limits.SHORTEST_STEP:
                gains = element_gains(self._operators[step], slopes)
                limits.refuse_short_step(step, flatten(self.parameters), np.diag(gains))
        return step

    @property
    def static_forces(self) -> Array:
        """Contact forces of the static equilibrium, shape (4, 6), N and N m."""
        forces = np.zeros((4, 6))
        forces[:, Z] = -2.0 * self.parameters.static_wheel_load
        return forces

    def linear_system(self) -> LinearSystem:
        """Matrices of the linear part, for reference solutions and modal analysis."""
        return self._linear

    def initial_state(
        self,
        initial_vertical_displacement: ArrayLike = (0.0, 0.0, 0.0, 0.0),
        speed: float | None = None,
    ) -> VehicleState:
        """Return the vehicle at rest in the moving frame, its wheelsets at given heights.

        The wheelsets are held at these heights, upright and not yawed; everything else is in
        static equilibrium with that. All bodies are then shifted sideways by the parameter
        ``initial_lateral_displacement``, which strains no suspension.

        Parameters
        ----------
        initial_vertical_displacement
            Heights of the wheelsets, m, downwards, shape (4,).
        speed
            At which the wheels roll, m/s; the parameter's unless given.

        Raises
        ------
        ParameterError
            If the heights are not finite, or put a body beyond the limits of motion.
        """
        heights = np.asarray(initial_vertical_displacement, dtype=float)
        limits.check_heights(heights)
        speed = self.parameters.speed if speed is None else float(speed)
        stiffness = self._linear.stiffness
        held = WHEELSET_COORDINATES[:, [Y, Z, ROLL, YAW]].ravel()
        vertical = WHEELSET_COORDINATES[:, Z]
        loose = np.setdiff1d(FREE, held)
        coordinates = np.zeros(COORDINATE_COUNT)
        coordinates[vertical] = heights
        if heights.any():
            load = -stiffness[np.ix_(loose, vertical)] @ heights
            coordinates[loose] = np.linalg.solve(stiffness[np.ix_(loose, loose)], load)
        coordinates[LATERAL] += self.parameters.initial_lateral_displacement
        vector = np.zeros(VECTOR_COUNT)
        vector[:FREE_COUNT] = coordinates[FREE]
        vector[PITCH_RATES : PITCH_RATES + 4] = self._rolling_spin(speed)
        leading = wheelset_positions(self.parameters)[0]
        vector[POSITION] = self.parameters.initial_position - leading
        vector[SPEED] = speed
        limits.check_start(vector, self._constants.limits, heights)
        return VehicleState(vector)

    def outputs(
        self, state: VehicleState, forces: Array, acceleration: float = 0.0
    ) -> VehicleOutputs:
        """Return the outputs at a state.

        Parameters
        ----------
        state
            The state.
        forces
            Contact forces on the wheelsets, shape (4, 6), N and N.m.
        acceleration
            Of the car body along the line, m/s2.
        """
        outputs = np.empty(len(self.output_table))
        evaluate(
            self._operators[self.internal_step], self._constants, workspace(), state.vector,
            _flat(forces), float(acceleration), outputs,
        )  # fmt: skip
        return VehicleOutputs(outputs, self._index)

    def step(
        self,
        state: VehicleState,
        force_start: Array,
        force_end: Array,
        dt: float,
        speed_setpoint: float | None = None,
        force_quadratic: Array | None = None,
    ) -> tuple[VehicleState, VehicleOutputs]:
        """Advance by ``dt`` seconds.

        Parameters
        ----------
        state
            At the start; not changed.
        force_start, force_end
            Contact forces at both ends of the step, shape (4, 6), N and N m.
        dt
            Length of the step, s. It is divided if longer than ``internal_step``.
        speed_setpoint
            Speed to be reached at the end, m/s, within the limit of
            acceleration; by default the present speed.
        force_quadratic
            Quadratic part of the forces, shape (4, 6): they are
            ``start + (end - start) s + quadratic s (s - 1)`` with s from 0 to 1.

        Returns
        -------
        state, outputs
            At the end of the step.

        Raises
        ------
        StepError
            If the step is not positive, the state is no longer finite, or a body is beyond
            the limits of motion: 5 m or 1 rad from where it rests.
        """
        bound = getattr(self._of_thread, "step", None)
        if bound is None or bound.duration != dt:
            bound = self._of_thread.step = _BoundStep(self, self._constants, dt)
        bound.vector[:] = state.vector
        bound.forces[0], bound.forces[1] = _flat(force_start), _flat(force_end)
        bound.forces[2] = 0.0 if force_quadratic is None else _flat(force_quadratic)
        bound.timing[1] = self.wanted_speed(bound.vector, speed_setpoint)
        found = bound.call()
        if found != GOOD:
            raise StepError(self.why(found, bound.vector, bound.new))
        return VehicleState(bound.new.copy()), VehicleOutputs(bound.outputs.copy(), self._index)

    def march(
        self,
        state: VehicleState,
        history: ForceHistory,
        unit: tuple[float, ...],
        outputs: Array,
    ) -> "March":
        """Return what steps on from a state with forces at communication points.

        Parameters
        ----------
        state, history
            Where it starts.
        unit
            What counts as a large force or moment on a wheelset, six numbers, N and N.m.
        outputs
            Shape (outputs,), written at every step, SI units.
        """
        return March(self, self._constants, state.vector, history, unit, outputs)

    def operators(self, dt: float) -> tuple[Operators, int]:
        """Return the operators of a communication step of ``dt`` s, and its internal steps.

        Raises
        ------
        StepError
            If it is not positive, or too long.
        """
        if not 0.0 < dt <= _MOST_PARTS * self.internal_step:
            raise StepError(
                f"step size {dt!r} s: must be positive and finite, and at most "
                f"{_MOST_PARTS * self.internal_step:g} s, {_MOST_PARTS} internal steps"
            )
        count = max(1, math.ceil(dt / self.internal_step * (1.0 - 1e-9)))
        return self._operators[dt / count], count

    @staticmethod
    def wanted_speed(vector: Array, setpoint: float | None) -> float:
        """Return the speed to be reached, m/s: ``setpoint``, or that of ``vector`` (104,)."""
        if setpoint is None:
            return float(vector[SPEED])
        limits.check_setpoint(setpoint)
        return setpoint

    def why(self, found: int, vector: Array, new: Array) -> str:
        """Say why a step came no farther: ``found``; ``vector``, ``new`` (104,), SI units."""
        place = f"at position {vector[POSITION]:.3f} m"
        if found == BEYOND:
            return (
                f"{limits.beyond(new, self._constants.limits)}, {place}: the contact forces "
                "drive the vehicle off its track, or the coupling diverges; look at what gives "
                "these forces, or try a smaller communication step"
            )
        return (
            f"the vehicle's motion could not be found {place}: "
            "the contact forces are not finite or drive the suspensions beyond all bounds; "
            "try a smaller communication step"
        )


class _BoundStep:
    """A step of ``duration`` s, with the arrays that it takes and fills."""

    def __init__(self, model: VehicleModel, constants: Constants, duration: float) -> None:
        operators, count = model.operators(duration)
        self.duration, self.timing = duration, np.array([duration, 0.0])
        self.vector, self.new = np.zeros(VECTOR_COUNT), np.zeros(VECTOR_COUNT)
        self.forces, self.outputs = np.zeros((3, FORCE_COUNT)), np.zeros(len(model.output_table))
        self.call = step.bind(
            operators, constants, workspace(), self.vector, self.forces, self.timing, count,
            self.new, self.outputs,
        )  # fmt: skip


class March:
    """A vehicle that steps on: two states, in turn the one at the start and the one at the end.

    Parameters
    ----------
    model
        The vehicle.
    constants
        Of its steps.
    vector, history
        State and contact forces to start from; they are copied.
    unit
        What counts as a large force or moment on a wheelset, six numbers, N and N.m.
    outputs
        Written at every step.
    """

    def __init__(
        self,
        model: VehicleModel,
        constants: Constants,
        vector: Array,
        history: ForceHistory,
        unit: tuple[float, ...],
        outputs: Array,
    ) -> None:
        self._unit = np.tile(np.array(unit, dtype=float), FORCE_COUNT // 6)
        self._model, self._constants, self._outputs = model, constants, outputs
        self._vectors = np.array(vector), np.zeros(VECTOR_COUNT)
        self._history, self._newest = history.packed(), np.zeros(FORCE_COUNT)
        self._timing, self._work = np.zeros(3), workspace()
        self._now, self._key = 0, (math.nan, 0, False)
        self._calls: list[Any] = []

    @property
    def vector(self) -> Array:
        """Present state; copy what is to stay."""
        return self._vectors[self._now]

    @property
    def history(self) -> ForceHistory:
        """Contact forces at the last communication points."""
        return ForceHistory.of_packed(self._history)

    def step(
        self, forces: Array, elapsed: float, dt: float, setpoint: float, order: int, at_end: bool
    ) -> None:
        """Advance by ``dt`` s.

        Parameters
        ----------
        forces
            Contact forces on the wheelsets, (24,), N and N.m, ``elapsed`` s after those before.
        dt, setpoint
            In s and m/s.
        order, at_end
            Degree of the forces over the step, and whether ``forces`` stand for its end.

        Raises
        ------
        StepError
            As :meth:`VehicleModel.step`.
        ExtrapolationError
            If the forces turn from step to step.
        """
        if (dt, order, at_end) != self._key:
            self._bind(dt, order, at_end)
        now = self._now
        self._newest[:] = forces
        timing = self._timing
        timing[0], timing[1], timing[2] = dt, setpoint, elapsed
        limits.check_setpoint(setpoint)
        found = self._calls[now]()
        if found == NOT_FOLLOWED:
            raise ExtrapolationError("the contact forces do not follow from those before")
        if found != GOOD:
            raise StepError(self._model.why(found, self._vectors[now], self._vectors[1 - now]))
        self._now = 1 - now

    def _bind(self, dt: float, order: int, at_end: bool) -> None:
        operators, count = self._model.operators(dt)
        self._calls = [
            coupled_step.bind(
                operators,
                self._constants,
                self._work,
                self._vectors[first],
                self._history,
                self._newest,
                self._timing,
                order,
                at_end,
                self._unit,
                LARGEST_EXTRAPOLATION_ERROR,
                count,
                self._vectors[1 - first],
                self._outputs,
            )
            for first in (0, 1)
        ]
        self._key = dt, order, at_end
