r"""Forces between wheels and rails at the end of an internal step.

Rail and contact are solved together, wheel by wheel. A wheel sees its rail as a motion
without its own force plus a constant compliance; what the wheels do to each
other through rails and slabs within one step is tiny and is swept a few times.

Along the normal of each patch Hertz's law is solved by Newton's method. Across it, the creep
force falls with the slip that it causes: a plain iteration would diverge at low
speed. Its slope lies between rD and D, with Kalker's slope D and the part r of it that FASTSIM's
adhering particles account for. So with the mobility c of the rail the change, seen at the old
force, is to be divided by a number between 1 + rDc and 1 + Dc: the middle of both quotients is
taken, and half their distance is the error. Where much slips, r says nothing about the next value,
and the smaller quotient is taken: it never leads too far.
"""

import math

from rail_native import kernel

from slab_track.contact.wheelset import (
    ANGLE,
    C22,
    HELD,
    LATERAL_FORCE,
    PENETRATION,
    RAIL_ARM_Y,
    RAIL_ARM_Z,
    SEMI_AXIS_A,
    SEMI_AXIS_B,
    STIFFNESS,
    add_resultants,
    locate_wheel,
    patch_forces,
)
from slab_track.core import core
from slab_track.kernels.arrays import set_zero

_TOLERANCE = 0.2
"""Largest error of a creep force by its own effect on the rail, N: 3e-6 of the static load."""

_SHIFT = 2e-8
"""Lateral motion of the rail's head, m, after which patches are located anew: it turns the normal
force by some 1e-6 rad, 0.1 N."""

_ITERATIONS = 60
_LOOSEST = 100.0
"""Largest error accepted after many rounds, N: a thousandth of a wheel force."""

_NEARLY_LINEAR = 1.5
"""Ratio of both bounds of the creep force's change up to which their middle is taken."""

_STEEPEST = 1e3
"""Slope of the creep force over its own assumed value that counts as a jump."""

_SLOWEST = 0.1
"""Speed below which Kalker's slope stays, m/s."""


@core.entry
def hertz_force(penetration: float, hertz_constant: float) -> float:
    """Eq. (1): normal force in N from the penetration in m, zero when separated."""
    if penetration <= 0.0:
        return 0.0
    return (penetration / hertz_constant) ** 1.5


@kernel
def implicit_penetration(gap, compliance, stiffness):
    """Solve delta + C K delta^1.5 = gap for delta.

    Newton's method for the root of delta, in which the left side is convex and rising: from
    the right it falls monotonically.
    """
    if gap <= 0.0:
        return gap
    root, slope = math.sqrt(gap), compliance * stiffness
    for _ in range(60):
        excess = root * root * (1.0 + slope * root) - gap
        change = excess / (root * (2.0 + 3.0 * slope * root))
        root -= change
        if change < 1e-15 * root:
            break
    return root * root


@kernel
def contact_forces(approach, same, cross, hertz_constant, force, located):
    """Solve the normal forces of all wheels, and their penetrations, those of their treads.

    ``approach`` (w, 2, 1 or more) has, first, the penetration that the wheels would have on rails
    free of wheel forces; ``same`` and ``cross`` as in
    :class:`slab_track.contact.interaction.Interaction`; ``force`` (w, 2, 2) holds first guesses and
    receives the forces, ``located`` (w, 2, 2, LOCATED) the penetrations. Wheel by wheel the scalar
    law is solved exactly; sweeps account for the small compliance between different wheels.
    """
    count = approach.shape[0]
    stiffness = hertz_constant**-1.5
    for _ in range(50):
        change = 0.0
        for wheel in range(count):
            for side in range(2):
                gap = approach[wheel, side, 0]
                for other in range(count):
                    gap -= same[wheel, other] * force[other, side, 0]
                    gap -= cross[wheel, other] * force[other, 1 - side, 0]
                gap += same[wheel, wheel] * force[wheel, side, 0]
                delta = implicit_penetration(gap, same[wheel, wheel], stiffness)
                new = stiffness * delta * math.sqrt(delta) if delta > 0.0 else 0.0
                change = max(change, abs(new - force[wheel, side, 0]))
                force[wheel, side, 0], located[wheel, side, 0, 0] = new, delta
        if change <= 1e-9:
            break


@kernel
def rail_motion(free, compliance, mobility, force, out):
    """Motion of the rail's axis: y, z, roll and rates, for a force (y, z, roll), into ``out``."""
    for i in range(3):
        out[i], out[3 + i] = free[i], free[3 + i]
        for j in range(3):
            out[i] += compliance[i, j] * force[j]
            out[3 + i] += mobility[i, j] * force[j]


@kernel
def _quadratic_form(matrix, a):
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += a[i] * matrix[i, j] * a[j]
    return total


