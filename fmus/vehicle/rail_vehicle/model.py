"""The vehicle: static equilibrium, pure step, outputs."""

import dataclasses
import math
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rail_quantities import flatten
from rail_quantities.uncounted import Reference

from rail_vehicle import limits
from rail_vehicle.arrangement import wheelset_positions
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
from rail_vehicle.errors import StepError
from rail_vehicle.integration import OperatorCache, contraction, element_gains
from rail_vehicle.kernel import (
    BEYOND,
    DAMPER_FORCES,
    GOOD,
    PITCH_ANGLES,
    PITCH_RATES,
    POSITION,
    RESULT_COUNT,
    SPEED,
    VECTOR_COUNT,
    evaluate,
)
from rail_vehicle.linear_system import FREE_COUNT, LinearSystem, assemble, first_order
from rail_vehicle.nonlinear import largest_slopes, law_constants
from rail_vehicle.outputs import MOTION_COUNT, Output, make_output_map
from rail_vehicle.parameters import VehicleParameters
from rail_vehicle.stepping import StepConstants, step_into

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
        Shape (104,), in SI units, laid out as in :mod:`rail_vehicle.kernel`. It is all
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
        self._law = law_constants(parameters)
        self._constants = np.array(
            [
                system.spin_inertia,
                self._rolling_spin(parameters.speed),
                -2.0 * parameters.static_wheel_load,
            ]
        )
        self._limits = limits.motion_limits(parameters)
        self._signals = np.ascontiguousarray(system.signals.T)
        self._outputs = make_output_map(parameters, bodies, system)
        self.output_table: tuple[Output, ...] = self._outputs.table
        self._index = {output.name: place for place, output in enumerate(self.output_table)}
        self.internal_step = self._longest_step()
        self._made: tuple[float, Any, int] = (math.nan, None, 0)

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
        limits.check_start(vector, self._limits, heights)
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
        result = np.empty(RESULT_COUNT)
        evaluate(
            state.vector,
            _flat(forces),
            acceleration,
            self._signals,
            self._constants,
            self._law,
            result,
        )
        return VehicleOutputs(self._outputs(result), self._index)

    def step(
        self,
        state: VehicleState,
        force_start: Array,
        force_end: Array,
        dt: float,
        speed_setpoint: float | None = None,
        force_bow: Array | None = None,
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
        force_bow
            Quadratic part of the forces, shape (4, 6): they are
            ``start + (end - start) s + bow s (s - 1)`` with s from 0 to 1.

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
        forces = np.zeros((3, 24))
        forces[0], forces[1] = _flat(force_start), _flat(force_end)
        if force_bow is not None:
            forces[2] = _flat(force_bow)
        result, outputs = np.empty(RESULT_COUNT), np.empty(len(self.output_table))
        self.step_into(state.vector, forces, dt, speed_setpoint, result, outputs)
        return VehicleState(result[:VECTOR_COUNT]), VehicleOutputs(outputs, self._index)

    def step_into(
        self,
        vector: Array,
        forces: Array,
        dt: float,
        speed_setpoint: float | None,
        result: Array,
        outputs: Array,
    ) -> None:
        """Advance by ``dt`` seconds as :meth:`step` does, into arrays of the caller.

        Parameters
        ----------
        vector
            State at the start, shape (104 or more,), SI units; what follows it is not read.
        forces
            Contact forces at start and end and their quadratic part, shape (3, 24), N, N.m.
        dt, speed_setpoint
            In s and m/s, as for :meth:`step`.
        result
            Written: the state at the end, then what the outputs are made of, shape (145,),
            SI units; not the memory of ``vector``.
        outputs
            Written: all outputs, in the order and the units of ``output_table``.

        Raises
        ------
        StepError
            As :meth:`step`; ``vector`` and ``outputs`` are then unchanged.
        """
        if dt != self._made[0]:
            self._made = self._make(dt)
        acceleration = self._acceleration(float(vector[SPEED]), speed_setpoint, dt)
        _, constants, count = self._made
        found = step_into(
            constants, vector, forces, acceleration, dt / count, count, result, outputs
        )
        if found != GOOD:
            raise StepError(self._why(found, vector, result))

    def _make(self, dt: float) -> tuple[float, Reference, int]:
        """Return ``dt`` (s), what its step takes, and how many parts it has."""
        count, of = self._count(dt), self._outputs
        constants = StepConstants(
            *self._operators[dt / count],
            constants=self._constants,
            law=self._law,
            limits=self._limits,
            offsets=of.offsets,
            values=of.values,
            columns=of.columns,
            row_starts=of.row_starts,
        )
        return dt, Reference(constants), count

    def _count(self, dt: float) -> int:
        """Return the number of internal steps in a step of ``dt`` s."""
        if not 0.0 < dt <= _MOST_PARTS * self.internal_step:
            raise StepError(
                f"step size {dt!r} s: must be positive and finite, and at most "
                f"{_MOST_PARTS * self.internal_step:g} s, {_MOST_PARTS} internal steps"
            )
        return max(1, math.ceil(dt / self.internal_step * (1.0 - 1e-9)))

    def _why(self, found: int, vector: Array, result: Array) -> str:
        place = f"at position {vector[POSITION]:.3f} m"
        if found == BEYOND:
            return (
                f"{limits.beyond(result, self._limits)}, {place}: the contact forces drive the "
                "vehicle off its track, or the coupling diverges; look at what gives these forces, "
                "or try a smaller communication step"
            )
        return (
            f"the vehicle's motion could not be found {place}: "
            "the contact forces are not finite or drive the suspensions beyond all bounds; "
            "try a smaller communication step"
        )

    def _acceleration(self, speed: float, setpoint: float | None, dt: float) -> float:
        if setpoint is None:
            return 0.0
        limits.check_setpoint(setpoint)
        limit = self.parameters.speed_constraint.acceleration_limit
        return min(max((setpoint - speed) / dt, -limit), limit)
