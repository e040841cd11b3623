"""The track as a component: parameters in, a pure step from state to state.

>>> model = TrackModel(TrackParameters())            # doctest: +SKIP
>>> state = model.initial_state(motion)              # static equilibrium
>>> state, outputs = model.step(state, motion, 1e-4) # one communication step
"""

import contextlib
import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble
from slab_track.contact import Steel, build_tables
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.tables import LATERAL_LIMIT, ROLL_LIMIT
from slab_track.equilibrium import (
    RailsAtRest,
    check_sinking,
    contact_at,
    level_contact,
    profile_equilibrium,
    rails_at_rest,
    unit_compliance,
    vertical_at_rest,
)
from slab_track.errors import TrackError
from slab_track.halves import half_size
from slab_track.interaction import APPLIED, PROFILES, VERTICAL, Interaction, Wheels, answer
from slab_track.irregularity import Irregularity
from slab_track.lateral import LateralTrack, assemble_lateral
from slab_track.lateral_step import lateral_constants
from slab_track.motion import extrapolate
from slab_track.parameters import WHEELSET_PLACES, TrackParameters
from slab_track.slide import SlideOperator, slide_operator
from slab_track.state import (
    MOTION_BEFORE,
    MOTION_NOW,
    POINT_TIME,
    PREVIOUS_TIME,
    RATES_SEEN,
    ROW,
    TIME,
    FieldState,
    StateLayout,
    TrackState,
    WheelState,
    begin_motion,
)
from slab_track.statics import StaticSolution
from slab_track.stepping import (
    GOOD,
    NEAR_THE_END,
    NOT_FINITE,
    SLIDE_DUE,
    Scratch,
    Settings,
    TrackOperator,
    WindowLimits,
    begin,
    finish,
    pack,
)
from slab_track.vertical import FreeStep, WheelCoupling, class_operator, rail_operator
from slab_track.window import END_MARGIN, near_the_end, place_window, slide_fields

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


class TrackOutputs(NamedTuple):
    """What the track answers; arrays of wheels have shape (wheelsets, 2), left first.

    Attributes
    ----------
    state
        The state that answers; nothing is computed before it is asked for.
    contact
        Contact forces and moments on the wheelsets, shape (wheelsets, 6), N and N.m.
    answers
        All of the following, (8, wheelsets, 2), as in :class:`TrackState`.
    normal_force, longitudinal_creep_force, lateral_creep_force
        Sums over the patches of a wheel, N.
    penetration, contact_angle
        Of the patch that carries most, m and rad.
    rail_deflection, rail_lateral, rail_roll
        Of the rail's axis vertically, of its head laterally (m), and its rotation (rad).
    """

    state: TrackState

    @property
    def contact(self) -> np.ndarray:
        """Contact forces and moments on the wheelsets, N and N.m, (wheelsets, 6)."""
        return self.state.contact

    @property
    def answers(self) -> np.ndarray:
        """All of the following, (8, wheelsets, 2), as in :class:`TrackState`."""
        return self.state.answers

    @property
    def normal_force(self) -> np.ndarray:
        """Normal force of each wheel, N, (wheelsets, 2); positive in compression."""
        return self.answers[0]

    @property
    def longitudinal_creep_force(self) -> np.ndarray:
        """Longitudinal creep force of each wheel, N, (wheelsets, 2)."""
        return self.answers[1]

    @property
    def lateral_creep_force(self) -> np.ndarray:
        """Lateral creep force of each wheel, N, (wheelsets, 2)."""
        return self.answers[2]

    @property
    def penetration(self) -> np.ndarray:
        """Penetration of the patch that carries most, m, (wheelsets, 2)."""
        return self.answers[3]

    @property
    def contact_angle(self) -> np.ndarray:
        """Contact angle of the patch that carries most, rad, (wheelsets, 2)."""
        return self.answers[4]

    @property
    def rail_deflection(self) -> np.ndarray:
        """Deflection of the rail's axis under each wheel, m, (wheelsets, 2)."""
        return self.answers[5]

    @property
    def rail_lateral(self) -> np.ndarray:
        """Lateral displacement of the rail's head under each wheel, m, (wheelsets, 2)."""
        return self.answers[6]

    @property
    def rail_roll(self) -> np.ndarray:
        """Rotation of the rail under each wheel, rad, (wheelsets, 2)."""
        return self.answers[7]


