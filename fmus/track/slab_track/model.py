"""The track as a component: parameters in, a pure step from state to state.

>>> model = TrackModel(TrackParameters())            # doctest: +SKIP
>>> state = model.initial_state(motion)              # static equilibrium
>>> state, outputs = model.step(state, motion, 1e-4) # one communication step
"""

import functools
from typing import NamedTuple

import numpy as np

from slab_track import statics
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble
from slab_track.errors import TrackError
from slab_track.motion import MOTION, MotionHistory
from slab_track.parameters import TrackParameters
from slab_track.slide import SlideOperator, slide_operator, slide_rail, slide_rows
from slab_track.stepping import (
    FieldState,
    StepOperator,
    advance,
    hertz_force,
    step_operator,
)

END_MARGIN = 3.0
"""Nearest that a wheel may come to an end of the window, m; there the hinge is felt."""


class TrackState(NamedTuple):
    """Everything that the track remembers.

    Attributes
    ----------
    time
        s.
    symmetric, antisymmetric
        Field coordinates.
    history
        Wheelset motion at the last communication points.
    normal_force, penetration, rail_deflection
        At the wheels, shape (wheelsets, 2), left first; N, m, m.
    fastener_force
        Shape (P, 2), N, compression positive.
    window_start
        Position of the window's rear end on the line, m.
    slide_count
        Slides since the start.
    slide_residual
        Largest deviation of the rails' deflection over the common part of the old
        and the new window at the last slide, m.
    datum
        Height of the wheels' lowest points at zero vertical displacement, m.
    internal_step
        Length of the last internal step, s.
    """

    time: float
    symmetric: FieldState
    antisymmetric: FieldState
    history: MotionHistory
    normal_force: np.ndarray
    penetration: np.ndarray
    rail_deflection: np.ndarray
    fastener_force: np.ndarray
    window_start: float
    slide_count: int
    slide_residual: float
    datum: float
    internal_step: float


class TrackOutputs(NamedTuple):
    """What the track answers.

    Attributes
    ----------
    contact
        Contact forces on the wheelsets, shape (wheelsets, 6), N and N.m.
    normal_force, penetration, rail_deflection
        At the wheels, shape (wheelsets, 2), left first.
    """

    contact: np.ndarray
    normal_force: np.ndarray
    penetration: np.ndarray
    rail_deflection: np.ndarray


