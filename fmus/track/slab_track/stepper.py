"""Communication steps of a track: constants by step size, slides, and why a step failed."""

import functools
import math

import numpy as np
from rail_quantities.uncounted import Reference

from slab_track.alignment import aligned
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.tables import LATERAL_LIMIT, ROLL_LIMIT, ContactTables
from slab_track.errors import TrackError
from slab_track.halves import half_size
from slab_track.interaction import APPLIED, VERTICAL, Interaction
from slab_track.irregularity import Irregularity
from slab_track.lateral import LateralTrack
from slab_track.lateral_step import lateral_constants
from slab_track.motion import DEEPEST, extrapolate
from slab_track.parameters import TrackParameters
from slab_track.slide import SlideOperator, slide_operator
from slab_track.sliding import WindowSlide
from slab_track.state import (
    MOTION_BEFORE,
    MOTION_NOW,
    POINT_TIME,
    PREVIOUS_TIME,
    RATES_SEEN,
    ROW,
    TIME,
    StateLayout,
    TrackState,
    WheelState,
)
from slab_track.stepping import (
    GOOD,
    JUMPS,
    NEAR_THE_END,
    NOT_FINITE,
    SLIDE_DUE,
    TOO_DEEP,
    Scratch,
    Settings,
    TrackOperator,
    WindowLimits,
    advance,
)
from slab_track.vertical import FreeStep, WheelCoupling, class_operator, rail_operator
from slab_track.window import END_MARGIN, near_the_end, place_window

