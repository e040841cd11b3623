r"""Forces between wheels and rails at the end of an internal step.

Rail and contact are solved together, wheel by wheel. A wheel sees its rail as a motion
without its own force plus a constant compliance; what the wheels do to each
other through rails and slabs within one step is tiny and is swept a few times.

Along the normal of each patch Hertz's law is solved by Newton's method. Across it, the creep
force falls with the slip that it causes: a plain iteration would diverge at low
speed, so the change is divided by 1 + D c, with Kalker's slope D and the mobility c of the rail.
"""

import math

import numba
import numpy as np

from slab_track.contact.wheelset import (
    ANGLE,
    C22,
    LATERAL_FORCE,
    PENETRATION,
    RAIL_ARM_Y,
    RAIL_ARM_Z,
    SEMI_AXIS_A,
    SEMI_AXIS_B,
    STIFFNESS,
    apply_wheel,
    locate_wheel,
)

_TOLERANCE = 0.1
"""Change of a rail force, N, below which a wheel's iteration ends."""

_ITERATIONS = 60
_SLOWEST = 0.1


@numba.njit(cache=True)
def hertz_force(penetration, hertz_constant):
    """Eq. (1): normal force in N from the penetration in m, zero when separated."""
    if penetration <= 0.0:
        return 0.0
    return (penetration / hertz_constant) ** 1.5


@numba.njit(cache=True)
def _implicit_penetration(gap, compliance, hertz_constant):
    """Solve delta + C (delta/G)^1.5 = gap for delta; the left side is convex and rising."""
    if gap <= 0.0:
        return gap
    delta = gap
    for _ in range(60):
        force = (delta / hertz_constant) ** 1.5
        change = (delta + compliance * force - gap) / (1.0 + 1.5 * compliance * force / delta)
        delta -= change
        if change < 1e-15 * gap:
            break
    return delta


@numba.njit(cache=True)
def contact_forces(approach, compliance_s, compliance_a, start, hertz_constant):
    """Solve the normal forces of all wheels, (wheels, 2), and their penetrations.

    ``approach`` (wheels, 2) is the penetration that the wheels would have on rails
    free of wheel forces. Wheel by wheel the scalar law is solved exactly; sweeps
    account for the small compliance between different wheels.
    """
    count = approach.shape[0]
    same, cross = 0.5 * (compliance_s + compliance_a), 0.5 * (compliance_s - compliance_a)
    force, penetration = start.copy(), np.empty_like(start)
    for _ in range(50):
        change = 0.0
        for wheel in range(count):
            for side in range(2):
                gap = approach[wheel, side]
                for other in range(count):
                    gap -= same[wheel, other] * force[other, side]
                    gap -= cross[wheel, other] * force[other, 1 - side]
                gap += same[wheel, wheel] * force[wheel, side]
                delta = _implicit_penetration(gap, same[wheel, wheel], hertz_constant)
                new = hertz_force(delta, hertz_constant)
                change = max(change, abs(new - force[wheel, side]))
                force[wheel, side], penetration[wheel, side] = new, delta
        if change <= 1e-9:
            break
    return force, penetration


@numba.njit(cache=True)
def rail_motion(free, compliance, mobility, force, out):
    """Motion of the rail's axis: y, z, roll and rates, for a force (y, z, roll), into ``out``."""
    for i in range(3):
        out[i], out[3 + i] = free[i], free[3 + i]
        for j in range(3):
            out[i] += compliance[i, j] * force[j]
            out[3 + i] += mobility[i, j] * force[j]


@numba.njit(cache=True)
def _quadratic_form(matrix, a):
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += a[i] * matrix[i, j] * a[j]
    return total


@numba.njit(cache=True)
def _normal_direction(row, out):
    """Force on the rail's axis (y, z, roll) per unit normal force of a patch."""
    sine, cosine = math.sin(row[ANGLE]), math.cos(row[ANGLE])
    out[0], out[1] = -sine, cosine
    out[2] = row[RAIL_ARM_Y] * cosine + row[RAIL_ARM_Z] * sine


@numba.njit(cache=True)
def _lateral_direction(row, out):
    """Force on the rail's axis per unit lateral creep force on the wheel."""
    sine, cosine = math.sin(row[ANGLE]), math.cos(row[ANGLE])
    out[0], out[1] = -cosine, -sine
    out[2] = -(row[RAIL_ARM_Y] * sine - row[RAIL_ARM_Z] * cosine)


@numba.njit(cache=True)
def solve_wheel(
    tables,
    side,
    motion,
    free,
    compliance,
    mobility,
    offset,
    force,
    normal,
    creep,
    wheelset,
    rail,
    located,
    forces,
):
    """Solve the contact of one wheel with its rail.

    Parameters
    ----------
    tables
        :class:`slab_track.contact.tables.ContactTables`.
    side
        -1.0 left, 1.0 right.
    motion
        The wheelset's motion row, (11,), its height counted from first touch.
    free
        Motion of the rail's axis without this wheel's force: y, z, roll, rates, (6,).
    compliance, mobility
        Displacement and rate of the axis per unit force (y, z, roll), (3, 3).
    offset
        Lateral and vertical irregularity, (2,), m.
    force, normal, creep
        Force on the rail's axis (3,), normal forces and lateral creep forces of the
        patches (2,): start values, replaced by the solution.
    wheelset
        Receives force and moment on the wheelset, (6,).
    rail
        Receives the motion of the rail's axis, (6,).
    located, forces
        Receive the patches, (2, LOCATED) and (2, FORCED).

    Returns
    -------
    bool
        False if the wheel left the contact tables, or no solution was found.
    """
    on_rail, direction = np.empty(3), np.empty(3)
    inside = True
    for iteration in range(_ITERATIONS):
        rail_motion(free, compliance, mobility, force, rail)
        inside = locate_wheel(tables, side, motion, rail, offset, located)
        for patch in range(2):
            row = located[patch]
            if row[PENETRATION] <= 0.0 and normal[patch] == 0.0:
                continue
            _normal_direction(row, direction)
            flexibility = _quadratic_form(compliance, direction)
            if row[PENETRATION] <= 0.0:
                normal[patch] = 0.0
                continue
            gap = row[PENETRATION] + flexibility * normal[patch]
            constant = row[STIFFNESS] ** (-2.0 / 3.0)
            depth = _implicit_penetration(gap, flexibility, constant)
            normal[patch] = hertz_force(depth, constant)
        wheelset[:] = 0.0
        on_rail[:] = 0.0
        apply_wheel(tables, motion, rail, located, normal, wheelset, on_rail, forces)
        change = 0.0
        speed = max(abs(motion[5]), _SLOWEST)
        for patch in range(2):
            row = located[patch]
            new = forces[patch, LATERAL_FORCE]
            _lateral_direction(row, direction)
            slope = (
                tables.shear_modulus
                * forces[patch, SEMI_AXIS_A]
                * forces[patch, SEMI_AXIS_B]
                * row[C22]
                / speed
            )
            damped = slope * _quadratic_form(mobility, direction)
            relaxed = creep[patch] + (new - creep[patch]) / (1.0 + damped)
            for i in range(3):
                on_rail[i] += (relaxed - new) * direction[i]
            creep[patch] = relaxed
        for i in range(3):
            change = max(change, abs(on_rail[i] - force[i]))
            force[i] = on_rail[i]
        if change < _TOLERANCE and iteration > 0:
            return inside
    return False
