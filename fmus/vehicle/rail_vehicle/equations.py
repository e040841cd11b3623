r"""The vehicle as equations: the definition that the fast kernels are tested against.

.. math:: M \ddot q + (C + G) \dot q + K q
          = B (f - f_0) + g(\Omega) - N^T p(N q, N \dot q) - m_x a,\qquad
          I_{wy} \dot\Omega_i = f_{\text{pitch},i}

in the 50 coordinates of :mod:`rail_vehicle.coordinates`: f the contact forces on the wheelsets, p
the forces of the non-linear elements, N q their elongations, a the acceleration of the car body, to
which the frame is tied. Matrices are put together body by body and element by element; a step takes
the linear part exactly. Arrangement, signs and geometric stiffness are explained in
``fmus/vehicle/README.md``. It runs in plain numpy, and is slow.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from rail_vehicle.coordinates import COORDINATE_COUNT as COUNT
from rail_vehicle.coordinates import FREE, LATERAL, PITCH, ROLL, SPINS, YAW, X, Y, Z
from rail_vehicle.errors import StepError
from rail_vehicle.parameters import LateralDamper, VehicleParameters, YawDamper

Array = np.ndarray
ROLLS, YAWS = SPINS - PITCH + ROLL, SPINS - PITCH + YAW
"""Coordinates of the wheelsets."""

_ROUNDS, _TOLERANCE = 200, 1e-13
"""Of the iteration for the internal forces at the end of a step; relative change at its end."""


class VehicleState(NamedTuple):
    """All that the vehicle remembers.

    Attributes
    ----------
    coordinates, rates
        Of the bodies, (50,), from the static equilibrium in the moving frame; SI units.
    yaw_dampers
        Forces of bogie 1 left, right, bogie 2 left, right, (4,), N.
    position, speed
        Of the car body along the line, m and m/s.
    """

    coordinates: Array
    rates: Array
    yaw_dampers: Array
    position: float
    speed: float


class VehicleOutputs(NamedTuple):
    """What a step gives.

    Attributes
    ----------
    motion
        Of the wheelsets, (4, 11), in the order of the terminal.
    accelerations
        Of the coordinates, but for the car body's x and the spins, (50,).
    elements
        Forces of the non-linear elements, (8,), N: yaw dampers, lateral dampers, stops.
    axle_boxes
        Vertical accelerations, (4, 2), left first, m/s2.
    """

    motion: Array
    accelerations: Array
    elements: Array
    axle_boxes: Array


class Body(NamedTuple):
    """Place of a body's reference point (3,), its displacement and rotation per coordinate."""

    place: Array
    displacement: Array
    rotation: Array

    def at(self, point: Array) -> Array:
        """Displacement of the body's point at ``point``, u + theta x r, per coordinate, (3, 50)."""
        return self.displacement + np.cross(self.rotation.T, point - self.place).T


def rigid_body(number: int, x: float, height: float) -> Body:
    """Return the ``number``-th of car body (0), bogie frames (1, 2) and wheelsets (3 to 6)."""
    rows = np.eye(COUNT)[6 * number : 6 * number + 6]
    return Body(np.array([x, 0.0, -height]), rows[:3], rows[3:])


def axle_box(wheelset: Body, number: int, y: float) -> Body:
    """Return the ``number``-th axle box, at ``y`` on the axle: it pitches on its own."""
    place = wheelset.place + np.array([0.0, y, 0.0])
    rotation = wheelset.rotation.copy()
    rotation[1] = np.eye(COUNT)[42 + number]
    return Body(place, wheelset.at(place), rotation)


def cross(a: Array) -> Array:
    """Return the matrix S with S b = a x b."""
    return np.cross(a, np.eye(3)).T