class TrackModel:
    """Two rails on slabs in a window that slides along with the wheelsets."""

    def __init__(self, parameters: TrackParameters) -> None:
        p = self.parameters = parameters
        self.linear: LinearTrack = assemble(p)
        self.lateral: LateralTrack = assemble_lateral(p)
        self.irregularity = Irregularity(p.irregularity)
        self.half_distance = 0.5 * p.contact.rolling_circle_distance
        self.contact = build_tables(
            p.contact,
            gauge=p.rail.gauge,
            gauge_measurement_depth=p.rail.gauge_measurement_depth,
            cant=p.rail.cant,
            rail_axis_depth=p.rail.axis_depth,
            steel=Steel(
                youngs_modulus=p.rail.youngs_modulus,
                poisson_ratio=p.rail.poisson_ratio,
            ),
        )
        self.interface = PROFILES if p.contact.model == "profiles" else VERTICAL
        if p.interface == "applied_force":
            self.interface = APPLIED
        self._lateral_motion = p.rail.motion == "full"
        self.layout = StateLayout(
            wheelsets=p.wheelset_count,
            waves=self.linear.rail.wave_number.size,
            fasteners=self.linear.fastener_count,
            slabs=self.linear.slab_count,
            slab_modes=[slab.omega_squared.size for slab in self.linear.slabs],
        )
        self._no_force = np.zeros((p.wheelset_count, 2, 3))
        self._operator = functools.lru_cache(maxsize=8)(self._make_operator)
        # Looked up at every step.
        self._longest_step = p.integration.maximum_step

    def _make_operator(self, duration: float) -> tuple[TrackOperator, int, float]:
        """Return operator, number and length (s) of the internal steps of a communication step."""
        steps = max(1, math.ceil(duration / self._longest_step - 1e-9))
        step, p = duration / steps, self.parameters
        waves, count = self.linear.rail.wave_number.size, p.wheelset_count
        half = half_size(self.linear.fastener_count)
        operator = pack(
            rail_operator(self.linear, step),
            class_operator(self.linear, step, SYMMETRIC),
            class_operator(self.linear, step, ANTISYMMETRIC),
            lateral_constants(self.lateral, step),
            self.contact,
            fastsim_grid(p.contact.fastsim_columns, p.contact.fastsim_strips),
            self.irregularity.data,
            Settings(
                interface=self.interface,
                moves_sideways=self._rails_move_sideways,
                hertz_constant=p.contact.hertz_constant_used,
                half_distance=self.half_distance,
                axis_depth=p.rail.axis_depth,
                step=step,
            ),
            self._limits,
            self.layout.starts,
            Scratch.empty(steps, count, waves, half),
            WheelCoupling.empty(count, half),
            FreeStep.empty(count, half),
            FreeStep.empty(count, half),
            Interaction.empty(count),
        )
        return operator, steps, step

    @property
    def _limits(self) -> WindowLimits:
        p = self.parameters
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
        p = self.parameters
        return slide_operator(
            self.linear.rail,
            length=p.window_length,
            shift=p.slide_length,
            sample_count=p.sample_count,
            solver=p.window.slide_solver,
            taper=p.window.rear_taper,
        )

    def prepare(self, state: TrackState) -> None:
        """Compute and compile now what the first step from ``state`` and the first slide would."""
        if self.parameters.moves:
            _ = self.slide
        with contextlib.suppress(TrackError):  # it comes again where it can be dealt with
            self.step(
                state,
                state.motion,
                self.parameters.integration.maximum_step,
                applied_force=self._no_force,
            )

    # -- start ---------------------------------------------------------------

    def default_positions(self) -> np.ndarray:
        """Positions of the article's wheelsets at ``initial_position``, m, shape (wheelsets,)."""
        places = np.array(WHEELSET_PLACES[: self.parameters.wheelset_count])
        return self.parameters.initial_position - places

    def initial_state(self, motion: np.ndarray, time: float = 0.0) -> TrackState:
        """Return static equilibrium under ``static_wheel_load`` at the given wheelsets.

        Parameters
        ----------
        motion
            Wheelset motion, shape (wheelsets, 11), m, rad, m/s and rad/s. Its vertical
            displacements do not enter the equilibrium; they only say where the wheelsets are
            when the run begins.
        time
            Of the state, s.

        Raises
        ------
        TrackError
            If the wheelsets do not fit into the window or stand beside the rails.
        """
        p, count = self.parameters, self.parameters.wheelset_count
        start = place_window(p, motion[:, 0])
        offsets = self._offsets(motion[None, :, 0])[0]
        lateral = self.lateral if self._rails_move_sideways else None

        places = motion[:, 0] - start
        vertical = vertical_at_rest(self.linear, places)

        def rest(force: np.ndarray) -> RailsAtRest:
            return rails_at_rest(self.linear, lateral, places, force, vertical)

        heights, force = np.zeros(count), np.zeros((count, 2, 3))
        if p.static_wheel_load > 0.0:
            heights, force = self._equilibrium(rest, motion, offsets)
        rails = rest(force)
        check_sinking(rails.motion, p.static_wheel_load)
        state = TrackState(self.layout, np.zeros(self.layout.size)).replace(
            time=time,
            symmetric=self._field(SYMMETRIC, rails.vertical[0]),
            antisymmetric=self._field(ANTISYMMETRIC, rails.vertical[1]),
            wheels=WheelState.empty(count)._replace(rail=rails.motion),
            fastener_force=np.stack([solution.fastener for solution in rails.vertical]),
            window_start=start,
            datum=float(np.mean(heights)),
            static_heights=heights - np.mean(heights),
            places=motion[:, 0] - start,
        )
        state.rails[:, 0] = rails.lateral
        return self.with_motion(state, motion)

    def _equilibrium(
        self, rest: Callable[[np.ndarray], RailsAtRest], motion: np.ndarray, offsets: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Heights of the wheelsets and forces on the rails under the static load."""
        load, count = self.parameters.static_wheel_load, motion.shape[0]
        if self.parameters.contact.model == "profiles":
            compliance = unit_compliance(lambda force: rest(force).motion, count)
            return profile_equilibrium(self.contact, compliance, motion, offsets, load)
        force = np.zeros((count, 2, 3))
        force[:, :, 1] = load
        level = rest(force).motion[:, :, 1] + offsets[:, :, 0]
        approach = self.parameters.contact.hertz_constant_used * load ** (2.0 / 3.0)
        return level.mean(axis=1) + approach, force

    def state_of(self, vector: np.ndarray) -> TrackState:
        """Return the state of a saved vector.

        Parameters
        ----------
        vector
            ``TrackState.vector`` of a state of this model, shape (n,), in SI units.

        Raises
        ------
        TrackError
            If it has another length than the states of this model.
        """
        if vector.shape != (self.layout.size,):
            raise TrackError(f"a state of this track has {self.layout.size} numbers")
        return TrackState(self.layout, vector)

    @property
    def _rails_move_sideways(self) -> bool:
        return self._lateral_motion and self.interface != VERTICAL

    def _touch(self, rows: np.ndarray, rails: np.ndarray, offsets: np.ndarray) -> WheelState:
        """Contact on given rails; heights count from first touch."""
        if self.parameters.contact.model == "vertical":
            constant = self.parameters.contact.hertz_constant_used
            return level_contact(rows, rails, offsets, self.half_distance, constant)
        return contact_at(self.contact, rows, rails, offsets)

    def _field(self, symmetry: int, static: StaticSolution) -> FieldState:
        rail = np.zeros((3, *static.rail.shape))
        slab = np.zeros((3, *static.slab.shape))
        rail[0], slab[0] = static.rail, static.slab
        compression = np.zeros((2, static.fastener.size))
        compression[0] = static.fastener / self.linear.stiffness
        return FieldState(rail, slab, compression)

    def with_motion(self, state: TrackState, motion: np.ndarray) -> TrackState:
        """Return an initial state with other heights of the wheelsets and their forces.

        Parameters
        ----------
        state
            From :meth:`initial_state`; not changed.
        motion
            Wheelset motion, shape (wheelsets, 11), m, rad, m/s and rad/s.
        """
        wheels = WheelState.empty(motion.shape[0])._replace(rail=state.wheels.rail.copy())
        if self.interface != APPLIED:
            rows = motion.copy()
            rows[:, 2] += state.datum
            wheels = self._touch(rows, state.wheels.rail, self._offsets(motion[None, :, 0])[0])
        changed = state.replace(wheels=wheels)
        begin_motion(changed, state.time, motion)
        self._answer(changed)
        return changed

    def _answer(self, state: TrackState) -> None:
        """Fill in what happens at the wheels of a new state."""
        answer(Wheels(*state.wheels), self.parameters.rail.axis_depth, state.answers)

    def _offsets(self, x: np.ndarray) -> np.ndarray:
        """Irregularity at positions (steps, wheelsets) on the line, (steps, wheelsets, 2, 2)."""
        offsets, _ = self.irregularity.evaluate(x.ravel())
        return offsets.reshape(*x.shape, 2, 2)

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
            Wheelset motion, shape (wheelsets, 11), m, rad, m/s and rad/s.
        dt
            Communication step, s.
        at_end
            True if ``motion`` stands for the end of the step, False for its start.
        applied_force
            With ``interface = "applied_force"``: force on the rail heads, lateral, vertical
            (N) and roll moment (N.m), shape (wheelsets, 2, 3).

        Raises
        ------
        TrackError
            If a wheel leaves the window or the rail, or the motion is not finite.
        """
        start = state.time
        operator, steps, step = self._operator(dt)
        applied = self._no_force
        if self.interface == APPLIED:
            applied = self._on_axis(applied_force)
        new, instant = np.empty(self.layout.size), start + dt if at_end else start
        found = begin(operator, state.vector, new, motion, instant, True, 0)
        if found == SLIDE_DUE:
            state = self._slide_along(state, self._path(new, steps, step))
            found = begin(operator, state.vector, new, motion, instant, False, 0)
        if found == GOOD:
            found = finish(operator, state.vector, new, applied, 0)
        for turn in range(1, steps if found == GOOD else 0):
            old = new.copy()
            begin(operator, old, new, motion, instant, False, turn)
            found = finish(operator, old, new, applied, turn)
            if found != GOOD:
                break
        if found != GOOD:
            raise TrackError(self._why(found, new, steps, step))
        new[TIME] = start + dt
        state = TrackState(self.layout, new)
        return state, TrackOutputs(state)

    def _path(self, vector: np.ndarray, steps: int, step: float) -> np.ndarray:
        """Motion at the end of each internal step, (steps, wheelsets, 11)."""
        view, time = self.layout.view, vector[[TIME, POINT_TIME, PREVIOUS_TIME]]
        points = view(vector, MOTION_NOW), view(vector, MOTION_BEFORE), view(vector, RATES_SEEN)
        path = np.empty((steps, *points[0].shape))
        for n in range(steps):
            tau = time[0] - time[1] + step * (n + 1)
            extrapolate(tau, time[1] - time[2], *points, path[n])
        return path

    def _slide_along(self, state: TrackState, path: np.ndarray) -> TrackState:
        """Slide the window until the wheels keep their margins at the end of a path."""
        target = place_window(self.parameters, path[-1, :, 0])
        if not target - state.window_start < self.parameters.window_length:
            raise TrackError(
                f"at t = {state.time:g} s the wheels jump to {path[-1, :, 0].max():g} m, beyond "
                f"the window ({state.window_start:g} m to "
                f"{state.window_start + self.parameters.window_length:g} m) in a single step; "
                "check longitudinal_position and longitudinal_velocity of the wheelsets"
            )
        while target > state.window_start + 0.5 * self.parameters.slide_length:
            state = self._slide_once(state)
        return state

    def _slide_once(self, state: TrackState) -> TrackState:
        changes, residual = slide_fields(self.linear, self.lateral, self.slide, state)
        return state.replace(
            **changes,
            window_start=state.window_start + self.parameters.slide_length,
            slide_count=state.slide_count + 1,
            slide_residual=residual,
        )

    def _why(self, found: int, new: np.ndarray, steps: int, step: float) -> str:
        """Say why a step was not made that has come as far as ``new``."""
        state = TrackState(self.layout, new)
        if found == NOT_FINITE:
            return f"a wheelset motion is not a finite number at t = {state.time:g} s"
        if found == NEAR_THE_END:
            x = self._path(new, steps, step)[:, :, 0]
            return near_the_end(self.parameters, state.window_start, state.time, x)
        rows, wheels = self.layout.view(new, ROW), state.wheels
        return f"at t = {state.time - step:g} s, {self._where(rows, wheels)}"

    def _where(self, rows: np.ndarray, wheels: WheelState) -> str:
        """Say what happened where, for the error after a failed internal step."""
        rail, offsets = wheels.rail, self._offsets(rows[None, :, 0])[0]
        head = rail[..., 0] + self.parameters.rail.axis_depth * rail[..., 2] + offsets[..., 1]
        shift = np.abs(rows[:, None, 1] - head) / LATERAL_LIMIT
        turn = np.abs(rows[:, None, 3] - rail[..., 2]) / ROLL_LIMIT
        far = np.maximum(shift, turn).max(axis=1)
        worst = int(np.argmax(far))
        x, y, _, roll = rows[worst, :4]
        return (
            f"wheelset {worst + 1} at {x:.3f} m (lateral displacement {y * 1e3:.2f} mm, roll "
            f"{roll * 1e3:.2f} mrad): {_NO_FORCE if far[worst] < _NEARLY else _DERAILED}"
        )

    def _on_axis(self, head: np.ndarray | None) -> np.ndarray:
        """Move forces from the rails' heads to their axes, (wheelsets, 2, 3)."""
        if head is None:
            raise TrackError("interface = applied_force needs the forces at the rail heads")
        axis = np.array(head, dtype=float)
        axis[:, :, 2] += self.parameters.rail.axis_depth * axis[:, :, 0]
        return axis

    def outputs(self, state: TrackState) -> TrackOutputs:
        """Return the contact forces on the wheelsets and what happens at the wheels."""
        return TrackOutputs(state)


__all__ = ["END_MARGIN", "TrackModel", "TrackOutputs", "TrackState"]
