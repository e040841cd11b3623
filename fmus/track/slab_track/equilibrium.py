"""Static equilibrium of wheelsets on the track: heights, forces, displaced rails."""

from typing import NamedTuple

import numpy as np

from slab_track import statics
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.tables import ContactTables
from slab_track.contact.wheelset import wheel_rail_contact
from slab_track.errors import TrackError
from slab_track.lateral import LateralTrack, static_rail
from slab_track.stepping import WheelState
from slab_track.wheels import hertz_force, solve_wheel

_ROUNDS = 200
_TOLERANCE = 1e-7
"""Part of the load that may be missing in the equilibrium."""

_FIRST_APPROACH = 7e-5
"""Guess of the penetration under the static load, m."""

BESIDE_THE_RAILS = (
    "a wheelset stands beside its rails: its lateral displacement or roll angle is beyond 22 mm "
    "or 20 mrad from the rails' own; check wheelset[i].lateral_displacement and "
    "wheelset[i].roll_angle at the start, rail.gauge and the profiles"
)


class RailsAtRest(NamedTuple):
    """Static displacement of the rails under given forces on their axes.

    Attributes
    ----------
    vertical
        Solutions of the symmetric and the antisymmetric class.
    lateral
        Coordinates of both rails, (2, 3, N).
    motion
        Motion of the axes under the wheels, (w, 2, 6); rates are zero.
    """

    vertical: tuple[statics.StaticSolution, statics.StaticSolution]
    lateral: np.ndarray
    motion: np.ndarray


def rails_at_rest(
    track: LinearTrack, lateral: LateralTrack | None, positions: np.ndarray, force: np.ndarray
) -> RailsAtRest:
    """Solve both rails for forces on their axes, (w, 2, 3): lateral, vertical, roll moment.

    ``lateral`` is None for rails that are held laterally and in roll.
    """
    half = np.sqrt(0.5)
    load_s = half * (force[:, 0, 1] + force[:, 1, 1])
    load_a = half * (force[:, 1, 1] - force[:, 0, 1])
    vertical = (
        statics.static_coordinates(track, positions, load_s, SYMMETRIC),
        statics.static_coordinates(track, positions, load_a, ANTISYMMETRIC),
    )
    motion = np.zeros((positions.size, 2, 6))
    motion[:, 0, 1] = half * (vertical[0].deflection - vertical[1].deflection)
    motion[:, 1, 1] = half * (vertical[0].deflection + vertical[1].deflection)
    coordinates = np.zeros((2, 3, track.rail.wave_number.size))
    if lateral is not None:
        for side in (0, 1):
            coordinates[side], found = static_rail(lateral, positions, force[:, side, [0, 2]])
            motion[:, side, 0], motion[:, side, 2] = found[:, 0], found[:, 1]
    return RailsAtRest(vertical, coordinates, motion)


def contact_at(
    tables: ContactTables, motion: np.ndarray, rails: np.ndarray, offsets: np.ndarray
) -> WheelState:
    """Contact of wheelsets at rest on given rails.

    ``motion`` (w, 11) with heights from first touch, ``rails`` (w, 2, 6), ``offsets``
    (w, 2, 2) side and direction (vertical, lateral).
    """
    wheels = WheelState.empty(motion.shape[0])
    inside = wheel_rail_contact(
        tables,
        np.ascontiguousarray(motion),
        np.ascontiguousarray(rails),
        np.ascontiguousarray(offsets[..., ::-1]),
        wheels.wheelset,
        wheels.rail_force,
        wheels.located,
        wheels.forces,
    )
    if not inside:
        raise TrackError(BESIDE_THE_RAILS)
    wheels.normal[:], wheels.creep[:] = wheels.forces[..., 0], wheels.forces[..., 2]
    wheels.rail[:] = rails
    return wheels


def level_contact(
    motion: np.ndarray,
    rails: np.ndarray,
    offsets: np.ndarray,
    half_distance: float,
    hertz_constant: float,
) -> WheelState:
    """As :func:`contact_at` for eq. (1) on a level tread."""
    wheels = WheelState.empty(motion.shape[0])
    lever = half_distance * np.array([-1.0, 1.0])
    height = motion[:, 2, None] + lever * motion[:, 3, None]
    penetration = height - rails[:, :, 1] - offsets[:, :, 0]
    force = np.array([[hertz_force(d, hertz_constant) for d in row] for row in penetration])
    wheels.located[:, :, 0, 0], wheels.forces[:, :, 0, 0] = penetration, force
    wheels.normal[:, :, 0] = wheels.rail_force[:, :, 1] = force
    wheels.rail[:] = rails
    wheels.wheelset[:, 2] = -force.sum(axis=1)
    wheels.wheelset[:, 3] = -force @ lever
    return wheels