class VehicleEquations:
    """The equations for one set of parameters; it holds constants only.

    Steps longer than ``longest_step`` (s) are divided.
    """

    def __init__(self, parameters: VehicleParameters, longest_step: float = 1e-3) -> None:
        p = self.p = parameters
        self.longest_step, self.spin = longest_step, -p.speed / p.wheelset.radius
        self.M, self.K, self.C = np.zeros(COUNT), np.zeros((COUNT, COUNT)), np.zeros((COUNT, COUNT))
        self._bodies()
        self._springs_and_dampers()
        self.N = np.array(self._elongations())
        for wheelset in range(3, 7):  # G: momentum I_wy Omega along the axle (-yaw, 1, roll)
            roll, yaw = 6 * wheelset + ROLL, 6 * wheelset + YAW
            self.C[roll, yaw] -= p.wheelset.pitch_inertia * self.spin
            self.C[yaw, roll] += p.wheelset.pitch_inertia * self.spin
        self.propagator = functools.lru_cache(maxsize=4)(self._propagator)

    # -- bodies -----------------------------------------------------------------------------

    def _bodies(self) -> None:
        p, reach, base = self.p, self.p.car_body.half_bogie_spacing, self.p.bogie.half_wheelbase
        self.car = rigid_body(0, 0.0, p.car_body.centre_of_gravity_height)
        self.x_bogies = np.array([reach, -reach])
        self.x_axles = np.array([reach + base, reach - base, base - reach, -reach - base])
        height = p.bogie.centre_of_gravity_height
        self.bogies = [rigid_body(1 + j, x, height) for j, x in enumerate(self.x_bogies)]
        self.wheelsets = [
            rigid_body(3 + i, x, p.wheelset.radius) for i, x in enumerate(self.x_axles)
        ]
        b = p.primary_suspension.half_span
        self.boxes = [
            axle_box(self.wheelsets[n // 2], n, -b if n % 2 == 0 else b) for n in range(8)
        ]
        for number, of in enumerate([p.car_body, *2 * [p.bogie], *4 * [p.wheelset]]):
            inertia = of.roll_inertia, of.pitch_inertia, of.yaw_inertia
            self.M[6 * number : 6 * number + 6] = *3 * (of.mass,), *inertia
        self.M[42:] = p.axle_box.pitch_inertia

    # -- linear elements --------------------------------------------------------------------

    def _join(self, upper: Body, lower: Body, point, k=(0, 0, 0), c=(0, 0, 0), load=0.0) -> None:
        """Add a spring and a damper between the bodies' points, which carry ``load`` at rest."""
        point = np.array(point)
        d, m = upper.at(point) - lower.at(point), 0.5 * (upper.rotation + lower.rotation)
        self.K += d.T @ np.diag(k) @ d
        self.C += d.T @ np.diag(c) @ d
        F = np.array([0.0, 0.0, -load])  # on the upper body
        # Geometric stiffness: the energy of F is -F . (d - m x d), d to second order.
        for body, sign in ((upper, 1.0), (lower, -1.0)):
            r = point - body.place  # d contains a x (a x r)/2, a the body's rotation
            tilt = (F @ r) * np.eye(3) - 0.5 * (np.outer(F, r) + np.outer(r, F))
            self.K += sign * body.rotation.T @ tilt @ body.rotation
        turned = d.T @ cross(F) @ m  # F . (m x d) = d . (F x m)
        self.K += turned + turned.T

    def _springs_and_dampers(self) -> None:
        p, s, f = self.p, self.p.secondary_suspension, self.p.primary_suspension
        k_s = s.longitudinal_stiffness, s.lateral_stiffness, s.vertical_stiffness
        c_s = s.longitudinal_damping, s.lateral_damping, s.vertical_damping
        for frame in self.bogies:
            for y in (-s.half_span, s.half_span):
                load = p.car_body.mass * p.gravity / 4.0
                self._join(self.car, frame, [frame.place[0], y, -s.height], k_s, c_s, load)
            roll = self.car.rotation[0] - frame.rotation[0]
            self.K += p.anti_roll_bar.roll_stiffness * np.outer(roll, roll)
        k_g = f.longitudinal_stiffness, f.lateral_stiffness, f.guide_vertical_stiffness
        c_g = f.longitudinal_damping, f.lateral_damping, f.guide_vertical_damping
        k_z, c_z = (0, 0, 0.5 * f.vertical_stiffness), (0, 0, 0.5 * f.vertical_damping)
        load = (p.car_body.mass + 2.0 * p.bogie.mass) * p.gravity / 16.0
        for n, box in enumerate(self.boxes):
            frame, (x, y, z) = self.bogies[n // 4], box.place
            for a in (f.spring_half_spacing, -f.spring_half_spacing):
                self._join(frame, box, [x + a, y, z], k_z, c_z, load)
            inwards = math.copysign(f.guide_offset, frame.place[0] - x)
            self._join(frame, box, [x + inwards, y, -f.guide_height], k_g, c_g)

    # -- non-linear elements ----------------------------------------------------------------

    def _elongations(self) -> list[Array]:
        """Of yaw dampers along x, lateral dampers and stops along y: car body against frame."""
        p, rows = self.p, []
        for frame in self.bogies:
            for y in (-p.yaw_damper.half_span, p.yaw_damper.half_span):
                point = np.array([frame.place[0], y, -p.yaw_damper.height])
                rows.append((self.car.at(point) - frame.at(point))[X])
        for height in (p.lateral_damper.height, p.lateral_bump_stop.height):
            for frame in self.bogies:
                point = np.array([frame.place[0], 0.0, -height])
                rows.append((self.car.at(point) - frame.at(point))[Y])
        return rows

    def internal(self, q: Array, v: Array, yaw_dampers: Array) -> tuple[Array, Array]:
        """Return g - N^T p, (50,), and p, (8,): yaw dampers (a state), lateral dampers, stops."""
        stop, I_wy = self.p.lateral_bump_stop, self.p.wheelset.pitch_inertia
        u, u_t = self.N @ q, self.N @ v
        d = np.sign(u[6:]) * np.maximum(np.abs(u[6:]) - stop.clearance, 0.0)
        stops = stop.stiffness * d + stop.cubic_stiffness * d**3
        p = np.concatenate([yaw_dampers, blow_off(u_t[4:6], self.p.lateral_damper), stops])
        forces = -self.N.T @ p
        # G has the spin of the parameter speed; what the wheelsets spin beyond it acts as a moment.
        beyond = I_wy * (v[SPINS] - self.spin)
        forces[ROLLS] += beyond * v[YAWS]
        forces[YAWS] -= beyond * v[ROLLS]
        return forces, p

    # -- start ------------------------------------------------------------------------------

    def initial_state(self, heights: Array | None = None) -> VehicleState:
        """Return the equilibrium with the wheelsets held at ``heights`` (4,), m, and upright."""
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        held = np.add.outer(SPINS - PITCH, (Y, Z, ROLL, YAW))
        loose = np.setdiff1d(FREE, held)
        q[SPINS - PITCH + Z] = 0.0 if heights is None else heights
        q[loose] = np.linalg.solve(self.K[np.ix_(loose, loose)], -self.K[loose] @ q)
        q[LATERAL] += self.p.initial_lateral_displacement
        v[SPINS] = self.spin
        x = self.p.initial_position - self.x_axles[0]
        return VehicleState(q, v, np.zeros(4), x, self.p.speed)

    # -- step -------------------------------------------------------------------------------

    def step(
        self,
        state: VehicleState,
        forces: Array,
        dt: float,
        speed_setpoint: float | None = None,
    ) -> tuple[VehicleState, VehicleOutputs]:
        """Return the state and the outputs ``dt`` seconds later.

        ``forces`` (3, 4, 6) as :func:`forces_over_step` returns them, N and N.m; the car body goes
        to ``speed_setpoint``, m/s, as fast as ``speed_constraint.acceleration_limit`` allows.
        """
        limit = self.p.speed_constraint.acceleration_limit
        wanted = state.speed if speed_setpoint is None else speed_setpoint
        a = float(np.clip((wanted - state.speed) / dt, -limit, limit))
        c_0, c_1, c_2 = forces
        count = max(1, math.ceil(dt / self.longest_step * (1.0 - 1e-9)))
        for t in np.arange(count) / count:  # of c_0 + c_1 s + c_2 s^2, from s = t on
            part = c_0 + c_1 * t + c_2 * t**2, (c_1 + 2.0 * c_2 * t) / count, c_2 / count**2
            state = self._internal_step(state, np.stack(part), a, dt / count)
        return state, self.outputs(state, c_0 + c_1 + c_2, a)

    @property
    def static_forces(self) -> Array:
        """Contact forces f_0 of the static equilibrium, (4, 6), N."""
        f_0 = np.zeros((4, 6))
        f_0[:, Z] = -2.0 * self.p.static_wheel_load
        return f_0

    def outside(self, f: Array, a: float) -> Array:
        """B f - m_x a: contact forces (4, 6) on the wheelsets, inertia in the frame's motion."""
        loads = np.zeros(COUNT)
        loads[18:42] = f.ravel()
        loads[6:42:6] -= self.M[6:42:6] * a
        return loads

    def _internal_step(self, state: VehicleState, c: Array, a: float, h: float) -> VehicleState:
        """Step of ``h`` s; contact forces are quadratic, internal ones linear in time."""
        q, v, yaw = state.coordinates.copy(), state.rates.copy(), self.p.yaw_damper
        start, u_0 = self.internal(q, v, state.yaw_dampers)[0], self.N @ q
        moments = c[:, :, PITCH] / self.p.wheelset.pitch_inertia  # I_wy Omega' = f_pitch
        q[SPINS] += h * (v[SPINS] + h * (moments[0] / 2 + moments[1] / 6 + moments[2] / 12))
        v[SPINS] += h * (moments[0] + moments[1] / 2 + moments[2] / 3)
        free, constant, linear, quadratic = self.propagator(h)
        known = free @ np.concatenate([state.coordinates[FREE], state.rates[FREE]])
        known += constant @ (self.outside(c[0] - self.static_forces, a) + start)[FREE]
        known += linear @ (self.outside(c[1], 0.0) - start)[FREE]
        known += quadratic @ self.outside(c[2], 0.0)[FREE]
        end = start
        for _ in range(_ROUNDS):
            q[FREE], v[FREE] = np.split(known + linear @ end[FREE], 2)
            rates = (self.N @ q - u_0)[:4] / h
            forces = [yaw_damper(*x, h, yaw) for x in zip(state.yaw_dampers, rates, strict=True)]
            last, end = end, self.internal(q, v, np.array(forces))[0]
            if np.max(np.abs(end - last)) <= _TOLERANCE * (1.0 + np.max(np.abs(end))):
                break
        else:
            raise StepError("the forces of the dampers and stops were not found")
        x, speed = state.position + h * (state.speed + 0.5 * a * h), state.speed + a * h
        return VehicleState(q, v, np.array(forces), x, speed)

    def _propagator(self, h: float) -> tuple[Array, ...]:
        """Return what brings the state (90,) to h, and loads (45,) that go with 1, s and s^2."""
        n, inverse = FREE.size, 1.0 / self.M[FREE, None]
        chain = np.zeros((5 * n, 5 * n))
        chain[:n, n : 2 * n] = h * np.eye(n)
        chain[n : 2 * n, :n] = -h * inverse * self.K[np.ix_(FREE, FREE)]
        chain[n : 2 * n, n : 2 * n] = -h * inverse * self.C[np.ix_(FREE, FREE)]
        chain[n : 2 * n, 2 * n : 3 * n] = h * np.diag(inverse[:, 0])
        chain[2 * n : 4 * n, 3 * n :] = np.eye(2 * n)  # s' = 1, (s^2/2)' = s
        rows = np.asarray(expm(chain))[: 2 * n]
        return (
            rows[:, : 2 * n],
            rows[:, 2 * n : 3 * n],
            rows[:, 3 * n : 4 * n],
            2.0 * rows[:, 4 * n :],
        )

    def outputs(self, state: VehicleState, f: Array, a: float = 0.0) -> VehicleOutputs:
        """Return the outputs under contact forces ``f`` (4, 6), N and N.m."""
        q, v = state.coordinates, state.rates
        internal, elements = self.internal(q, v, state.yaw_dampers)
        loads = self.outside(f - self.static_forces, a) + internal - self.C @ v - self.K @ q
        accelerations = np.zeros(COUNT)
        accelerations[FREE] = (loads / self.M)[FREE]
        bodies, rates = q[18:42].reshape(4, 6), v[18:42].reshape(4, 6)
        shown = [X, Y, Z, ROLL, YAW]
        motion = np.hstack([bodies[:, shown], rates[:, [*shown, PITCH]]])
        motion[:, 0] += state.position + self.x_axles
        motion[:, 5] += state.speed
        boxes = np.array([box.displacement[Z] @ accelerations for box in self.boxes])
        return VehicleOutputs(motion, accelerations, elements, boxes.reshape(4, 2))


def blow_off(rate: Array, damper: LateralDamper) -> Array:
    """Force of a dashpot: c u' up to the blow-off force, and less steeply beyond."""
    if damper.damping == 0.0:
        return np.zeros_like(rate)
    limit = damper.blow_off_force / damper.damping
    below = np.clip(rate, -limit, limit)
    return damper.damping * below + damper.blow_off_damping * (rate - below)


def yaw_damper(F: float, rate: float, time: float, damper: YawDamper) -> float:
    """Force after ``time`` s: F' = K (u' - v(F)), v the inverse of :func:`blow_off`, u' constant.

    On either branch v is F/c + v_0; where the force passes the limit, the other branch goes on.
    """
    K, limit, c_1, c_2 = (
        damper.series_stiffness, damper.blow_off_force, damper.damping, damper.blow_off_damping,
    )  # fmt: skip
    while c_1 > 0.0:
        sign = math.copysign(1.0, F)
        at_limit = math.isclose(abs(F), limit, rel_tol=1e-12)
        blows = sign * rate > limit / c_1 if at_limit else abs(F) > limit
        c, v_0 = (c_2, sign * limit * (1 / c_1 - 1 / c_2)) if blows else (c_1, 0.0)
        final = c * (rate - v_0)
        end = final + (F - final) * math.exp(-K * time / c)
        bound = sign * limit if blows else math.copysign(limit, end)
        if (sign * end >= limit) if blows else (abs(end) <= limit):
            return end
        time += c / K * math.log((bound - final) / (F - final))
        F = bound
    return F


def forces_over_step(
    ages: Array, values: Array, dt: float, order: int, *, at_end: bool = False
) -> Array:
    """Return contact forces c_0 + c_1 s + c_2 s^2 over a step, s from 0 to 1: (3, 4, 6).

    The polynomial of ``order`` (0 to 2) through the communicated ``values`` (n, 4, 6), newest
    first, each ``ages`` (n,) s before it. The newest is that of the step's start, or of its end.
    """
    t_k, first = -ages[: order + 1], -dt if at_end else 0.0

    def through(t: float) -> Array:
        """Lagrange's polynomial."""
        weights = [
            np.prod((t - np.delete(t_k, k)) / (x - np.delete(t_k, k))) for k, x in enumerate(t_k)
        ]
        return np.tensordot(weights, values[: order + 1], axes=1)

    start, middle, end = (through(first + s * dt) for s in (0.0, 0.5, 1.0))
    c_2 = 2.0 * (start + end) - 4.0 * middle
    return np.stack([start, end - start - c_2, c_2])
