"""The vehicle as an FMI slave: a thin mapping between variables and the model."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from rail_fmi import (
    KEEP_FIRST_INPUTS,
    RailSlave,
    StepError,
    Variable,
    __version__,
    parameter_variables,
)
from rail_quantities import ParameterSet, flatten, terminals, with_values

from rail_vehicle import errors
from rail_vehicle.coupling import INPUT_TIMES, ForceHistory
from rail_vehicle.guide import GUIDE
from rail_vehicle.model import VehicleModel, VehicleState
from rail_vehicle.parameters import LARGEST_DISPLACEMENT, VehicleParameters
from rail_vehicle.presets import MANCHESTER_1, PAPER, SOFT_PRIMARY
from rail_vehicle.step_limits import StepLimits

_NUMBERS = range(1, 5)
_HEIGHTS = tuple(f"wheelset[{i}].initial_vertical_displacement" for i in _NUMBERS)
_FORCES = tuple(
    f"wheelset[{i}].contact.{name}" for i in _NUMBERS for name, _, _ in terminals.CONTACT
)
_INPUT_TIME = "coupling.input_time"
_FORCE_ORDER = "coupling.force_order"
_RUN_SETTINGS = ("speed", "initial_position", "initial_lateral_displacement")
_SETPOINT_JUMP = 1.0  # m/s from the speed at the start; more is told


def preset_values(parameters: ParameterSet) -> dict[str, Any]:
    """Return a named vehicle as values by name, without the settings of a run."""
    values = {name: value for name, (_, value) in flatten(parameters).items()}
    return {name: value for name, value in values.items() if name not in _RUN_SETTINGS}


class VehicleSlave(RailSlave):
    """Vehicle of 50 degrees of freedom, driven by the contact forces on its wheelsets."""

    MODEL_NAME = "HighSpeedVehicle"
    CHECKS_OUTPUTS = True
    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "paper": preset_values(PAPER),
        "soft_primary": preset_values(SOFT_PRIMARY),
        "manchester1": preset_values(MANCHESTER_1),
    }
    description = "High-speed rail vehicle with 50 degrees of freedom"
    version = __version__
    license = "BSD-3-Clause"
    GUIDE = GUIDE
    EXPERIMENT: ClassVar[dict[str, float]] = {"startTime": 0.0, "stopTime": 1.0, "stepSize": 1e-4}

    def declare(self) -> Sequence[Variable]:
        """Return inputs, parameters and outputs."""
        defaults = VehicleParameters()
        model = VehicleModel(defaults)
        return [
            *_contact_inputs(defaults),
            Variable(
                "speed_setpoint",
                causality="input",
                unit="m/s",
                start=defaults.speed,
                description="Speed the car body is held to; follows `speed` until it is set",
            ),
            *parameter_variables(defaults),
            *_height_parameters(),
            *_coupling_parameters(),
            Variable(
                "static_wheel_load",
                causality="calculatedParameter",
                unit="N",
                start=defaults.static_wheel_load,
                description="Load of one wheel at rest",
            ),
            *(
                Variable(name, causality="output", unit=unit, description=description)
                for name, unit, description in model.output_table
            ),
        ]

    def initialize(self) -> None:
        """Build the model, put it into static equilibrium, and write the outputs."""
        known = flatten(VehicleParameters())
        values = {name: value for name, value in self.parameters().items() if name in known}
        parameters = with_values(VehicleParameters(), values)
        self._model = VehicleModel(parameters)
        self._find_places()
        self._order = int(self.values[_FORCE_ORDER])
        self._at_end = self.values[_INPUT_TIME] == "step_end"
        self._follow_parameters(parameters)
        self.values["static_wheel_load"] = parameters.static_wheel_load
        heights = self.reals[self.indices(_HEIGHTS)]
        state = self._model.initial_state(heights)
        forces = self._forces.reshape(4, 6)
        self._outputs[:] = self._model.outputs(state, forces).vector
        self._limits = StepLimits(parameters, at_end=self._at_end)
        self._told = False
        self._begin(state, ForceHistory.begin(forces))
        self._last_step = 0.0

    def _begin(self, state: VehicleState, history: ForceHistory) -> None:
        """Go on from a state."""
        self._march = self._model.march(state, history, self._limits.unit, self._outputs)

    def _find_places(self) -> None:
        self._forces = self.reals[self.slice_of(*_FORCES)]
        self._outputs = self.reals[
            self.slice_of(*(output.name for output in self._model.output_table))
        ]
        self._setpoint = int(self.indices(["speed_setpoint"])[0])

    def _follow_parameters(self, parameters: VehicleParameters) -> None:
        """Let inputs that nobody has set follow the parameters they stand for.

        So a vehicle of other masses or speed is at rest without a track, too.
        """
        vertical = self.indices([f"wheelset[{i}].contact.vertical_force" for i in _NUMBERS])
        load = -2.0 * parameters.static_wheel_load
        followed = getattr(self, "_followed", (PAPER.speed, -2.0 * PAPER.static_wheel_load))
        unset_speed = self.reals[self._setpoint] in (PAPER.speed, followed[0])
        if unset_speed:
            self.reals[self._setpoint] = parameters.speed
        if np.isin(self.reals[vertical], (-2.0 * PAPER.static_wheel_load, followed[1])).all():
            self.reals[vertical] = load
        self._followed = (parameters.speed, load)
        self._speed_is_set = not unset_speed

    def step(self, time: float, step_size: float) -> None:
        """Advance the model and write the outputs."""
        at_end = self._at_end
        if step_size > self._limits.accurate and not self._told:
            self._told = True
            self.warn(self._limits.warning(step_size))
        elapsed = step_size if at_end else self._last_step
        try:
            self._march.step(
                self._forces, elapsed, step_size, self._wanted_speed(), self._order, at_end
            )
        except errors.ExtrapolationError:
            text = f"t = {time:.9g} s: {self._limits.error(step_size)}"
            raise StepError(text) from None
        except errors.StepError as error:
            raise StepError(f"t = {time + step_size:.9g} s: {error}") from error
        self._last_step = step_size

    def _wanted_speed(self) -> float:
        """Return the setpoint, or the parameter while the input has only its start value."""
        setpoint = float(self.reals[self._setpoint])
        speed = self._model.parameters.speed
        if not self._speed_is_set and setpoint in (PAPER.speed, speed):
            return speed
        begins = self._last_step == 0.0 or not self._speed_is_set
        self._speed_is_set = True
        if begins and abs(setpoint - speed) > _SETPOINT_JUMP:
            self.warn(
                f"speed_setpoint = {setpoint:g} m/s, speed = {speed:g} m/s: the vehicle is driven "
                "from one to the other from now on. A tool may give 0 to an input that is not "
                "connected: give it the value of speed there"
            )
        return setpoint

    def initial_inputs(self) -> dict[str, Sequence[str]]:
        """Return the contact forces on the same wheelset for what they accelerate, else none."""
        unknowns = self.table.with_causality("output", "calculatedParameter")
        found: dict[str, Sequence[str]] = {variable.name: () for variable in unknowns}
        for i in _NUMBERS:
            forces = [name for name in _FORCES if name.startswith(f"wheelset[{i}].")]
            for name in found:
                own = name.startswith((f"wheelset[{i}].", f"axle_box[{i}]."))
                if own and name.endswith(("acceleration", "journal_force")):
                    found[name] = forces
        return found

    def save(self) -> dict[str, Any]:
        """Return the state of the model and the forces it remembers."""
        history = self._march.history
        return {
            "vector": self._march.vector,
            "ages": history.ages,
            "forces": history.forces,
            "extrapolation_errors": np.array(history.extrapolation_errors),
            "last_step": self._last_step,
            "speed_is_set": self._speed_is_set,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Take back what :meth:`save` returned."""
        self._begin(
            VehicleState.of_vector(state["vector"]),
            ForceHistory(state["ages"], state["forces"], tuple(state["extrapolation_errors"])),
        )
        self._last_step = float(state["last_step"])
        self._speed_is_set = bool(state["speed_is_set"])