@kernel
def _normal_direction(row, out):
    """Force on the rail's axis (y, z, roll) per unit normal force of a patch."""
    sine, cosine = math.sin(row[ANGLE]), math.cos(row[ANGLE])
    out[0], out[1] = -sine, cosine
    out[2] = row[RAIL_ARM_Y] * cosine + row[RAIL_ARM_Z] * sine


@kernel
def _lateral_direction(row, out):
    """Force on the rail's axis per unit lateral creep force on the wheel."""
    sine, cosine = math.sin(row[ANGLE]), math.cos(row[ANGLE])
    out[0], out[1] = -cosine, -sine
    out[2] = -(row[RAIL_ARM_Y] * sine - row[RAIL_ARM_Z] * cosine)


@kernel
def solve_wheel(
    tables,
    grid,
    work,
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
    grid, work
        Of FASTSIM, and :class:`slab_track.contact.wheelset.ContactWork`.
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
    last_creep, last_change = work.last_creep, work.last_change
    last_creep[0] = last_creep[1] = last_change[0] = last_change[1] = 0.0
    for round_ in range(_ITERATIONS):
        rail_motion(free, compliance, mobility, force, rail)
        inside = locate_wheel(tables, work, side, motion, rail, offset, located)
        error = _solve_normal(compliance, work.direction, located, force, normal, creep)
        y, roll = rail[0], rail[2]
        rail_motion(free, compliance, mobility, force, rail)
        set_zero(wheelset)
        set_zero(force)
        for patch in range(2):
            row, found = located[patch], forces[patch]
            patch_forces(tables, grid, work, motion, rail, row, normal[patch], found)
            if normal[patch] > 0.0:
                change = found[LATERAL_FORCE] - creep[patch]
                damping = _damping(tables, work.direction, motion, mobility, row, found)
                most, least = 1.0 / (1.0 + found[HELD] * damping), 1.0 / (1.0 + damping)
                part, unsure = least, most - least
                if most < _NEARLY_LINEAR * least:
                    part, unsure = 0.5 * (most + least), 0.5 * unsure
                apart, swing = creep[patch] - last_creep[patch], change - last_change[patch]
                if round_ > 0 and -swing * apart * least > apart * apart:
                    # Steeper than Kalker's slope, as on a flange: the slope seen. FASTSIM's own
                    # force may jump by a per cent where a strip begins to slip earlier: then any
                    # value in the jump is true.
                    part = -apart / swing
                    unsure = part if part * _STEEPEST < 1.0 else 1.0 - part
                last_creep[patch], last_change[patch] = creep[patch], change
                creep[patch] += part * change
                error = max(error, unsure * abs(change))
                found[LATERAL_FORCE] = creep[patch]
                moved = abs(rail[0] - y) + abs(row[RAIL_ARM_Z] * (rail[2] - roll))
                error = max(error, moved / _SHIFT * _TOLERANCE)
            else:
                creep[patch] = 0.0
            add_resultants(row, found, wheelset, force)
        if error <= _tolerance(round_):
            return inside
    return False


@kernel
def _tolerance(round_):
    """Error that ends the iteration, N: it grows where the creep force jumps to and fro."""
    return min(_TOLERANCE * max(1.0, 1.25 ** float(round_ - 12)), _LOOSEST)


@kernel
def _solve_normal(compliance, direction, located, force, normal, creep):
    """Solve Hertz's law along the normals of both patches, with the creep forces as they are.

    Replaces ``normal`` and ``force``. Returns how much the patches disturb each other, N.
    """
    error, lost, touching = 0.0, 0.0, 0
    set_zero(force)
    for patch in range(2):
        row = located[patch]
        before = normal[patch]
        if row[PENETRATION] <= 0.0:
            # The rail springs back without the force: the patch is looked at once more.
            normal[patch] = 0.0
            lost = max(lost, before)
            continue
        _normal_direction(row, direction)
        flexibility = _quadratic_form(compliance, direction)
        gap = row[PENETRATION] + flexibility * before
        depth = implicit_penetration(gap, flexibility, row[STIFFNESS])
        normal[patch] = row[STIFFNESS] * depth * math.sqrt(depth) if depth > 0.0 else 0.0
        touching += 1
        error = max(error, abs(normal[patch] - before))
        for i in range(3):
            force[i] += normal[patch] * direction[i]
        _lateral_direction(row, direction)
        for i in range(3):
            force[i] += creep[patch] * direction[i]
    return max(error, lost) if touching > 1 else lost


@kernel
def _damping(tables, direction, motion, mobility, row, force):
    """D c: fall of the lateral creep force by its own effect on the rail, by Kalker's slope."""
    _lateral_direction(row, direction)
    speed = max(abs(motion[5]), _SLOWEST)
    slope = tables.shear_modulus * force[SEMI_AXIS_A] * force[SEMI_AXIS_B] * row[C22] / speed
    return slope * _quadratic_form(mobility, direction)
