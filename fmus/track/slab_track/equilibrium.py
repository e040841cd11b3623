"""Static equilibrium of wheelsets on the track: heights, forces, displaced rails."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import root_scalar

from slab_track import statics
from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack
from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.interaction import Wheels
from slab_track.contact.solve import hertz_force
from slab_track.contact.tables import LATERAL_LIMIT, ROLL_LIMIT, ContactTables
from slab_track.contact.wheelset import ContactWork, wheel_rail_contact
from slab_track.errors import TrackError
from slab_track.lateral import LateralTrack, static_rail
from slab_track.state import no_wheel_forces

_ROUNDS = 100
_SHORTEST_PART = 1e-3
"""Of a Newton step."""

_RAIL_TOLERANCE = 1e-11
"""Change of the rails' displacement, m or rad, below which the equilibrium is found."""

_DIFFERENCE = 1e-8
"""Of the rails' motion, m or rad, for slopes."""

_SEARCH_LIMIT = 0.05
"""Farthest that a wheelset's height is searched, m."""

_DEEPEST = 1.0
"""Farthest that rails may move under the static load, m: the equations are those of small
deflections, and ballast gives way by some millimetres."""

_FIRST_APPROACH = 7e-5
"""Guess of the penetration under the static load, m."""

BESIDE_THE_RAILS = (
    f"a wheelset stands beside its rails: its lateral displacement or roll angle is beyond "
    f"{LATERAL_LIMIT * 1e3:g} mm or {ROLL_LIMIT * 1e3:g} mrad from the rails' own; check "
    "wheelset[i].lateral_displacement and wheelset[i].roll_angle at the start, rail.gauge "
    "and the profiles"
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


def vertical_at_rest(
    track: LinearTrack, positions: np.ndarray
) -> tuple[statics.StaticTrack, statics.StaticTrack]:
    """Return both symmetry classes with wheels at ``positions`` (w,), m in the window."""
    return (
        statics.StaticTrack(track, positions, SYMMETRIC),
        statics.StaticTrack(track, positions, ANTISYMMETRIC),
    )


def rails_at_rest(
    track: LinearTrack,
    lateral: LateralTrack | None,
    positions: np.ndarray,
    force: np.ndarray,
    prepared: tuple[statics.StaticTrack, statics.StaticTrack] | None = None,
) -> RailsAtRest:
    """Solve both rails for forces on their axes, (w, 2, 3): lateral, vertical, roll moment.

    ``lateral`` is None for rails that are held laterally and in roll; ``prepared`` is what
    :func:`vertical_at_rest` gives, where it is known.
    """
    half = np.sqrt(0.5)
    load_s = half * (force[:, 0, 1] + force[:, 1, 1])
    load_a = half * (force[:, 1, 1] - force[:, 0, 1])
    symmetric, antisymmetric = prepared or vertical_at_rest(track, positions)
    vertical = symmetric.solve(load_s), antisymmetric.solve(load_a)
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
) -> Wheels:
    """Contact of wheelsets at rest on given rails.

    ``motion`` (w, 11) with heights from first touch, ``rails`` (w, 2, 6), ``offsets``
    (w, 2, 2) side and direction (vertical, lateral).
    """
    wheels = no_wheel_forces(motion.shape[0])
    inside = wheel_rail_contact(
        tables,
        fastsim_grid(tables.columns, tables.strips),
        ContactWork.of(motion.shape[0]),
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
    wheels.rail[:], wheels.earlier_force[:] = rails, wheels.rail_force
    return wheels


def level_contact(
    motion: np.ndarray,
    rails: np.ndarray,
    offsets: np.ndarray,
    half_distance: float,
    hertz_constant: float,
) -> Wheels:
    """As :func:`contact_at` for eq. (1) on a level tread."""
    wheels = no_wheel_forces(motion.shape[0])
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


def unit_compliance(rest: Callable[[np.ndarray], np.ndarray], count: int) -> np.ndarray:
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
    wheelsets = [
        _RestingWheelset(tables, motion[w], np.ascontiguousarray(offsets[w, :, ::-1]), 2.0 * load)
        for w in range(count)
    ]
    force = np.zeros((count, 2, 3))
    force[:, :, 1] = load
    rails = np.einsum("wsiujk,ujk->wsi", compliance, force)
    heights = (rails[:, :, 1] + offsets[:, :, 0]).mean(axis=1) + _FIRST_APPROACH
    flexibility = compliance.reshape(6 * count, 6 * count)

    def answer(rails):
        for w, wheelset in enumerate(wheelsets):
            force[w], heights[w] = wheelset.forces(rails[w], heights[w])
        return np.einsum("wsiujk,ujk->wsi", compliance, force) - rails

    error = answer(rails)
    for _ in range(_ROUNDS):
        if np.max(np.abs(error)) <= _RAIL_TOLERANCE:
            return heights, force
        slope = np.zeros((6 * count, 6 * count))
        for w, wheelset in enumerate(wheelsets):
            own = slice(6 * w, 6 * w + 6)
            slope[own, own] = wheelset.slope(rails[w], heights[w])
        change = np.linalg.solve(np.eye(6 * count) - flexibility @ slope, error.ravel())
        change, part = change.reshape(rails.shape), 1.0
        # Newton's method with shorter steps where a flange begins to touch.
        while True:
            try:
                trial = answer(rails + part * change)
            except TrackError:
                if part < _SHORTEST_PART:
                    raise
                trial = np.full_like(error, np.inf)
            if np.max(np.abs(trial)) < np.max(np.abs(error)) or part < _SHORTEST_PART:
                break
            part *= 0.5
        rails, error = rails + part * change, trial
    raise TrackError(
        f"the static equilibrium was not found: the rails still move by "
        f"{np.max(np.abs(error)):g} m; check static_wheel_load, the profiles and the wheelsets' "
        "lateral displacements"
    )


def check_sinking(motion: np.ndarray, load: float) -> None:
    """Refuse rails that carry the load nowhere near where they lie without it.

    Parameters
    ----------
    motion
        Of the rails' axes under the wheels, (w, 2, 6), m and rad.
    load
        Of a wheel, N.

    Raises
    ------
    TrackError
        If they do.
    """
    deepest = float(np.max(np.abs(motion[..., :2]), initial=0.0))
    if not deepest <= _DEEPEST:
        raise TrackError(
            f"under static_wheel_load = {load:g} N the rails move by {deepest:.3g} m, more than "
            f"{_DEEPEST:g} m: such a track carries no vehicle; raise rail.vertical_second_moment, "
            "rail.vertical_shear_coefficient, fastener.vertical_stiffness or "
            "slab_support.vertical_stiffness, or lower the load"
        )


class _RestingWheelset:
    """A wheelset that carries a load on given rails, at the height that this takes."""

    def __init__(self, tables, motion, offsets, load: float) -> None:
        self.row, self.load = motion.copy(), load
        self.wheels = wheels = no_wheel_forces(1)
        self._rails = np.zeros((1, 2, 6))
        self._touch = wheel_rail_contact.bind(
            tables, fastsim_grid(tables.columns, tables.strips), ContactWork.of(1),
            self.row[None], self._rails, offsets[None], wheels.wheelset, wheels.rail_force,
            wheels.located, wheels.forces,
        )  # fmt: skip

    def forces(self, rails: np.ndarray, height: float) -> tuple[np.ndarray, float]:
        """Return the forces on the rails' axes (2, 3) and the height, searched from ``height``."""
        self._rails[0, :, :3] = rails
        wheels = self.wheels

        def excess(z: float) -> float:
            self.row[2] = z
            if not self._touch():
                raise TrackError(BESIDE_THE_RAILS)
            return -wheels.wheelset[0, 2] - self.load

        # The force grows with depth: bracket the height, then close in.
        stride = 1e-6
        down = excess(height) < 0.0
        near = far = height
        while (excess(far) < 0.0) == down:
            near, far = far, far + (stride if down else -stride)
            stride *= 2.0
            if stride > _SEARCH_LIMIT:
                raise TrackError(BESIDE_THE_RAILS)
        bracket = sorted((near, far))
        found = root_scalar(excess, bracket=bracket, method="brentq", xtol=1e-16, rtol=1e-14).root
        excess(found)
        return wheels.rail_force[0].copy(), found

    def slope(self, rails: np.ndarray, height: float) -> np.ndarray:
        """Change of the forces with the rails' motion, (6, 6), by central differences."""
        slope = np.empty((6, 6))
        for i in range(6):
            change = np.zeros(6)
            change[i] = _DIFFERENCE
            sides = [self.forces(rails + s * change.reshape(2, 3), height)[0] for s in (1, -1)]
            slope[:, i] = (sides[0] - sides[1]).ravel() / (2.0 * _DIFFERENCE)
        return slope
