"""The track as a component: parameters in, a pure step from state to state.

>>> model = TrackModel(TrackParameters())            # doctest: +SKIP
>>> state = model.initial_state(motion)              # static equilibrium
>>> state, outputs = model.step(state, motion, 1e-4) # one communication step
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble
from slab_track.contact import Steel, build_tables
from slab_track.contact.tables import LATERAL_LIMIT, ROLL_LIMIT
from slab_track.contact.wheelset import NORMAL_FORCE
from slab_track.equilibrium import (
    contact_at,
    level_contact,
    profile_equilibrium,
    rails_at_rest,
    unit_compliance,
)
from slab_track.errors import TrackError
from slab_track.irregularity import Irregularity
from slab_track.lateral import LateralTrack, assemble_lateral, lateral_operator
from slab_track.motion import MOTION, MotionHistory, finite_reach
from slab_track.parameters import WHEELSET_PLACES, TrackParameters
from slab_track.slide import SlideOperator, slide_operator
from slab_track.stepping import (
    ANSWERS,
    APPLIED,
    PROFILES,
    VERTICAL,
    Fields,
    OperatorBox,
    TrackOperator,
    WheelState,
    advance,
    answer,
    box,
)
from slab_track.vertical import FieldState, step_operator
from slab_track.window import END_MARGIN, check_margins, place_window, slide_fields

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


class TrackState(NamedTuple):
    """Everything that the track remembers.

    Attributes
    ----------
    time
        s.
    symmetric, antisymmetric
        Vertical coordinates of both symmetry classes.
    rails
        Lateral and torsional coordinates, (2, 3, 3, N): rail, derivative, branch, wave number.
    history
        Wheelset motion at the last communication points.
    wheels
        Forces and rail motions at the wheels.
    fastener_force
        Vertical, (2, P), N, symmetric and antisymmetric class, compression positive.
    window_start
        Position of the window's rear end on the line, m.
    slide_count
        Slides since the start.
    slide_residual
        Largest deviation of the rails' vertical deflection over the common part of the old
        and the new window at the last slide, m.
    datum
        Height of the wheelsets above first touch at zero vertical displacement, m.
    static_heights
        Each wheelset's equilibrium height above the datum, (wheelsets,), m.
    places
        Places of the wheelsets in the window at the start, (wheelsets,), m.
    """

    time: float
    symmetric: FieldState
    antisymmetric: FieldState
    rails: np.ndarray
    history: MotionHistory
    wheels: WheelState
    fastener_force: np.ndarray
    window_start: float
    slide_count: int
    slide_residual: float
    datum: float
    static_heights: np.ndarray
    places: np.ndarray

    @property
    def normal_force(self) -> np.ndarray:
        """Normal force of each wheel, (wheelsets, 2), N, left first."""
        return self.wheels.forces[..., NORMAL_FORCE].sum(axis=2)

    @property
    def rail_deflection(self) -> np.ndarray:
        """Vertical displacement of the rails under the wheels, (wheelsets, 2), m."""
        return self.wheels.rail[:, :, 1]


class TrackOutputs(NamedTuple):
    """What the track answers; arrays of wheels have shape (wheelsets, 2), left first.

    Attributes
    ----------
    contact
        Contact forces and moments on the wheelsets, shape (wheelsets, 6), N and N.m.
    answers
        All of the following, (8, wheelsets, 2), as :func:`slab_track.stepping.answer` gives them.
    normal_force, longitudinal_creep_force, lateral_creep_force
        Sums over the patches of a wheel, N.
    penetration, contact_angle
        Of the patch that carries most, m and rad.
    rail_deflection, rail_lateral, rail_roll
        Of the rail's axis vertically, of its head laterally (m), and its rotation (rad).
    """

    contact: np.ndarray
    answers: np.ndarray

    normal_force = property(lambda self: self.answers[0])
    longitudinal_creep_force = property(lambda self: self.answers[1])
    lateral_creep_force = property(lambda self: self.answers[2])
    penetration = property(lambda self: self.answers[3])
    contact_angle = property(lambda self: self.answers[4])
    rail_deflection = property(lambda self: self.answers[5])
    rail_lateral = property(lambda self: self.answers[6])
    rail_roll = property(lambda self: self.answers[7])


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
        self._operator = functools.lru_cache(maxsize=8)(self._make_operator)
        # Looked up at every step.
        self._longest_step = p.integration.maximum_step
        self._moves, self._length = p.moves, p.window_length
        self._slide_middle = 0.5 * (p.window_length + p.slide_length) + p.window.vehicle_offset

    def _make_operator(self, step: float) -> OperatorBox:
        operator = TrackOperator(
            symmetric=step_operator(self.linear, step, SYMMETRIC),
            antisymmetric=step_operator(self.linear, step, ANTISYMMETRIC),
            lateral=lateral_operator(self.lateral, step),
            contact=self.contact,
            interface=self.interface,
            lateral_motion=self._lateral_motion,
            hertz_constant=self.parameters.contact.hertz_constant_used,
            irregularity=self.irregularity.data,
            half_distance=self.half_distance,
            axis_depth=self.parameters.rail.axis_depth,
            step=step,
        )
        return box(operator)

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

    def prepare(self) -> None:
        """Compute and compile now what the first step and the first slide would."""
        if self.parameters.moves:
            _ = self.slide
        motion = np.zeros((self.parameters.wheelset_count, len(MOTION)))
        motion[:, 0] = self.default_positions()
        state = self.initial_state(motion)
        motion[:, 2] = state.static_heights
        self.step(
            self.with_motion(state, motion),
            motion,
            self.parameters.integration.maximum_step,
            applied_force=np.zeros((motion.shape[0], 2, 3)),
        )

    # -- start ---------------------------------------------------------------

    def default_positions(self) -> np.ndarray:
        """Longitudinal positions of the article's vehicle at ``initial_position``, m."""
        places = np.array(WHEELSET_PLACES[: self.parameters.wheelset_count])
        return self.parameters.initial_position - places

    def initial_state(self, motion: np.ndarray, time: float = 0.0) -> TrackState:
        """Return static equilibrium under ``static_wheel_load`` at the given wheelsets.

        ``motion`` has shape (wheelsets, 11). Its vertical displacements do not enter
        the equilibrium; they only say where the wheelsets are when the run begins.

        Raises
        ------
        TrackError
            If the wheelsets do not fit into the window or stand beside the rails.
        """
        p, count = self.parameters, self.parameters.wheelset_count
        start = place_window(p, motion[:, 0])
        offsets = self._offsets(motion[None, :, 0])[0]
        lateral = self.lateral if self._rails_move_sideways else None

        def rest(force):
            return rails_at_rest(self.linear, lateral, motion[:, 0] - start, force)

        heights, force = np.zeros(count), np.zeros((count, 2, 3))
        if p.static_wheel_load > 0.0:
            heights, force = self._equilibrium(rest, motion, offsets)
        rails = rest(force)
        state = TrackState(
            time=time,
            symmetric=self._field(SYMMETRIC, rails.vertical[0]),
            antisymmetric=self._field(ANTISYMMETRIC, rails.vertical[1]),
            rails=np.zeros((2, 3, *rails.lateral.shape[1:])),
            history=MotionHistory.begin(time, motion),
            wheels=WheelState.empty(count)._replace(rail=rails.motion),
            fastener_force=np.stack([solution.fastener for solution in rails.vertical]),
            window_start=start,
            slide_count=0,
            slide_residual=0.0,
            datum=float(np.mean(heights)),
            static_heights=heights - np.mean(heights),
            places=motion[:, 0] - start,
        )
        state.rails[:, 0] = rails.lateral
        return self.with_motion(state, motion)

    def _equilibrium(self, rest, motion, offsets) -> tuple[np.ndarray, np.ndarray]:
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

    @property
    def _rails_move_sideways(self) -> bool:
        return self._lateral_motion and self.interface != VERTICAL

    def _touch(self, rows: np.ndarray, rails: np.ndarray, offsets: np.ndarray) -> WheelState:
        """Contact on given rails; heights count from first touch."""
        if self.parameters.contact.model == "vertical":
            constant = self.parameters.contact.hertz_constant_used
            return level_contact(rows, rails, offsets, self.half_distance, constant)
        return contact_at(self.contact, rows, rails, offsets)

    def _field(self, symmetry: int, static) -> FieldState:
        rail = np.zeros((3, *static.rail.shape))
        slab = np.zeros((3, *static.slab.shape))
        rail[0], slab[0] = static.rail, static.slab
        return FieldState(rail, slab, np.array([static.residual, np.zeros_like(static.residual)]))

    def with_motion(self, state: TrackState, motion: np.ndarray) -> TrackState:
        """Return an initial state with other heights of the wheelsets and their forces."""
        wheels = WheelState.empty(motion.shape[0])._replace(rail=state.wheels.rail.copy())
        if self.interface != APPLIED:
            rows = motion.copy()
            rows[:, 2] += state.datum
            wheels = self._touch(rows, state.wheels.rail, self._offsets(motion[None, :, 0])[0])
        return state._replace(history=MotionHistory.begin(state.time, motion), wheels=wheels)

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
            Wheelset motion, shape (wheelsets, 11).
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
        end = state.time + dt
        history = state.history.push(end if at_end else state.time, motion)
        substeps = max(1, math.ceil(dt / self._longest_step - 1e-9))
        internal = dt / substeps
        path = history.path(state.time + internal * np.arange(1, substeps + 1))
        state = self._follow(state, history.motion, path)
        old = Fields(state.symmetric, state.antisymmetric, state.rails)
        new = Fields(_room(old.symmetric), _room(old.antisymmetric), np.empty_like(old.rails))
        wheels = WheelState(*(array.copy() for array in state.wheels))
        fasteners = np.empty_like(state.fastener_force)
        answers = np.empty((ANSWERS, motion.shape[0], 2))
        made = advance(
            self._operator(internal),
            old,
            new,
            self._in_window(state, path[:, :, 0]),
            state.datum,
            path,
            self._on_axis(applied_force, motion.shape[0]),
            wheels,
            fasteners,
            answers,
        )
        if made < substeps:
            raise TrackError(
                f"at t = {state.time + made * internal:g} s, {self._where(path[made], wheels)}"
            )
        state = TrackState(
            time=end,
            symmetric=new.symmetric,
            antisymmetric=new.antisymmetric,
            rails=new.rails,
            history=history,
            wheels=wheels,
            fastener_force=fasteners,
            window_start=state.window_start,
            slide_count=state.slide_count,
            slide_residual=state.slide_residual,
            datum=state.datum,
            static_heights=state.static_heights,
            places=state.places,
        )
        return state, TrackOutputs(wheels.wheelset, answers)

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

    def _on_axis(self, head: np.ndarray | None, count: int) -> np.ndarray:
        """Move forces from the rails' heads to their axes, (wheelsets, 2, 3)."""
        if self.interface != APPLIED:
            return np.zeros((count, 2, 3))
        if head is None:
            raise TrackError("interface = applied_force needs the forces at the rail heads")
        axis = np.array(head, dtype=float)
        axis[:, :, 2] += self.parameters.rail.axis_depth * axis[:, :, 0]
        return axis

    def outputs(self, state: TrackState) -> TrackOutputs:
        """Return the contact forces on the wheelsets and what happens at the wheels."""
        answers = np.empty((ANSWERS, state.wheels.rail.shape[0], 2))
        answer(state.wheels, self.parameters.rail.axis_depth, answers)
        return TrackOutputs(state.wheels.wheelset, answers)

    def _in_window(self, state: TrackState, x: np.ndarray) -> np.ndarray:
        """Return where wheelsets at ``x`` (steps, wheelsets) on the line stand in the window, m."""
        if self.parameters.window.method == "moving_irregularity":
            return np.ascontiguousarray(np.broadcast_to(state.places, x.shape))
        return x - state.window_start

    def _follow(self, state: TrackState, motion: np.ndarray, path: np.ndarray) -> TrackState:
        """Slide the window until the wheels keep their margins; check that they do."""
        p, start, reach = self.parameters, state.window_start, np.empty(4)
        if not finite_reach(motion, path, reach):
            raise TrackError(f"a wheelset motion is not a finite number at t = {state.time:g} s")
        rear, front, rear_end, front_end = reach.tolist()
        # Half a millimetre early: then place_window decides.
        if self._moves and 0.5 * (rear_end + front_end) > start + self._slide_middle - 5e-4:
            target = place_window(p, path[-1, :, 0])
            while target > state.window_start + 0.5 * p.slide_length:
                state = self._slide_once(state)
            start = state.window_start
        if p.window.method == "moving_irregularity":
            return state
        if rear < start + END_MARGIN or front > start + self._length - END_MARGIN:
            check_margins(p, start, state.time, path[:, :, 0])
        return state

    def _slide_once(self, state: TrackState) -> TrackState:
        changes, residual = slide_fields(self.linear, self.lateral, self.slide, state)
        return state._replace(
            **changes,
            window_start=state.window_start + self.parameters.slide_length,
            slide_count=state.slide_count + 1,
            slide_residual=residual,
        )


def _room(field: FieldState) -> FieldState:
    return FieldState(*(np.empty_like(array) for array in field))


__all__ = ["END_MARGIN", "TrackModel", "TrackOutputs", "TrackState"]
