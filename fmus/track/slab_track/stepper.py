"""Communication steps of a track: constants by step size, and why a step failed."""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.interaction import APPLIED, VERTICAL, Interaction
from slab_track.contact.tables import LATERAL_LIMIT, ROLL_LIMIT, ContactTables
from slab_track.contact.wheelset import ContactWork
from slab_track.errors import TrackError
from slab_track.irregularity import Irregularity
from slab_track.kernels.motion import COLUMNS, DEEPEST, extrapolate
from slab_track.kernels.state import POINT_TIME, PREVIOUS_TIME, StateArrays
from slab_track.kernels.step import (
    BEYOND_WINDOW,
    GOOD,
    JUMPS,
    NEAR_THE_END,
    NOT_FINITE,
    SHIFT_DUE,
    TOO_DEEP,
    Settings,
    StepConstants,
    StepWork,
    WheelsWork,
    step,
)
from slab_track.lateral import LateralTrack
from slab_track.operators import (
    lateral_constants,
    lateral_work,
    shift_constants,
    shifts_by_samples,
    vertical_constants,
    vertical_work,
)
from slab_track.parameters import TrackParameters
from slab_track.slide import SlideOperator, slide_operator
from slab_track.sliding import WindowSlide
from slab_track.state import StateLayout, TrackState
from slab_track.window import END_MARGIN, near_the_end, place_window

_MOST_STEPS = 10_000
"""Internal steps in a communication step: the wheels' positions in all of them are looked at."""

_DERAILED = (
    f"a wheel left its rail: its lateral displacement or roll is beyond {LATERAL_LIMIT * 1e3:g} mm "
    f"or {ROLL_LIMIT * 1e3:g} mrad from the rail's own (derailment)"
)
_NO_FORCE = (
    "the contact forces were not found; reduce integration.maximum_step or the communication "
    "step, and check that the wheelset motion is smooth"
)
_NEARLY = 0.8
"""Part of the contact tables' limits at which a failed step counts as a derailment."""


