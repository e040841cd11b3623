"""The track as an FMI slave: a thin mapping between variables and the model."""

import math
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
from rail_quantities import flatten, terminals, with_values

from slab_track import variables as names
from slab_track.errors import TrackError
from slab_track.guide import GUIDE
from slab_track.kernels.state import SHIFT_COUNT, SHIFT_RESIDUAL, TIME, WINDOW_START
from slab_track.model import TrackModel, TrackState
from slab_track.motion import MOTION
from slab_track.parameters import TrackParameters
from slab_track.presets import LINES
from slab_track.profile import TrackProfile

LEVEL_CONTACT = (
    "contact.model = vertical: rails, slabs and contact move vertically, creep and lateral forces "
    "are zero; contact.model = profiles has wheel and rail profiles, creep forces, lateral motion "
    "and torsion of the rails"
)

_RUN_SETTINGS = ("initial_position", "interface", "wheelset_count", "static_wheel_load")


class TrackSlave(RailSlave):
    """Two rails on slabs in a window that moves along with the wheelsets."""

    MODEL_NAME = "InfiniteSlabTrack"
    CHECKS_OUTPUTS = True
    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        name: {key: value for key, (_, value) in flatten(line).items() if key not in _RUN_SETTINGS}
        for name, line in LINES.items()
    }
    description = "Endless slab track with wheel/rail contact"
    version = __version__
    license = "BSD-3-Clause"
    GUIDE = GUIDE
    EXPERIMENT: ClassVar[dict[str, float]] = {"startTime": 0.0, "stopTime": 1.0, "stepSize": 1e-4}

    def declare(self) -> Sequence[Variable]:
        """Return inputs, parameters and outputs."""
        return [
            *_inputs(),
            *parameter_variables(TrackParameters()),
            *_settings(),
            *_outputs(),
            *_profiles(),
        ]

    def initialize(self) -> None:
        """Build the track, bring it into equilibrium, and write the outputs."""
        known = flatten(TrackParameters())
        values = {name: value for name, value in self.parameters().items() if name in known}
        parameters = with_values(TrackParameters(), values)
        if getattr(self, "_model", None) is None or self._model.parameters != parameters:
            self._model, self._profile = TrackModel(parameters), None
            self._find_places(parameters.wheelset_count)
        self._at_end = self.values[names.INPUT_TIME] == "step_end"
        self._is_driven = parameters.interface == "applied_force"
        self._shows_profiles = self.values[names.PROFILES_WANTED]
        try:
            state = self._model.initial_state(self._motion(), self.time)
        except TrackError as error:
            raise StepError(str(error)) from error
        self.reals[self._heights] = state.static_heights
        self._take(state)

    def _take(self, state: TrackState) -> None:
        """Go on from a state."""
        self._march = self._model.stepper.march(state)
        self._observed, self._slides = math.nan, -1
        self._publish()

    def start(self) -> None:
        """Say what the user should know."""
        parameters = self._model.parameters
        if parameters.interface == "contact" and parameters.contact.model == "vertical":
            self.info(LEVEL_CONTACT)
        state, irregularity = self._model.state_of(self._march.vector), self._model.irregularity
        if irregularity.fade_in:
            self.info(irregularity.fade_in)
        remarks = irregularity.remarks
        if not self._is_driven:
            remarks += irregularity.start_remarks(state.motion[:, 0])
        for remark in remarks:
            self.warn(remark)

    def _find_places(self, count: int) -> None:
        inputs = self.reals[self.slice_of(*names.motion_names(count))]
        self._inputs = inputs.reshape(-1, len(MOTION))
        self._applied = np.array(
            [
                self.indices(names.rail_head_names(name, count))
                for name in ("lateral_force", "vertical_force", "roll_moment")
            ]
        )
        of_wheels = [name for kind in names.WHEEL for name in names.wheel_names(kind, count)]
        places = self._model.layout.places
        source = np.concatenate([places(part).ravel() for part in ("wheelset", "outputs")])
        target = self.indices([*names.contact_names(count), *of_wheels])
        self._runs = [
            (self.reals[first], of) for first, of in zip(*_runs(target, source), strict=True)
        ]
        self._window = self.indices(["window.start_position", "window.slide_residual"])
        self._heights = self.slice_of(
            *(f"wheelset[{i}].static_vertical_displacement" for i in range(1, count + 1))
        )
        self._profiles = self.slice_of(
            *(name for group in names.PROFILES for name in names.profile_names(group))
        )

    def _motion(self) -> np.ndarray:
        """Return the inputs as a motion array, shape (wheelsets, 11).

        Positions that nobody has set are those of the article's vehicle.
        """
        if not np.any(self._inputs[:, 0]):
            self._inputs[:, 0] = self._model.default_positions()
        return self._inputs.copy()

    def step(self, time: float, step_size: float) -> None:
        """Advance the model and write the outputs."""
        applied = None
        if self._is_driven:
            applied = self.reals[self._applied].T.reshape(-1, 2, 3)
        try:
            self._march.step(self._inputs, step_size, at_end=self._at_end, applied_force=applied)
        except TrackError as error:
            raise StepError(str(error)) from error
        self._publish()

    def _publish(self) -> None:
        vector = self._march.vector
        for place, source in self._runs:
            place[:] = vector[source]
        if vector[SHIFT_COUNT] != self._slides:
            self._slides = self.values["window.slide_count"] = int(vector[SHIFT_COUNT])
            self.reals[self._window] = vector[[WINDOW_START, SHIFT_RESIDUAL]]

    def observe(self) -> None:
        """Write the profiles of rails and slabs."""
        if not self._shows_profiles or self._observed == self._march.vector[TIME]:
            return
        if self._profile is None:
            self._profile = TrackProfile(self._model.parameters, self._model.linear)
        first, spacing = self.values[names.FIRST_OFFSET], self.values[names.SPACING]
        offsets = first - spacing * np.arange(names.PROFILE_POINTS)
        state = self._model.state_of(self._march.vector)
        shapes = [of(state, offsets) for of in (self._profile.rails, self._profile.slabs)]
        self.reals[self._profiles] = np.ravel(shapes)
        self._observed = self._march.vector[TIME]

    def initial_inputs(self) -> dict[str, Sequence[str]]:
        """Return the motions of all wheelsets, which act on each other through the rails."""
        motions = names.motion_names(len(names.NUMBERS))
        found: dict[str, Sequence[str]] = {
            variable.name: motions for variable in self.table.with_causality("output")
        }
        positions = [name for name in motions if name.endswith(".longitudinal_position")]
        slides = dict.fromkeys(("window.slide_count", "window.slide_residual"), ())
        return found | {"window.start_position": positions} | slides

    def save(self) -> dict[str, Any]:
        """Return the state of the track."""
        return {"vector": self._march.vector}

    def restore(self, state: dict[str, Any]) -> None:
        """Take back what :meth:`save` returned."""
        self._take(self._model.state_of(state["vector"]))


