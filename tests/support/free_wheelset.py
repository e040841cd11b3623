"""A free rigid wheelset on two fixed rails: exact rigid-body motion, Runge-Kutta of order 4.

State (14): position of the centre (3), velocity (3), unit vector of the axle (3), angular momentum
(3), work of the creep forces at the patches, largest power seen there. Nothing but contact
forces, a constant load and (if asked for) vertical dashpots on the axle acts.
"""

from typing import NamedTuple

import numba
import numpy as np
from slab_track.contact import WheelRailContact
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.wheelset import (
    ANGLE,
    ARM_X,
    FORCED,
    LATERAL_FORCE,
    LOCATED,
    LONGITUDINAL_FORCE,
    PENETRATION,
    SPIN_MOMENT,
    STIFFNESS,
    ContactWork,
    wheel_rail_contact,
)

WORK, WORST_POWER = 12, 13


class Wheelset(NamedTuple):
    """Mass (kg), weight carried (N), inertia about a diameter and the axle (kg.m2), dashpots."""

    mass: float
    load: float
    diametral: float
    polar: float
    dashpot: float = 0.0


@numba.njit
def motion_row(body, state):
    """Return the contract's motion row (11,) and the angular velocity (3,)."""
    axle, momentum = state[6:9], state[9:12]
    along = np.dot(momentum, axle)
    omega = (momentum - along * axle) / body.diametral + along / body.polar * axle
    roll, yaw = np.arcsin(axle[2]), np.arctan2(-axle[0], axle[1])
    line = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    yaw_rate = np.dot(omega, np.cross(line, axle)) / np.cos(roll)
    row = np.zeros(11)
    row[:3], row[3], row[4], row[5:8] = state[:3], roll, yaw, state[3:6]
    row[8], row[9] = np.dot(omega, line), yaw_rate
    row[10] = np.dot(omega, axle) - yaw_rate * np.sin(roll)
    return row, omega


@numba.njit
def _rates(body, state, row, omega, wheelset, located, forces):
    rate = np.empty(14)
    rate[:3] = state[3:6]
    rate[3:6] = wheelset[0, :3] / body.mass
    rate[5] += body.load / body.mass - body.dashpot * state[5] / body.mass
    rate[6:9] = np.cross(omega, state[6:9])
    rate[9:12] = wheelset[0, 3:]
    rate[9] -= body.dashpot * 0.5 * row[8]
    power = 0.0
    for side in range(2):
        for patch in range(2):
            place, force = located[0, side, patch], forces[0, side, patch]
            if place[PENETRATION] <= 0.0:
                continue
            slip = state[3:6] + np.cross(omega, place[ARM_X : ARM_X + 3])
            c, s = np.cos(place[ANGLE]), np.sin(place[ANGLE])
            power += force[LONGITUDINAL_FORCE] * slip[0]
            power += force[LATERAL_FORCE] * (c * slip[1] + s * slip[2])
            power += force[SPIN_MOMENT] * (c * omega[2] - s * omega[1])
    rate[WORK], rate[WORST_POWER] = power, 0.0
    return rate


def _slope_of(tables, body):
    """Return the function that gives the rate of change of a state."""
    motion, rails, offsets = np.zeros((1, 11)), np.zeros((1, 2, 6)), np.zeros((1, 2, 2))
    wheelset, on_rail = np.zeros((1, 6)), np.zeros((1, 2, 3))
    located, forces = np.zeros((1, 2, 2, LOCATED)), np.zeros((1, 2, 2, FORCED))
    grid = fastsim_grid(tables.columns, tables.strips)
    touch = wheel_rail_contact.bind(
        tables, grid, ContactWork.of(1), motion, rails, offsets, wheelset, on_rail, located, forces
    )

    def slope(state):
        row, omega = motion_row(body, state)
        motion[0] = row
        touch()
        return _rates(body, state, row, omega, wheelset, located, forces)

    return slope


def _run(tables, body, state, steps, step, out):
    slope, now = _slope_of(tables, body), state.copy()
    for n in range(steps):
        a = slope(now)
        worst = max(now[WORST_POWER], a[WORK])
        b = slope(now + 0.5 * step * a)
        c = slope(now + 0.5 * step * b)
        d = slope(now + step * c)
        now += step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        now[6:9] /= np.sqrt(np.dot(now[6:9], now[6:9]))
        now[WORST_POWER] = worst
        out[n] = now


def start(body: Wheelset, *, y=0.0, z=0.0, roll=0.0, yaw=0.0, speed, spin) -> np.ndarray:
    """Return a state that rolls along x with ``spin`` about the axle, rad/s."""
    state = np.zeros(14)
    state[:6] = 0.0, y, z, speed, 0.0, 0.0
    state[6:9] = -np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)
    state[9:12] = body.polar * spin * state[6:9]
    return state


def run(contact: WheelRailContact, body: Wheelset, state, *, steps: int, step: float) -> np.ndarray:
    """Return the states after each step, (steps, 14)."""
    out = np.empty((steps, 14))
    _run(contact.tables, body, state, steps, step, out)
    assert np.all(np.isfinite(out))
    return out


def energy(contact: WheelRailContact, body: Wheelset, state: np.ndarray) -> float:
    """Kinetic and potential energy of the wheelset and Hertz's elastic energy, J."""
    row, omega = motion_row(body, state)
    located = contact.evaluate(row[None]).located[0]
    depth = np.maximum(located[..., PENETRATION], 0.0)
    elastic = np.sum(0.4 * located[..., STIFFNESS] * depth**2.5, where=depth > 0.0)
    kinetic = 0.5 * body.mass * state[3:6] @ state[3:6] + 0.5 * omega @ state[9:12]
    return float(kinetic - body.load * state[2] + elastic)