class Stepper:
    """Makes the communication steps of a track.

    Parameters
    ----------
    parameters
        Of the track.
    linear, lateral
        Its vertical, and its lateral and torsional motion.
    contact, irregularity
        Tables of the contact, and what the wheels roll over.
    layout
        Of the states.
    interface
        APPLIED, VERTICAL or PROFILES.
    """

    def __init__(
        self,
        parameters: TrackParameters,
        *,
        linear: LinearTrack,
        lateral: LateralTrack,
        contact: ContactTables,
        irregularity: Irregularity,
        layout: StateLayout,
        interface: int,
    ) -> None:
        self._p, self._linear, self._lateral = parameters, linear, lateral
        self._contact, self._irregularity = contact, irregularity
        self._layout, self._interface = layout, interface
        self.constants = functools.lru_cache(maxsize=8)(self._make_constants)

    @property
    def moves_sideways(self) -> bool:
        """Whether the rails move laterally and in roll."""
        return self._p.rail.motion == "full" and self._interface != VERTICAL

    def _make_constants(self, duration: float) -> StepConstants:
        """Return the constants of a communication step of ``duration`` s."""
        p = self._p
        if not 0.0 < duration <= _MOST_STEPS * p.integration.maximum_step:
            raise TrackError(
                f"step size {duration!r} s: must be positive and finite, and at most "
                f"{_MOST_STEPS * p.integration.maximum_step:g} s, {_MOST_STEPS} internal steps"
            )
        count = max(1, math.ceil(duration / p.integration.maximum_step - 1e-9))
        internal = duration / count
        return StepConstants(
            vertical=vertical_constants(self._linear, internal),
            lateral=lateral_constants(self._lateral, internal),
            contact=self._contact,
            grid=fastsim_grid(p.contact.fastsim_columns, p.contact.fastsim_strips),
            irregularity=self._irregularity.data,
            shift=shift_constants(p, self._linear, self._lateral, self.slide),
            settings=self._settings,
            step=internal,
            count=count,
        )

    @functools.cached_property
    def _settings(self) -> Settings:
        p = self._p
        is_standing = p.window.method == "moving_irregularity"
        middle = 0.5 * (p.window_length + p.slide_length) + p.window.vehicle_offset
        return Settings(
            interface=self._interface,
            moves_sideways=self.moves_sideways,
            is_standing=is_standing,
            shifts_here=shifts_by_samples(self.slide),
            hertz_constant=p.contact.hertz_constant_used,
            half_distance=0.5 * p.contact.rolling_circle_distance,
            axis_depth=p.rail.axis_depth,
            shifts_at=middle if p.moves else math.inf,
            end_margin=-math.inf if is_standing else END_MARGIN,
            length=p.window_length,
            shift=p.slide_length,
        )

    def work(self, constants: StepConstants) -> StepWork:
        """Return memory for steps with these constants."""
        w, waves = self._p.wheelset_count, constants.vertical.wave_number.size
        return StepWork(
            vertical=vertical_work(constants.vertical, w),
            lateral=lateral_work(constants.lateral, w),
            contact=ContactWork.of(w),
            at=Interaction.of(w),
            wheels=WheelsWork(
                positions=np.zeros(w),
                in_window=np.zeros(w),
                offsets=np.zeros((w, 2, 2)),
                slopes=np.zeros((w, 2, 2)),
                shapes=np.zeros((w, waves)),
                row=np.zeros((w, COLUMNS)),
            ),
        )

    @functools.cached_property
    def slide(self) -> SlideOperator:
        """Operator of a shift of the window."""
        p = self._p
        return slide_operator(
            self._linear.rail,
            length=p.window_length,
            shift=p.slide_length,
            sample_count=p.sample_count,
            solver=p.window.slide_solver,
            taper=p.window.rear_taper,
        )

    @functools.cached_property
    def slide_once(self) -> WindowSlide:
        """Makes the state after a shift of the window."""
        return WindowSlide(self._linear, self._lateral, self.slide, self._layout)

    def march(self, state: TrackState) -> "March":
        """Return what steps on from a state."""
        return March(self, self._layout, state.vector)

    def shifted(self, vector: np.ndarray, arrays: StateArrays, duration: float) -> np.ndarray:
        """Return the vector of a state whose window follows the wheels, by :meth:`slide_once`.

        ``arrays`` is how far a step of ``duration`` s came for which a shift was due.
        """
        state = TrackState(self._layout, vector)
        rows = self.path(arrays, 1, duration)
        target = place_window(self._p, rows[-1, :, 0])
        if not target - state.window_start < self._p.window_length:
            raise TrackError(self.why(BEYOND_WINDOW, arrays, 1, duration))
        while target > state.window_start + 0.5 * self._p.slide_length:
            state = self.slide_once(state)
        return state.vector

    def path(self, arrays: StateArrays, steps: int, duration: float) -> np.ndarray:
        """Return the motion at the end of each of ``steps`` in ``duration`` s, (steps, w, 11)."""
        head = arrays.head
        path = np.empty((steps, *arrays.motion_now.shape))
        for n in range(steps):
            tau = head[0] - head[POINT_TIME] + duration * (n + 1) / steps
            extrapolate(
                tau, head[POINT_TIME] - head[PREVIOUS_TIME], arrays.motion_now,
                arrays.motion_before, arrays.rates_seen, path[n],
            )  # fmt: skip
        return path

    def why(self, found: int, arrays: StateArrays, count: int, duration: float) -> str:
        """Say why a step of ``duration`` s in ``count`` internal ones came no farther."""
        time, start = float(arrays.head[0]), float(arrays.head[3])
        if found == NOT_FINITE:
            return f"a wheelset motion is not a finite number at t = {time:g} s"
        if found == TOO_DEEP:
            heights = arrays.motion_now[:, 2]
            return (
                f"at t = {time:g} s wheelset {int(np.argmax(heights)) + 1} is "
                f"{heights.max():g} m below where it rests, more than {DEEPEST:g} m, inside the "
                "rail: its vertical_displacement has diverged"
            )
        if found == JUMPS:
            x, speed = arrays.motion_now[:, [0, 5]].mean(axis=0)
            distance = x - arrays.motion_before[:, 0].mean()
            elapsed = arrays.head[POINT_TIME] - arrays.head[PREVIOUS_TIME]
            return (
                f"at t = {time:g} s the wheelsets are at {x:g} m in the mean, {distance:g} m "
                f"from where they were {elapsed:g} s before, but run "
                f"at {speed:g} m/s: longitudinal_position jumps"
            )
        if found == BEYOND_WINDOW:
            front = self.path(arrays, 1, duration)[-1, :, 0].max()
            return (
                f"at t = {time:g} s the wheels jump to {front:g} m, beyond "
                f"the window ({start:g} m to {start + self._p.window_length:g} m) in a single "
                "step; check longitudinal_position and longitudinal_velocity of the wheelsets"
            )
        if found == NEAR_THE_END:
            x = self.path(arrays, count, duration)[:, :, 0]
            return near_the_end(self._p, start, time, x)
        return f"at t = {time - duration / count:g} s, {self._where(arrays)}"

    def _where(self, arrays: StateArrays) -> str:
        """Say what happened where, for the error after a failed internal step."""
        rows, rail = arrays.row, arrays.wheels.rail
        offsets = self._irregularity.evaluate(rows[:, 0])[0]
        head = rail[..., 0] + self._p.rail.axis_depth * rail[..., 2] + offsets[..., 1]
        shift = np.abs(rows[:, None, 1] - head) / LATERAL_LIMIT
        turn = np.abs(rows[:, None, 3] - rail[..., 2]) / ROLL_LIMIT
        far = np.maximum(shift, turn).max(axis=1)
        worst = int(np.argmax(far))
        x, y, _, roll = rows[worst, :4]
        return (
            f"wheelset {worst + 1} at {x:.3f} m (lateral displacement {y * 1e3:.2f} mm, roll "
            f"{roll * 1e3:.2f} mrad): {_DERAILED if far[worst] >= _NEARLY else _NO_FORCE}"
        )

    def on_axis(self, head: np.ndarray | None) -> np.ndarray:
        """Move forces from the rails' heads to their axes, (wheelsets, 2, 3)."""
        if self._interface != APPLIED:
            return np.zeros((self._p.wheelset_count, 2, 3))
        if head is None:
            raise TrackError("interface = applied_force needs the forces at the rail heads")
        axis = np.array(head, dtype=float, order="C")
        axis[:, :, 2] += self._p.rail.axis_depth * axis[:, :, 0]
        return axis


