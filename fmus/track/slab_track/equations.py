r"""The track as equations: the definition that the fast kernels are tested against.

.. math:: \ddot q + c\,\dot q + K q = W^T F - B^T p,\qquad p = k e + c_p \dot e,\qquad
          e = B q + R_{pF} F - R_{pp}\, p,\qquad F = F(\text{wheelsets, rails})

with the matrices of :mod:`slab_track.matrices` over all of a window: both rails, all fasteners, all
slabs. A step is the trapezoidal rule with everything implicit: one linear system, and Newton's
method for the contact. Nothing is folded, tabulated over distance or left to a sweep. It runs in
plain numpy, and is slow.

Numbers in parentheses are the article's equations, errata and sections those of ``docs/theory.md``.
w wheelsets, N waves, S slabs, P fasteners per rail; directions of forces on a rail and of its
motion: lateral, vertical, roll; sides: left, right.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import lu_factor, lu_solve

from slab_track.contact import Steel, build_tables
from slab_track.contact.equations import Contact, level_contact, no_contact, profile_contact
from slab_track.errors import TrackError
from slab_track.irregularity import Irregularity
from slab_track.kernels.motion import LEAST_SPAN
from slab_track.matrices import LATERAL, PSI, PSI_Y, ROLL, VERTICAL, TrackMatrices
from slab_track.parameters import TrackParameters
from slab_track.window import place_window


class TrackState(NamedTuple):
    """All that the track remembers.

    Attributes
    ----------
    time, window_start, datum
        s, m, and the height of the wheelsets above first touch at vertical displacement 0, m.
    static_heights, places
        Of the wheelsets at the start: heights above the datum, and where in the window, (w,), m.
    rails, slabs
        Coordinates, rates and accelerations: (3, 2, 5, N), fields as above, and X of eq. (7),
        (3, S, n).
    residual
        Compression of the fasteners by what the series leave out, and its rate, (2, P, 2, 3).
    pads, force
        Forces of fasteners (P, 2, 3) and wheels (w, 2, 3) on the rails' axes, N and N.m.
    point, motion, point_before, motion_before
        The last two communication points, s and (w, 11); NaN where there is only one.
    has_rate
        Which of x, y, z, roll and yaw ever came with a rate, (5,).
    """

    time: float
    window_start: float
    datum: float
    static_heights: np.ndarray
    places: np.ndarray
    rails: np.ndarray
    slabs: np.ndarray
    residual: np.ndarray
    pads: np.ndarray
    force: np.ndarray
    point: float
    motion: np.ndarray
    point_before: float
    motion_before: np.ndarray
    has_rate: np.ndarray


class TrackOutputs(NamedTuple):
    """What happens at the wheels at the end of a step.

    Attributes
    ----------
    contact
        See there.
    rail
        Motion of the rails' axes under the wheels: y, z, roll and rates, (w, 2, 6).
    """

    contact: Contact
    rail: np.ndarray


_TOLERANCE = 1e-3
"""Largest force that may stay unbalanced, N."""


class TrackEquations:
    """The equations for one set of parameters; it holds constants only.

    Raises
    ------
    TrackError
        If the window shifts otherwise than by eq. (11).
    """

    def __init__(self, parameters: TrackParameters) -> None:
        window = parameters.window
        if window.slide_solver != "least_squares" or window.rear_taper > 0.0:
            raise TrackError(
                "the equations take window.slide_solver = least_squares, no rear_taper"
            )
        self.p, self.track = parameters, TrackMatrices(parameters)
        self.irregularity = Irregularity(parameters.irregularity)
        self.jacobian = functools.lru_cache(maxsize=4)(self._jacobian)

    # -- contact ----------------------------------------------------------------------------

    @functools.cached_property
    def tables(self):
        """Tables of the profiles, a set-up quantity."""
        p, rail = self.p, self.p.rail
        return build_tables(
            p.contact, gauge=rail.gauge, gauge_measurement_depth=rail.gauge_measurement_depth,
            cant=rail.cant, rail_axis_depth=rail.axis_depth,
            steel=Steel(youngs_modulus=rail.youngs_modulus, poisson_ratio=rail.poisson_ratio),
        )  # fmt: skip

    def contact(self, row: np.ndarray, offsets: np.ndarray, rail: np.ndarray) -> Contact:
        """Return the forces of wheelsets (w, 11) on irregular rails (w, 2, 2), moved (w, 2, 6)."""
        contact = self.p.contact
        if contact.model == "profiles":
            return profile_contact(self.tables, row, offsets, rail)
        half, G_H = 0.5 * contact.rolling_circle_distance, contact.hertz_constant_used
        return level_contact(row, offsets, rail, half, G_H)

    # -- start ------------------------------------------------------------------------------

    def initial_state(self, motion: np.ndarray, time: float = 0.0) -> TrackState:
        """Return the equilibrium of wheelsets at ``motion`` (w, 11) under their load, section 8."""
        p, t, count, x = self.p, self.track, len(motion), motion[:, 0]
        start = place_window(p, x)
        offsets, (W, R_pF, R_FF) = self.irregularity.evaluate(x)[0], t.wheels(x - start)
        k, n = t.k_p[:, None], t.c.size
        # K q = W^T F - B^T p,  p = k e,  e = B q + R_pF F - R_pp p; per unit force F:
        matrix = np.block([[t.K, t.B.T], [-k * t.B, np.eye(k.size) + k * t.R_pp]])
        q, pads = np.split(np.linalg.solve(matrix, np.vstack([W.T, k * R_pF])), [n])
        flexibility = W @ q + R_FF - R_pF.T @ pads

        def rails(F: np.ndarray) -> np.ndarray:
            still = np.zeros((count, 2, 3))
            return np.concatenate([(flexibility @ F).reshape(count, 2, 3), still], axis=2)

        load, nm = p.static_wheel_load, 1e-9
        F, heights = np.tile([0.0, load, 0.0], 2 * count), np.zeros(count)
        if load > 0.0:
            level = (rails(F)[..., VERTICAL] + offsets[..., 0]).mean(axis=1)
            heights = level + p.contact.hertz_constant_used * load ** (2 / 3)
        if load > 0.0 and p.contact.model == "profiles":

            def unbalanced(unknown: np.ndarray) -> np.ndarray:
                F, row = unknown[: 6 * count], motion.copy()
                row[:, 2] = nm * unknown[6 * count :]
                contact = self.contact(row, offsets, rails(F))
                carried = -contact.on_wheelset[:, 2]
                return np.concatenate([F - contact.on_rail.ravel(), carried - 2.0 * load])

            found = newton(unbalanced, np.concatenate([F, heights / nm]))
            F, heights = found[: 6 * count], nm * found[6 * count :]
        residual = R_pF @ F - t.R_pp @ (pads @ F)
        state = TrackState(
            time=time,
            window_start=start,
            datum=float(heights.mean()),
            static_heights=heights - heights.mean(),
            places=x - start,
            rails=np.zeros((3, 2, 5, t.waves.wave_number.size)),
            slabs=np.zeros((3, p.window.slab_count, p.slab.mode_count)),
            residual=np.stack([residual, 0.0 * residual]).reshape(2, -1, 2, 3),
            pads=(pads @ F).reshape(-1, 2, 3),
            force=F.reshape(count, 2, 3),
            point=time,
            motion=motion.copy(),
            point_before=math.nan,
            motion_before=motion.copy(),
            has_rate=np.any(motion[:, 5:10] != 0.0, axis=0),
        )
        return _unpacked(state, np.vstack([q @ F, np.zeros((2, n))]))

    # -- step -------------------------------------------------------------------------------

    def step(
        self,
        state: TrackState,
        motion: np.ndarray,
        dt: float,
        *,
        at_end: bool = False,
        applied_force: np.ndarray | None = None,
    ) -> tuple[TrackState, TrackOutputs]:
        """Return the state and what happens at the wheels ``dt`` seconds later.

        ``motion`` (w, 11) of the wheelsets stands for the start of the step or its end;
        ``applied_force`` (w, 2, 3) acts on the rails' heads with ``interface = applied_force``.
        """
        p, time = self.p, state.time + dt
        state = _communicated(state, motion, time if at_end else state.time, time)
        steps = max(1, math.ceil(dt / p.integration.maximum_step - 1e-9))
        h = dt / steps
        path = [_wheelsets(state, state.time - state.point + h * (n + 1)) for n in range(steps)]
        if p.moves:
            start = place_window(p, path[-1][:, 0])
            while state.window_start < start - 0.5 * p.slide_length:
                state = self.shift(state)
        for row in path:
            state, outputs = self._internal_step(state, row, h, applied_force)
        return state._replace(time=time), outputs

    def _internal_step(
        self, state: TrackState, row: np.ndarray, h: float, applied: np.ndarray | None
    ) -> tuple[TrackState, TrackOutputs]:
        t, count = self.track, len(row)
        (q_0, v_0, a_0), (r_0, s_0) = _packed(state), state.residual.reshape(2, -1)
        standing = self.p.window.method == "moving_irregularity"
        W, R_pF, R_FF = t.wheels(state.places if standing else row[:, 0] - state.window_start)
        offsets = self.irregularity.evaluate(row[:, 0])[0]
        row = row + state.datum * (np.arange(11) == 2)

        def motion(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Trapezoidal rule: Newmark, beta = 1/4, gamma = 1/2."""
            return q_0 + h * v_0 + h**2 / 4 * (a_0 + a), v_0 + h / 2 * (a_0 + a)

        def left_out(p: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Compression by what the series leave out; its rate follows the same rule."""
            r = R_pF @ F - t.R_pp @ p
            return r, 2 / h * (r - r_0) - s_0

        def unbalanced(a: np.ndarray, p: np.ndarray, F: np.ndarray) -> np.ndarray:
            (q, v), (r, s) = motion(a), left_out(p, F)
            e, e_t = t.B @ q + r, t.B @ v + s
            rails_and_slabs = a + t.c * v + t.K @ q - W.T @ F + t.B.T @ p  # Eqs. (6a), (6b), (7)
            fasteners = p - (t.k_p * e + t.c_p * e_t)  # p = k e + c de/dt, section 5
            return np.concatenate([rails_and_slabs, fasteners])

        jacobian, none = self.jacobian(h), (np.zeros(q_0.size), np.zeros(r_0.size))
        free = -lu_solve(jacobian, unbalanced(*none, np.zeros(6 * count)))
        nu = t.k_p + 2 / h * t.c_p
        per_force = lu_solve(jacobian, np.vstack([W.T, nu[:, None] * R_pF]))

        def rails(F: np.ndarray) -> np.ndarray:
            """Motion of the axes under the wheels; the waves left out have no rate."""
            a, p = np.split(free + per_force @ F, [q_0.size])
            q, v = motion(a)
            moved, rate = W @ q + R_FF @ F - R_pF.T @ p, W @ v
            return np.concatenate([x.reshape(count, 2, 3) for x in (moved, rate)], axis=2)

        if applied is None:
            F = newton(
                lambda F: F - self.contact(row, offsets, rails(F)).on_rail.ravel(),
                state.force.ravel(),
            )
            contact = self.contact(row, offsets, rails(F))
        else:
            axis = np.array(applied, dtype=float)
            axis[..., ROLL] += self.p.rail.axis_depth * axis[..., LATERAL]
            F, contact = axis.ravel(), no_contact(count)
        a, p = np.split(free + per_force @ F, [q_0.size])
        return _unpacked(
            state._replace(
                time=state.time + h,
                residual=np.stack(left_out(p, F)).reshape(state.residual.shape),
                pads=p.reshape(state.pads.shape),
                force=F.reshape(count, 2, 3),
            ),
            np.stack([*motion(a), a]),
        ), TrackOutputs(contact, rails(F))

    def _jacobian(self, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivative of what is unbalanced by a and p, factorised."""
        t, nu = self.track, self.track.k_p + 2 / h * self.track.c_p
        inertia = np.diag(1.0 + h / 2 * t.c) + h**2 / 4 * t.K
        pads = (t.k_p * h**2 / 4 + t.c_p * h / 2)[:, None] * t.B
        own = np.eye(nu.size) + nu[:, None] * t.R_pp
        return lu_factor(np.block([[inertia, t.B.T], [-pads, own]]))

    # -- window shift -----------------------------------------------------------------------

    def shift(self, state: TrackState) -> TrackState:
        """Move the window on by one shift, L_m."""
        p, waves, L_m = self.p, self.track.waves, self.p.slide_length
        x = (np.arange(p.sample_count) + 0.5) * p.window_length / p.sample_count
        inside = p.ring | (x + L_m <= p.window_length)
        rails = np.empty_like(state.rails)
        for field in range(5):
            shapes = waves.rotation_shapes if field in (PSI, PSI_Y) else waves.shapes
            Phi, Q_old = shapes(x).T, state.rails[:, :, field].reshape(6, -1).T
            D = inside[:, None] * (shapes(x + L_m).T @ Q_old)  # Eq. (9)
            Q = np.linalg.lstsq(Phi, D, rcond=None)[0]  # Eqs. (10), (11)
            rails[:, :, field] = Q.T.reshape(3, 2, -1)
        seats, slabs = round(L_m / p.fastener.spacing), round(L_m / p.pitch)
        return state._replace(
            window_start=state.window_start + L_m,
            rails=rails,
            slabs=self._moved(state.slabs, slabs),  # Eq. (8)
            residual=self._moved(state.residual, seats),
            pads=self._moved(state.pads[None], seats)[0],
        )

    def _moved(self, values: np.ndarray, rows: int) -> np.ndarray:
        """Rows moved to the rear along axis 1; new ones are at rest, a ring's come back."""
        moved = np.roll(values, -rows, axis=1)
        if not self.p.ring:
            moved[:, -rows:] = 0.0
        return moved


def newton(unbalanced: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> np.ndarray:
    """Find the zero of ``unbalanced`` near ``start``, both (n,), in N, N.m or nm.

    The contact's laws are smooth but for where patches begin to touch or to slip: steps that lead
    too far are halved.
    """
    x, error = start, unbalanced(start)
    for _ in range(100):
        slope = np.stack([unbalanced(x + e) - error for e in np.eye(x.size)], axis=1)
        change = -np.linalg.solve(slope, error)
        for part in 0.5 ** np.arange(12):
            trial = unbalanced(x + part * change)
            if np.max(np.abs(trial)) < np.max(np.abs(error)):
                break
        else:
            break
        x, error = x + part * change, trial
    if np.max(np.abs(error)) > _TOLERANCE:
        raise TrackError(f"the contact forces were not found: {np.max(np.abs(error)):g} N are left")
    return x


def _packed(state: TrackState) -> np.ndarray:
    """Coordinates, rates and accelerations as the matrices take them, (3, n)."""
    return np.hstack([state.rails.reshape(3, -1), state.slabs.reshape(3, -1)])


def _unpacked(state: TrackState, coordinates: np.ndarray) -> TrackState:
    rails, slabs = np.split(coordinates, [state.rails[0].size], axis=1)
    return state._replace(
        rails=rails.reshape(state.rails.shape), slabs=slabs.reshape(state.slabs.shape)
    )


def _communicated(state: TrackState, motion: np.ndarray, time: float, end: float) -> TrackState:
    """Take in the wheelsets' ``motion`` (w, 11) at a communication point, for a step to ``end``."""
    # Of two points that are too near to extrapolate from, the earlier one makes way.
    near = time - state.point < LEAST_SPAN * (end - time) and not math.isnan(state.point_before)
    if time != state.point and not near:
        state = state._replace(point_before=state.point, motion_before=state.motion)
    has_rate = state.has_rate | np.any(motion[:, 5:10] != 0.0, axis=0)
    return state._replace(point=time, motion=motion.copy(), has_rate=has_rate)


def _wheelsets(state: TrackState, tau: float) -> np.ndarray:
    """Motion of the wheelsets (w, 11), ``tau`` seconds after the last communication point.

    The cubic through position and velocity at the last two points (section 9).
    """
    now, before, span = state.motion, state.motion_before, state.point - state.point_before
    x, v, spin = now[:, :5], now[:, 5:10], now[:, 10:]
    if not span > 0.0:
        return np.hstack([x + tau * v, v, spin])
    slope = (now - before) / span
    cubic = CubicHermiteSpline([-span, 0.0], [before[:, :5], x], [before[:, 5:10], v])
    # Positions alone where a partner leaves a rate unconnected.
    x, v = (
        np.where(state.has_rate, cubic(tau), x + tau * slope[:, :5]),
        np.where(state.has_rate, cubic(tau, 1), slope[:, :5]),
    )
    return np.hstack([x, v, spin + tau * slope[:, 10:]])