class TrackModel:
    """Two rails on slabs in a window that slides along with the wheelsets."""

    def __init__(self, parameters: TrackParameters) -> None:
        self.parameters = parameters
        self.linear: LinearTrack = assemble(parameters)
        self.half_distance = 0.5 * parameters.contact.rolling_circle_distance
        self.hertz_constant = parameters.contact.hertz_constant_used
        self._operators = functools.lru_cache(maxsize=8)(self._make_operators)

    def _make_operators(self, step: float) -> tuple[StepOperator, StepOperator]:
        return (
            step_operator(self.linear, step, SYMMETRIC),
            step_operator(self.linear, step, ANTISYMMETRIC),
        )

    @functools.cached_property
    def slide(self) -> SlideOperator:
        """Operator of a slide by one pitch."""
        p = self.parameters
        return slide_operator(
            self.linear.rail,
            length=p.window_length,
            shift=p.pitch,
            sample_count=p.sample_count,
            solver=p.window.slide_solver,
        )

    def prepare(self) -> None:
        """Compute and compile now what the first step and the first slide would."""
        if self.parameters.window.method == "sliding":
            _ = self.slide
        motion = np.zeros((self.parameters.wheelset_count, len(MOTION)))
        motion[:, 0] = self.default_positions()
        state = self.initial_state(motion)
        no_force = np.zeros((motion.shape[0], 2))
        self.step(state, motion, self.parameters.integration.maximum_step, applied_force=no_force)

    # -- start ---------------------------------------------------------------

    def default_positions(self) -> np.ndarray:
        """Longitudinal positions of the article's vehicle at ``initial_position``, m."""
        offsets = np.array([0.0, 2.5, 17.8, 20.3])
        return self.parameters.initial_position - offsets[: self.parameters.wheelset_count]

    def place_window(self, positions: np.ndarray) -> float:
        """Return the window's start for wheelsets at ``positions`` (wheelsets,), m.

        Slabs lie at whole multiples of the pitch on the line. The wheels are as far
        from both ends as they can be at the worst instant between two slides; with
        ``moving_mass`` they start as far back as they may.
        """
        p = self.parameters
        rear, front = float(np.min(positions)), float(np.max(positions))
        spare = p.window_length - (front - rear) - p.pitch
        if spare < 2.0 * END_MARGIN:
            raise TrackError(
                f"the wheelsets stand {front - rear:g} m apart, but a window of "
                f"{p.window_length:g} m takes at most "
                f"{p.window_length - p.pitch - 2.0 * END_MARGIN:g} m; "
                "raise window.slab_count"
            )
        margin = 0.5 * spare if p.window.method == "sliding" else min(0.5 * spare, 20.0)
        return float(np.floor((rear - margin) / p.pitch) * p.pitch)

    def initial_state(self, motion: np.ndarray, time: float = 0.0) -> TrackState:
        """Return static equilibrium under ``static_wheel_load`` at the given wheelsets.

        ``motion`` has shape (wheelsets, 11); of it only the longitudinal positions
        enter the equilibrium. The forces returned belong to the heights in it.
        """
        p, count = self.parameters, self.parameters.wheelset_count
        start = self.place_window(motion[:, 0])
        local = motion[:, 0] - start
        load = np.full(count, np.sqrt(2.0) * p.static_wheel_load)
        static = statics.static_coordinates(self.linear, local, load, SYMMETRIC)
        state_s, state_a = self._rest(SYMMETRIC), self._rest(ANTISYMMETRIC)
        state_s.rail[0], state_s.slab[0] = static.rail, static.slab
        state_s.residual[:] = static.residual
        deflection = np.repeat(np.sqrt(0.5) * static.deflection[:, None], 2, axis=1)
        resting = deflection[:, 0] + self.hertz_constant * p.static_wheel_load ** (2.0 / 3.0)
        datum = float(np.mean(resting))
        state = TrackState(
            time=time,
            symmetric=state_s,
            antisymmetric=state_a,
            history=MotionHistory.begin(time, motion),
            normal_force=np.full((count, 2), p.static_wheel_load),
            penetration=np.zeros((count, 2)),
            rail_deflection=deflection,
            fastener_force=np.repeat(np.sqrt(0.5) * static.fastener[:, None], 2, axis=1),
            window_start=start,
            slide_count=0,
            slide_residual=0.0,
            datum=datum,
            internal_step=p.integration.maximum_step,
        )
        return self.with_motion(state, motion)

    def static_heights(self, state: TrackState) -> np.ndarray:
        """Return each wheelset's own equilibrium height above the datum, (wheelsets,), m."""
        rest = self.hertz_constant * self.parameters.static_wheel_load ** (2.0 / 3.0)
        return state.rail_deflection[:, 0] + rest - state.datum

    def with_motion(self, state: TrackState, motion: np.ndarray) -> TrackState:
        """Return an initial state with other heights of the wheelsets and their forces."""
        heights = self._wheel_heights(state.datum, motion[None, :, :5])[0]
        penetration = heights - state.rail_deflection
        force = np.array(
            [[hertz_force(d, self.hertz_constant) for d in row] for row in penetration]
        )
        if self.parameters.interface == "applied_force":
            force = np.zeros_like(force)
        return state._replace(
            history=MotionHistory.begin(state.time, motion),
            penetration=penetration,
            normal_force=force,
        )

    def _rest(self, symmetry: int) -> FieldState:
        track = self.linear
        modes = track.slabs[symmetry].omega_squared.size
        return FieldState(
            rail=np.zeros((3, 2, track.rail.wave_number.size)),
            slab=np.zeros((3, track.slab_count, modes)),
            residual=np.zeros((2, track.fastener_count)),
        )

    # -- running ---------------------------------------------------------------

    def step(
        self,
        state: TrackState,
        motion: np.ndarray,
        dt: float,
        *,
        at_end: bool = False,
        applied_force: np.ndarray | None = None,
    ) -> tuple[TrackState, TrackOutputs]:
        """Advance by one communication step.

        Parameters
        ----------
        state
            State at the start of the step; it is not changed.
        motion
            Wheelset motion, shape (wheelsets, 11).
        dt
            Communication step, s.
        at_end
            True if ``motion`` stands for the end of the step, False for its start.
        applied_force
            With ``interface = "applied_force"``: vertical forces on the rail heads,
            shape (wheelsets, 2), N.

        Raises
        ------
        TrackError
            If a wheel leaves the window or the motion is not finite.
        """
        if not np.all(np.isfinite(motion)):
            raise TrackError(f"a wheelset motion is not a finite number at t = {state.time:g} s")
        end = state.time + dt
        history = state.history.push(end if at_end else state.time, motion)
        substeps = max(1, int(np.ceil(dt / self.parameters.integration.maximum_step - 1e-9)))
        times = state.time + dt / substeps * np.arange(1, substeps + 1)
        path = history.positions(times)
        state = self._follow(state, path[:, :, 0])
        if self.parameters.interface == "applied_force":
            if applied_force is None:
                raise TrackError("interface = applied_force needs the forces at the rail heads")
            drive = np.repeat(applied_force[None], substeps, axis=0)
        else:
            drive = self._wheel_heights(state.datum, path)
        internal = dt / substeps
        symmetric = _copy(state.symmetric, internal / state.internal_step)
        antisymmetric = _copy(state.antisymmetric, internal / state.internal_step)
        force, penetration, deflection, fasteners = advance(
            *self._operators(internal),
            symmetric,
            antisymmetric,
            path[:, :, 0] - state.window_start,
            drive,
            state.normal_force,
            self.parameters.interface == "applied_force",
            self.hertz_constant,
            internal,
        )
        state = state._replace(
            time=end,
            internal_step=internal,
            symmetric=symmetric,
            antisymmetric=antisymmetric,
            history=history,
            normal_force=force,
            penetration=penetration,
            rail_deflection=deflection,
            fastener_force=fasteners,
        )
        return state, self.outputs(state)

    def outputs(self, state: TrackState) -> TrackOutputs:
        """Return the contact forces on the wheelsets and what happens at the wheels."""
        left, right = state.normal_force[:, 0], state.normal_force[:, 1]
        contact = np.zeros((left.size, 6))
        contact[:, 2] = -(left + right)
        contact[:, 3] = self.half_distance * (left - right)
        return TrackOutputs(contact, state.normal_force, state.penetration, state.rail_deflection)

    def _wheel_heights(self, datum: float, path: np.ndarray) -> np.ndarray:
        """Heights of the wheels' lowest points, (steps, wheelsets, 2), from (…, 5) positions."""
        vertical, roll = path[:, :, 2], path[:, :, 3]
        sides = np.array([-self.half_distance, self.half_distance])
        return datum + vertical[..., None] + roll[..., None] * sides

    def _follow(self, state: TrackState, x: np.ndarray) -> TrackState:
        """Slide the window until the wheels keep their margins; check that they do."""
        p = self.parameters
        if p.window.method == "sliding":
            target = self.place_window(x[-1])
            while target > state.window_start + 0.5 * p.pitch:
                state = self._slide_once(state)
        rear, front = float(x.min()), float(x.max())
        end = state.window_start + p.window_length
        if rear < state.window_start + END_MARGIN or front > end - END_MARGIN:
            wheel = front if front > end - END_MARGIN else rear
            raise TrackError(
                f"at t = {state.time:g} s a wheel at {wheel:g} m comes within {END_MARGIN:g} m of the ends of the window, "
                f"{state.window_start:g} m to {end:g} m (window.method = {p.window.method}); "
                "take window.method = sliding for a long run, or raise window.slab_count"
            )
        return state

    def _slide_once(self, state: TrackState) -> TrackState:
        old = state.symmetric.rail[0], state.antisymmetric.rail[0]
        symmetric = self._slide_field(state.symmetric)
        antisymmetric = self._slide_field(state.antisymmetric)
        return state._replace(
            symmetric=symmetric,
            antisymmetric=antisymmetric,
            fastener_force=slide_rows(state.fastener_force, self.linear.seat_count),
            window_start=state.window_start + self.parameters.pitch,
            slide_count=state.slide_count + 1,
            slide_residual=self._residual(old, (symmetric.rail[0], antisymmetric.rail[0])),
        )

    def _slide_field(self, field: FieldState) -> FieldState:
        rail = [slide_rail(self.linear.rail, self.slide, level) for level in field.rail]
        slab = [slide_rows(level, 1) for level in field.slab]
        residual = slide_rows(field.residual.T, self.linear.seat_count).T
        return FieldState(np.array(rail), np.array(slab), np.ascontiguousarray(residual))

    @functools.cached_property
    def _residual_shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Shapes at points of the common part, seen from the old and the new window."""
        p = self.parameters
        old = np.arange(p.pitch, p.window_length, 0.5 * p.fastener.spacing)
        return self.linear.wave_shapes(old), self.linear.wave_shapes(old - p.pitch)

    def _residual(self, old: tuple, new: tuple) -> float:
        shapes_old, shapes_new = self._residual_shapes
        weight = self.linear.rail.deflection
        jumps = [
            np.sum(weight * after, axis=0) @ shapes_new
            - np.sum(weight * before, axis=0) @ shapes_old
            for before, after in zip(old, new, strict=True)
        ]
        rails = np.sqrt(0.5) * np.array([jumps[0] - jumps[1], jumps[0] + jumps[1]])
        return float(np.max(np.abs(rails)))


def _copy(field: FieldState, step_ratio: float) -> FieldState:
    """Copy a field; the earlier residual is moved to the distance of the new internal step."""
    now, before = field.residual
    if step_ratio != 1.0:
        before = now + step_ratio * (before - now)
    return FieldState(field.rail.copy(), field.slab.copy(), np.array([now, before]))