class March:
    """A track that steps on: two states, in turn the one at the start and the one at the end.

    Parameters
    ----------
    stepper
        Whose constants it takes.
    layout
        Of the states.
    vector
        State to start from; it is copied.

    Attributes
    ----------
    vector
        Present state; read it between steps, and copy what is to stay.
    """

    def __init__(self, stepper: Stepper, layout: StateLayout, vector: np.ndarray) -> None:
        self._stepper, self._layout = stepper, layout
        self._vectors = vector.copy(), np.zeros(vector.size)
        self._arrays = tuple(layout.arrays(of) for of in self._vectors)
        count = self._arrays[0].motion_now.shape[0]
        self._motion, self._timing = np.zeros((count, COLUMNS)), np.zeros(2)
        self._applied = np.zeros((count, 2, 3))
        self._now, self._duration = 0, math.nan
        self._constants: StepConstants | None = None
        self._calls: list[Callable[[], int]] = []
        self._shifted: list[Callable[[], int]] = []

    @property
    def vector(self) -> np.ndarray:
        """Present state."""
        return self._vectors[self._now]

    def restart(self, vector: np.ndarray) -> None:
        """Go on from another state; it is copied."""
        self.vector[:] = vector

    def step(
        self,
        motion: np.ndarray,
        duration: float,
        *,
        at_end: bool = False,
        applied_force: np.ndarray | None = None,
    ) -> None:
        """Advance by one communication step; as :meth:`slab_track.model.TrackModel.step`."""
        if duration != self._duration:
            self._bind(duration)
        start = self._vectors[self._now][0]
        end = start + duration
        self._motion[:] = motion
        self._timing[0], self._timing[1] = end if at_end else start, end
        if applied_force is not None:
            self._applied[:] = self._stepper.on_axis(applied_force)
        found = self._calls[self._now]()
        if found == SHIFT_DUE:
            new = self._arrays[1 - self._now]
            self.vector[:] = self._stepper.shifted(self.vector, new, duration)
            found = self._shifted[self._now]()
        if found != GOOD:
            count = self._constants.count if self._constants else 1
            raise TrackError(self._stepper.why(found, self._arrays[1 - self._now], count, duration))
        self._now = 1 - self._now

    def _bind(self, duration: float) -> None:
        """Prepare steps of ``duration`` s, in both directions between the states."""
        constants = self._stepper.constants(duration)
        work = self._stepper.work(constants)

        def bound(first: int, is_shifted: bool) -> Any:
            now, new = self._arrays[first], self._arrays[1 - first]
            return step.bind(
                *constants, *work, now, new, self._motion, self._timing, self._applied, is_shifted
            )

        self._constants, self._duration = constants, duration
        self._calls = [bound(0, False), bound(1, False)]
        self._shifted = [bound(0, True), bound(1, True)]