def unit_compliance(rest, count: int) -> np.ndarray:
    """Return the static displacement (y, z, roll) of the axes per unit force on them.

    ``rest`` maps rail forces (w, 2, 3) to motions (w, 2, 6), linearly. Returns shape
    (w, 2, 3, w, 2, 3): displaced axis, loaded axis.
    """
    compliance = np.zeros((count, 2, 3, count, 2, 3))
    for wheel, side, direction in np.ndindex(count, 2, 3):
        force = np.zeros((count, 2, 3))
        force[wheel, side, direction] = 1.0
        compliance[:, :, :, wheel, side, direction] = rest(force)[:, :, :3]
    return compliance


def profile_equilibrium(
    tables: ContactTables,
    compliance: np.ndarray,
    motion: np.ndarray,
    offsets: np.ndarray,
    load: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the heights at which every wheelset carries twice ``load`` on its profiles.

    Parameters
    ----------
    tables
        Of the contact.
    compliance
        As from :func:`unit_compliance`.
    motion
        Motion rows (w, 11); their heights do not matter.
    offsets
        Irregularity (w, 2, 2): side, direction (vertical, lateral).
    load
        Static wheel load, N.

    Returns
    -------
    tuple
        Heights (w,), m, and forces on the rails' axes (w, 2, 3).
    """
    count = motion.shape[0]
    wheels, rows = WheelState.empty(count), motion.copy()
    wheels.rail_force[:, :, 1] = wheels.normal[:, :, 0] = load
    own = np.array([compliance[w, s, :, w, s, :] for w in range(count) for s in (0, 1)])
    rails = np.einsum("wsiujk,ujk->wsi", compliance, wheels.rail_force)
    rows[:, 2] = (rails[:, :, 1] + offsets[:, :, 0]).mean(axis=1) + _FIRST_APPROACH
    stiffness = 2.0 / (own[:, 1, 1].reshape(count, 2).mean(axis=1) + _FIRST_APPROACH / load)
    for _ in range(_ROUNDS):
        carried = _sweep(tables, compliance, own, rows, offsets, wheels)
        missing = 2.0 * load - carried
        if np.max(np.abs(missing)) <= _TOLERANCE * load:
            return rows[:, 2].copy(), wheels.rail_force
        rows[:, 2] += missing / stiffness
    raise TrackError(
        f"the static equilibrium was not found: {np.max(np.abs(missing)):g} N are not carried; "
        "check static_wheel_load, the profiles and the wheelsets' lateral displacements"
    )


def _sweep(tables, compliance, own, rows, offsets, wheels) -> np.ndarray:
    """Solve wheel after wheel with the others' forces as they are; return what is carried."""
    carried = np.zeros(rows.shape[0])
    wheelset, nothing = np.zeros(6), np.zeros((3, 3))
    grid = fastsim_grid(tables.columns, tables.strips)
    rails = np.einsum("wsiujk,ujk->wsi", compliance, wheels.rail_force)
    for wheel, side in np.ndindex(rows.shape[0], 2):
        force = wheels.rail_force[wheel, side]
        mine = own[2 * wheel + side]
        free = np.zeros(6)
        free[:3] = rails[wheel, side] - mine @ force
        found = solve_wheel(
            tables,
            grid,
            2.0 * side - 1.0,
            rows[wheel],
            free,
            np.ascontiguousarray(mine),
            nothing,
            np.ascontiguousarray(offsets[wheel, side, ::-1]),
            force,
            wheels.normal[wheel, side],
            wheels.creep[wheel, side],
            wheelset,
            wheels.rail[wheel, side],
            wheels.located[wheel, side],
            wheels.forces[wheel, side],
        )
        if not found:
            raise TrackError(BESIDE_THE_RAILS)
        carried[wheel] -= wheelset[2]
    return carried