_MOST_STEPS = 10_000
"""Internal steps in a communication step: the way in all of them is kept."""

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
        self._no_force = np.zeros((parameters.wheelset_count, 2, 3))
        self.operator = functools.lru_cache(maxsize=8)(self._make_operator)

    @property
    def moves_sideways(self) -> bool:
        """Whether the rails move laterally and in roll."""
        return self._p.rail.motion == "full" and self._interface != VERTICAL

    def _make_operator(self, duration: float) -> tuple[Reference, int, float]:
        """Return operator, number and length (s) of the internal steps of a communication step."""
        p = self._p
        if not 0.0 < duration <= _MOST_STEPS * p.integration.maximum_step:
            raise TrackError(
                f"step size {duration!r} s: must be positive and finite, and at most "
                f"{_MOST_STEPS * p.integration.maximum_step:g} s, {_MOST_STEPS} internal steps"
            )
        steps = max(1, math.ceil(duration / p.integration.maximum_step - 1e-9))
        step = duration / steps
        waves, count = self._linear.rail.wave_number.size, p.wheelset_count
        half = half_size(self._linear.fastener_count)
        modes = self._linear.slab_count * max(s.omega_squared.size for s in self._linear.slabs)
        changing = self._irregularity.data  # keeps blocks that it computes when it needs them
        parts = TrackOperator(
            rail=rail_operator(self._linear, step),
            symmetric=class_operator(self._linear, step, SYMMETRIC),
            antisymmetric=class_operator(self._linear, step, ANTISYMMETRIC),
            lateral=lateral_constants(self._lateral, step),
            contact=self._contact,
            grid=fastsim_grid(p.contact.fastsim_columns, p.contact.fastsim_strips),
            irregularity=changing,
            settings=Settings(
                interface=self._interface,
                moves_sideways=self.moves_sideways,
                hertz_constant=p.contact.hertz_constant_used,
                half_distance=0.5 * p.contact.rolling_circle_distance,
                axis_depth=p.rail.axis_depth,
                step=step,
            ),
            limits=self._limits,
            starts=self._layout.starts,
            scratch=Scratch.empty(steps, count, waves, self._linear.fastener_count, modes),
            coupling=WheelCoupling.empty(count, half),
            free_s=FreeStep.empty(count, half),
            free_a=FreeStep.empty(count, half),
            at=Interaction.empty(count),
        )
        placed = (part if part is changing else aligned(part) for part in parts)
        return Reference(TrackOperator._make(placed)), steps, step

    @property
    def _limits(self) -> WindowLimits:
        p = self._p
        standing = p.window.method == "moving_irregularity"
        middle = 0.5 * (p.window_length + p.slide_length) + p.window.vehicle_offset
        return WindowLimits(
            slides_at=middle if p.moves else math.inf,
            margin=-math.inf if standing else END_MARGIN,
            length=p.window_length,
            standing=standing,
        )

    @functools.cached_property
    def slide(self) -> SlideOperator:
        """Operator of a slide."""
        p = self._p
        return slide_operator(
            self._linear.rail,
            length=p.window_length,
            shift=p.slide_length,
            sample_count=p.sample_count,
            solver=p.window.slide_solver,
            taper=p.window.rear_taper,
        )

    def step_into(
        self,
        old: np.ndarray,
        new: np.ndarray,
        motion: np.ndarray,
        dt: float,
        *,
        at_end: bool = False,
        applied_force: np.ndarray | None = None,
    ) -> None:
        """Advance by one communication step, from one vector to another.

        Parameters
        ----------
        old
            :attr:`TrackState.vector` at the start of the step; it is not changed.
        new
            Receives that at the end; not the memory of ``old``. After an error it is of no use.
        motion, dt, at_end, applied_force
            As in :meth:`slab_track.model.TrackModel.step`.

        Raises
        ------
        TrackError
            As there.
        """
        operator, steps, step = self.operator(dt)
        applied = self._no_force
        if self._interface == APPLIED:
            applied = self.on_axis(applied_force)
        start = float(old[TIME])
        instant = start + dt if at_end else start
        found = advance(operator, old, new, motion, instant, True, applied, 0)
        if found == SLIDE_DUE:
            old = self._slide_along(old, self.path(new, steps, step))
            found = advance(operator, old, new, motion, instant, False, applied, 0)
        turn = 1
        while found == GOOD and turn < steps:
            found = advance(operator, new.copy(), new, motion, instant, False, applied, turn)
            turn += 1
        if found != GOOD:
            raise TrackError(self._why(found, old, new, steps, step))
        new[TIME] = start + dt

    def path(self, vector: np.ndarray, steps: int, step: float) -> np.ndarray:
        """Return the motion at the end of each internal step, (steps, wheelsets, 11).

        ``vector`` is of a state, ``step`` in s.
        """
        view, time = self._layout.view, vector[[TIME, POINT_TIME, PREVIOUS_TIME]]
        points = view(vector, MOTION_NOW), view(vector, MOTION_BEFORE), view(vector, RATES_SEEN)
        path = np.empty((steps, *points[0].shape))
        for n in range(steps):
            tau = time[0] - time[1] + step * (n + 1)
            extrapolate(tau, time[1] - time[2], *points, path[n])
        return path

    def _slide_along(self, vector: np.ndarray, path: np.ndarray) -> np.ndarray:
        """Slide the window until the wheels keep their margins at the end of a path."""
        state = TrackState(self._layout, vector)
        target = place_window(self._p, path[-1, :, 0])
        if not target - state.window_start < self._p.window_length:
            raise TrackError(
                f"at t = {state.time:g} s the wheels jump to {path[-1, :, 0].max():g} m, beyond "
                f"the window ({state.window_start:g} m to "
                f"{state.window_start + self._p.window_length:g} m) in a single step; "
                "check longitudinal_position and longitudinal_velocity of the wheelsets"
            )
        while target > state.window_start + 0.5 * self._p.slide_length:
            state = self.slide_once(state)
        return state.vector

    @functools.cached_property
    def slide_once(self) -> WindowSlide:
        """Makes the state after a slide of the window."""
        return WindowSlide(self._linear, self._lateral, self.slide, self._layout)

    def _why(self, found: int, old: np.ndarray, new: np.ndarray, steps: int, step: float) -> str:
        """Say why a step from ``old`` was not made that has come as far as ``new``."""
        state = TrackState(self._layout, new)
        if found == NOT_FINITE:
            return f"a wheelset motion is not a finite number at t = {state.time:g} s"
        if found == TOO_DEEP:
            heights = state.motion[:, 2]
            return (
                f"at t = {state.time:g} s wheelset {int(np.argmax(heights)) + 1} is "
                f"{heights.max():g} m below where it rests, more than {DEEPEST:g} m, inside the "
                "rail: its vertical_displacement has diverged"
            )
        if found == JUMPS:
            x, speed = state.motion[:, [0, 5]].mean(axis=0)
            way = x - TrackState(self._layout, old).motion[:, 0].mean()
            return (
                f"at t = {state.time:g} s the wheelsets are at {x:g} m in the mean, {way:g} m "
                f"from where they were {new[POINT_TIME] - new[PREVIOUS_TIME]:g} s before, but run "
                f"at {speed:g} m/s: longitudinal_position jumps"
            )
        if found == NEAR_THE_END:
            x = self.path(new, steps, step)[:, :, 0]
            return near_the_end(self._p, state.window_start, state.time, x)
        rows, wheels = self._layout.view(new, ROW), state.wheels
        return f"at t = {state.time - step:g} s, {self._where(rows, wheels)}"

    def _where(self, rows: np.ndarray, wheels: WheelState) -> str:
        """Say what happened where, for the error after a failed internal step."""
        rail, offsets = wheels.rail, self._irregularity.evaluate(rows[:, 0])[0]
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
        if head is None:
            raise TrackError("interface = applied_force needs the forces at the rail heads")
        axis = np.array(head, dtype=float, order="C")
        axis[:, :, 2] += self._p.rail.axis_depth * axis[:, :, 0]
        return axis