def _contact_inputs(defaults: VehicleParameters) -> list[Variable]:
    return [
        Variable(
            f"wheelset[{number}].contact.{name}",
            causality="input",
            unit=unit,
            start=-2.0 * defaults.static_wheel_load if name == "vertical_force" else 0.0,
            nominal=1.0e5 if name == "vertical_force" else 1.0e4,
            description=description,
        )
        for number in _NUMBERS
        for name, unit, description in terminals.CONTACT
    ]


def _height_parameters() -> list[Variable]:
    return [
        Variable(
            name,
            causality="parameter",
            unit="m",
            minimum=-LARGEST_DISPLACEMENT,
            maximum=LARGEST_DISPLACEMENT,
            description="Displacement of the wheelset at the start, downwards from the datum: "
            "the track's static_vertical_displacement",
        )
        for name in _HEIGHTS
    ]


def _coupling_parameters() -> list[Variable]:
    return [
        Variable(
            _INPUT_TIME,
            kind="string",
            causality="parameter",
            choices=INPUT_TIMES,
            description="Instant of the step that the contact forces given to it stand for",
        ),
        Variable(
            _FORCE_ORDER,
            kind="integer",
            causality="parameter",
            start=2,
            minimum=0,
            maximum=2,
            description="Degree of the polynomial in time of the contact forces over a step",
        ),
        KEEP_FIRST_INPUTS,
    ]