def _runs(target: np.ndarray, source: np.ndarray) -> tuple[list[slice], list[slice]]:
    """Return slices of both arrays of places, (n,), as long as both are consecutive."""
    ends = np.flatnonzero((np.diff(target) != 1) | (np.diff(source) != 1)) + 1
    parts = [np.split(places, ends) for places in (target, source)]
    first, second = ([slice(int(p[0]), int(p[-1]) + 1) for p in part] for part in parts)
    return first, second


def _inputs() -> list[Variable]:
    """Return the input variables."""
    motion = [
        Variable(f"wheelset[{i}].{name}", causality="input", unit=unit, description=description)
        for i in names.NUMBERS
        for name, unit, description in terminals.MOTION
    ]
    rail_head = [
        Variable(
            f"rail_head[{i}].{side}.{name}",
            causality="input",
            unit=unit,
            description=f"{description}, under the wheel; used with interface = applied_force",
        )
        for name, (unit, description) in names.RAIL_HEAD.items()
        for i in names.NUMBERS
        for side in names.SIDES
    ]
    return motion + rail_head


def _settings() -> list[Variable]:
    """Return the parameters of the interface."""
    return [
        Variable(
            names.INPUT_TIME,
            kind="string",
            causality="parameter",
            choices=("step_start", "step_end"),
            description="Instant of the communication step that the inputs stand for",
        ),
        KEEP_FIRST_INPUTS,
        Variable(
            names.PROFILES_WANTED,
            kind="boolean",
            causality="parameter",
            description="Whether the profiles of rails and slabs are computed when they are read, "
            "20 ms each time; otherwise they stay 0",
        ),
        Variable(
            names.FIRST_OFFSET,
            causality="parameter",
            unit="m",
            start=6.0,
            description="Distance of the first point of the profiles of rails and slabs ahead of "
            "the leading wheelset; for plots",
        ),
        Variable(
            names.SPACING,
            causality="parameter",
            unit="m",
            start=0.25,
            minimum=0.001,
            description="Distance from point to point of the profiles, rearwards",
        ),
    ]


def _profiles() -> list[Variable]:
    """Return the shapes of rails and slabs along the vehicle; computed when read, if wanted."""
    return [
        Variable(
            name,
            causality="local",
            unit="m",
            description=f"{meaning}, at {names.FIRST_OFFSET} less (point - 1) times "
            f"{names.SPACING}; 0 unless {names.PROFILES_WANTED}",
        )
        for group, meaning in names.PROFILES.items()
        for name in names.profile_names(group)
    ]


def _outputs() -> list[Variable]:
    """Return the output variables."""
    contact = [
        Variable(
            f"wheelset[{i}].contact.{name}", causality="output", unit=unit, description=description
        )
        for i in names.NUMBERS
        for name, unit, description in terminals.CONTACT
    ]
    wheels = [
        Variable(
            f"wheelset[{i}].{side}.{name}", causality="output", unit=unit, description=description
        )
        for name, (unit, description) in names.WHEEL.items()
        for i in names.NUMBERS
        for side in names.SIDES
    ]
    heights = [
        Variable(
            f"wheelset[{i}].static_vertical_displacement",
            causality="output",
            unit="m",
            description="Displacement of the wheelset in static equilibrium at the start, "
            "downwards from the datum; constant during the run",
        )
        for i in names.NUMBERS
    ]
    window = [
        Variable(
            "window.start_position",
            causality="output",
            unit="m",
            description="Position of the window's rear end along the line",
        ),
        Variable(
            "window.slide_count",
            kind="integer",
            causality="output",
            description="Window shifts since the start",
        ),
        Variable(
            "window.slide_residual",
            causality="output",
            unit="m",
            description="Largest change of the rails' deflection by the last window shift",
        ),
    ]
    return contact + wheels + heights + window
