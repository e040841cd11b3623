"""The track as a component: parameters in, a pure step from state to state.

>>> model = TrackModel(TrackParameters())            # doctest: +SKIP
>>> state = model.initial_state(motion)              # static equilibrium
>>> state, outputs = model.step(state, motion, 1e-4) # one communication step
"""

import threading
from collections.abc import Callable

import numpy as np

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble
from slab_track.contact import Steel, build_tables
from slab_track.contact.interaction import APPLIED, PROFILES, VERTICAL, Wheels, wheel_outputs
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
from slab_track.irregularity import Irregularity
from slab_track.lateral import LateralTrack, assemble_lateral
from slab_track.outputs import TrackOutputs
from slab_track.parameters import WHEELSET_PLACES, TrackParameters
from slab_track.slide import SlideOperator
from slab_track.state import (
    FieldState,
    StateLayout,
    TrackState,
    begin_motion,
    no_wheel_forces,
)
from slab_track.statics import StaticSolution
from slab_track.stepper import Stepper
from slab_track.window import END_MARGIN, place_window


class TrackModel:
    """Two rails on slabs in a window that moves along with the wheelsets."""

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
        self.layout = StateLayout(
            wheelsets=p.wheelset_count,
            waves=self.linear.rail.wave_number.size,
            fasteners=self.linear.fastener_count,
            slabs=self.linear.slab_count,
            slab_modes=[slab.omega_squared.size for slab in self.linear.slabs],
        )
        self._of_thread = threading.local()
        self.stepper = Stepper(
            p,
            linear=self.linear,
            lateral=self.lateral,
            contact=self.contact,
            irregularity=self.irregularity,
            layout=self.layout,
            interface=self.interface,
        )

    @property
    def slide(self) -> SlideOperator:
        """Operator of a slide."""
        return self.stepper.slide

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
        offsets = self.irregularity.evaluate(motion[:, 0])[0]
        lateral = self.lateral if self.stepper.moves_sideways else None

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
            wheels=no_wheel_forces(count)._replace(rail=rails.motion),
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

    def _touch(self, rows: np.ndarray, rails: np.ndarray, offsets: np.ndarray) -> Wheels:
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
        wheels = no_wheel_forces(motion.shape[0])._replace(rail=state.wheels.rail.copy())
        if self.interface != APPLIED:
            rows = motion.copy()
            rows[:, 2] += state.datum
            wheels = self._touch(
                rows, state.wheels.rail, self.irregularity.evaluate(motion[:, 0])[0]
            )
        changed = state.replace(wheels=wheels)
        begin_motion(changed, state.time, motion)
        wheel_outputs(changed.wheels, self.parameters.rail.axis_depth, changed.wheel_outputs)
        return changed

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
            If a wheel leaves the window or the rail, or the motion is not finite or jumps.
        """
        march = getattr(self._of_thread, "march", None)
        if march is None:
            march = self._of_thread.march = self.stepper.march(state)
        march.restart(state.vector)
        march.step(motion, dt, at_end=at_end, applied_force=self._needed(applied_force))
        state = TrackState(self.layout, march.vector.copy())
        return state, TrackOutputs(state)

    def _needed(self, applied_force: np.ndarray | None) -> np.ndarray | None:
        """Refuse a step without the forces that ``interface = "applied_force"`` takes."""
        if self.interface == APPLIED and applied_force is None:
            raise TrackError("interface = applied_force needs the forces at the rail heads")
        return applied_force

    def outputs(self, state: TrackState) -> TrackOutputs:
        """Return the contact forces on the wheelsets and what happens at the wheels."""
        return TrackOutputs(state)


__all__ = ["END_MARGIN", "TrackModel", "TrackOutputs", "TrackState"]
