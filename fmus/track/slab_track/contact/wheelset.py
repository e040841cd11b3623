r"""Contact of a wheelset on two moving rails: geometry, normal forces, creep forces.

Three steps, so that an implicit integrator can put its iteration between them:

1. :func:`locate_wheel` finds the patches of one wheel and their penetrations from the
   motions of wheelset and rail;
2. :func:`normal_force` gives Hertz's force and its derivative for a penetration; in an
   iteration over the relative normal displacement, a relative displacement
   ``(u_y, u_z)`` of wheel less rail changes the penetration by
   ``-sin(g) u_y + cos(g) u_z``;
3. :func:`patch_forces` computes creepages and FASTSIM, :func:`add_resultants` the resultants on
   wheelset and rail.

:func:`wheel_rail_contact` does all three for all wheels. The left wheel is the right one's
mirror image: its motion is mirrored, and so are its forces.

The penetration along the normal is the distance of the relative position from the
first-touch curve ``dz = h(dy)``, which is the envelope of all touching positions:
the foot of the perpendicular is found by one step along the tangent.
"""

import math
from typing import NamedTuple

import numpy as np
from rail_native import Array3, Array4, Matrix, Vector, kernel

from slab_track.contact.creepage import (
    RAIL_ROLL,
    RAIL_Y,
    RAIL_Z,
    ROLL,
    YAW,
    Y,
    Z,
    creepages,
)
from slab_track.contact.fastsim import STRIP_WORK, FastsimGrid, creep_forces
from slab_track.contact.tables import ContactTables, lookup_ellipse, lookup_patch
from slab_track.core import core
from slab_track.kernels.arrays import set_zero

(
    PENETRATION,
    ANGLE,
    ARM_X,
    ARM_Y,
    ARM_Z,
    RAIL_ARM_Y,
    RAIL_ARM_Z,
    STIFFNESS,
    AXIS_RATIO,
    AXIS_SCALE,
    C11,
    C22,
    C23,
) = range(13)
"""Columns of a located patch: normal penetration (m, negative: apart), contact angle in the
track frame (rad), position from the wheelset's centre and from the rail's axis (m), ``K`` of
``N = K d^1.5`` (N/m^1.5), ``a/b``, ``sqrt(a b) / N^(1/3)``, Kalker's coefficients."""

LOCATED = 13

(
    NORMAL_FORCE,
    LONGITUDINAL_FORCE,
    LATERAL_FORCE,
    SPIN_MOMENT,
    LONGITUDINAL_CREEPAGE,
    LATERAL_CREEPAGE,
    SPIN,
    SEMI_AXIS_A,
    SEMI_AXIS_B,
    HELD,
) = range(10)
"""Columns of a patch's forces: N, T_x, T_s (N) and moment about the normal (N.m) on the wheel,
creepages (1) and spin (1/m), semi-axes along and across (m), part of Kalker's slope that adhering
particles account for (1)."""

FORCED = 10

_FAR = -1e-3


class ContactWork(NamedTuple):
    """What the contact computes on its way.

    Attributes
    ----------
    patch, ellipse
        Interpolated columns of the tables, (6,).
    strips
        Of FASTSIM, (STRIP_WORK,).
    direction
        Force on the rail's axis per unit force on a patch, (3,).
    offset
        Lateral and vertical irregularity of a rail, (2,), m.
    rail_free
        Motion of a rail's axis without the wheel's own force, (6,).
    wheelset
        Force and moment of a wheel on the wheelset, (6,).
    last_creep, last_change
        Creep forces of the patches and their changes in the round before, (2,), N.
    other_force
        Forces of the other wheels that a sweep counts with, (w, 2, 3).
    """

    patch: Vector
    ellipse: Vector
    strips: Vector
    direction: Vector
    offset: Vector
    rail_free: Vector
    wheelset: Vector
    last_creep: Vector
    last_change: Vector
    other_force: Array3

    @classmethod
    def of(cls, wheelsets: int) -> "ContactWork":
        """Return it for a number of wheelsets."""
        sizes = (6, 6, STRIP_WORK, 3, 2, 6, 6, 2, 2)
        return cls(*(np.zeros(size) for size in sizes), other_force=np.zeros((wheelsets, 2, 3)))


@kernel
def locate_wheel(tables, work, side, motion, rail, offset, out):
    """Find the patches of one wheel.

    Parameters
    ----------
    tables
        :class:`slab_track.contact.tables.ContactTables`.
    work
        :class:`ContactWork`.
    side
        -1.0 for the left, 1.0 for the right wheel.
    motion
        The wheelset's motion row, shape (11,); its height counts from first touch.
    rail
        Motion of the rail at its axis: y, z, roll and their rates, shape (6,).
    offset
        Lateral and vertical irregularity of the rail (m), shape (2,), track frame.
    out
        Receives the patches, shape (2, LOCATED): tread, flange.

    Returns
    -------
    True if the relative position is inside the tables.
    """
    # Mirrored to the right-hand side.
    y, roll, yaw = side * motion[Y], side * motion[ROLL], side * motion[YAW]
    rail_roll = side * rail[RAIL_ROLL]
    b, radius = tables.half_distance, tables.wheel_radius
    circle_y = math.cos(yaw) * (b * math.cos(roll) - radius * math.sin(roll))
    circle_z = b * math.sin(roll) + radius * math.cos(roll)
    height = motion[Z] + tables.touch_height - radius
    # The rolling circle's lowest point, from the rail's displaced axis, in the rail's frame.
    axis_y = tables.axis_y + side * (rail[RAIL_Y] + offset[0])
    axis_z = tables.axis_z + rail[RAIL_Z] + offset[1]
    from_y, from_z = y + circle_y - axis_y, height + circle_z - axis_z
    cosine, sine = math.cos(rail_roll), math.sin(rail_roll)
    shift = cosine * from_y + sine * from_z + tables.axis_y - b
    drop = cosine * from_z - sine * from_y + tables.axis_z
    inside = True
    description = work.patch
    for patch in range(2):
        found = _locate_patch(tables, work, patch, shift, drop, roll - rail_roll, yaw, out[patch])
        inside = inside and found
        if out[patch, PENETRATION] <= 0.0:
            continue
        # From the rail's frame to the track frame, then to the wheelset's centre.
        # The point is that of the undeformed wheel: rolling radii are undeformed ones.
        angle, depth = out[patch, ANGLE], out[patch, PENETRATION]
        in_y = description[2] - math.sin(angle) * depth - tables.axis_y
        in_z = description[3] + math.cos(angle) * depth - tables.axis_z
        point_y, point_z = cosine * in_y - sine * in_z, sine * in_y + cosine * in_z
        arm_y, arm_z = point_y + axis_y - y, point_z + axis_z - height
        slope = math.tan(angle + rail_roll)
        out[patch, ANGLE] = side * (angle + rail_roll)
        out[patch, ARM_X] = -math.tan(yaw) * (arm_z * slope + arm_y)
        out[patch, ARM_Y], out[patch, ARM_Z] = side * arm_y, arm_z
        out[patch, RAIL_ARM_Y], out[patch, RAIL_ARM_Z] = side * point_y, point_z
    return inside


@kernel
def _locate_patch(tables, work, patch, shift, drop, roll, yaw, out):
    """Penetration, angle and elastic constants of a patch, in the rail's frame (right side)."""
    description = work.patch
    out[PENETRATION] = -1.0
    inside = lookup_patch(tables, patch, shift, roll, 3, description)
    slope = description[1]
    depth = drop - description[0] + _yaw_protrusion(tables, shift, description, yaw)
    if depth < _FAR:
        out[PENETRATION] = depth / math.sqrt(1.0 + slope * slope)
        return inside
    foot = shift + slope * depth / (1.0 + slope * slope)
    lookup_patch(tables, patch, foot, roll, 6, description)
    slope = description[1]
    norm = math.sqrt(1.0 + slope * slope)
    depth = drop - description[0] + _yaw_protrusion(tables, shift, description, yaw)
    penetration = (depth - slope * (shift - foot)) / norm
    out[PENETRATION] = penetration
    out[ANGLE] = math.atan(slope)
    if penetration <= 0.0:
        return inside
    local = tables.wheel_radius + description[3] - drop
    curvature_a, curvature_b = 0.5 / (local * norm), description[4]
    ellipse = work.ellipse
    lookup_ellipse(tables, curvature_a, curvature_b, ellipse)
    mean_radius = 0.5 / math.sqrt(curvature_a * curvature_b)
    stiffness = tables.stiffness_override
    if stiffness == 0.0:
        stiffness = 4.0 / 3.0 * tables.modulus * math.sqrt(mean_radius) * ellipse[2] ** -1.5
    out[STIFFNESS] = description[5] * stiffness
    out[AXIS_RATIO] = math.exp(ellipse[0])
    out[AXIS_SCALE] = (0.75 * mean_radius / tables.modulus) ** (1.0 / 3.0) * ellipse[1]
    out[C11], out[C22], out[C23] = ellipse[3], ellipse[4], ellipse[5]
    return inside


@kernel
def _yaw_protrusion(tables, shift, description, yaw):
    """How much lower a yawed wheel reaches at the patch (m), to second order in yaw."""
    slope = description[1]
    own = description[2] - tables.half_distance - shift
    return 0.5 * yaw * yaw * slope * (tables.wheel_radius * slope + own)


@kernel
def normal_force(stiffness, penetration):
    """Return Hertz's force (N) and its derivative by the penetration (N/m)."""
    if penetration <= 0.0:
        return 0.0, 0.0
    root = stiffness * math.sqrt(penetration)
    return root * penetration, 1.5 * root


@kernel
def patch_forces(tables, grid, work, motion, rail, row, normal, out):
    """Fill ``out`` (FORCED,) with the forces of one patch under a given normal force.

    Parameters
    ----------
    tables, motion, rail
        As for :func:`locate_wheel`.
    grid
        Of FASTSIM, see :func:`slab_track.contact.fastsim.fastsim_grid`.
    work
        :class:`ContactWork`.
    row
        The located patch, shape (LOCATED,).
    normal
        Normal force (N).
    out
        Receives normal and creep forces, creepages and semi-axes.
    """
    set_zero(out)
    if normal <= 0.0 or row[PENETRATION] <= 0.0:
        return
    xi, eta, phi, direction = creepages(
        motion,
        rail,
        row[ARM_X],
        row[ARM_Y],
        row[ARM_Z],
        row[RAIL_ARM_Y],
        row[RAIL_ARM_Z],
        row[ANGLE],
    )
    scale = row[AXIS_SCALE] * normal ** (1.0 / 3.0)
    root = math.sqrt(row[AXIS_RATIO])
    a, b = scale * root, scale / root
    # Rolling backwards: the patch turned by half a turn about its normal.
    t_x, t_s, moment, held = creep_forces(
        grid, work.strips, normal, a, b, row[C11], row[C22], row[C23], tables.shear_modulus,
        tables.friction, direction * xi, direction * eta, phi,
    )  # fmt: skip
    out[NORMAL_FORCE] = normal
    out[LONGITUDINAL_FORCE] = direction * t_x
    out[LATERAL_FORCE] = direction * t_s
    out[SPIN_MOMENT] = moment
    out[LONGITUDINAL_CREEPAGE] = xi
    out[LATERAL_CREEPAGE] = eta
    out[SPIN] = phi
    out[SEMI_AXIS_A] = a
    out[SEMI_AXIS_B] = b
    out[HELD] = held


@kernel
def add_resultants(row, force, wheelset, on_rail):
    """Add a patch's forces on the wheelset (6,) and on the rail's axis (3,).

    ``row`` is the located patch, ``force`` its forces as from :func:`patch_forces`.
    Wheelset: force and moment about its centre, track frame; rail: lateral and vertical
    force and roll moment about its axis.
    """
    normal, t_x, t_s = force[NORMAL_FORCE], force[LONGITUDINAL_FORCE], force[LATERAL_FORCE]
    if normal <= 0.0:
        return
    cosine, sine = math.cos(row[ANGLE]), math.sin(row[ANGLE])
    f_y = cosine * t_s + sine * normal
    f_z = sine * t_s - cosine * normal
    arm_x, arm_y, arm_z = row[ARM_X], row[ARM_Y], row[ARM_Z]
    wheelset[0] += t_x
    wheelset[1] += f_y
    wheelset[2] += f_z
    wheelset[3] += arm_y * f_z - arm_z * f_y
    wheelset[4] += arm_z * t_x - arm_x * f_z - sine * force[SPIN_MOMENT]
    wheelset[5] += arm_x * f_y - arm_y * t_x + cosine * force[SPIN_MOMENT]
    on_rail[0] -= f_y
    on_rail[1] -= f_z
    on_rail[2] -= row[RAIL_ARM_Y] * f_z - row[RAIL_ARM_Z] * f_y


@core.entry
def wheel_rail_contact(
    tables: ContactTables,
    grid: FastsimGrid,
    work: ContactWork,
    motion: Matrix,
    rails: Array3,
    offsets: Array3,
    wheelsets: Matrix,
    on_rails: Array3,
    located: Array4,
    forces: Array4,
) -> bool:
    """Contact of all wheels at an instant.

    Parameters
    ----------
    tables
        :class:`slab_track.contact.tables.ContactTables`.
    grid, work
        As for :func:`patch_forces`.
    motion
        Wheelset motions, shape (n, 11).
    rails
        Motions of the rails' axes at the wheels, shape (n, 2, 6), left first.
    offsets
        Irregularities, lateral and vertical (m), shape (n, 2, 2).
    wheelsets
        Receives force and moment on each wheelset, shape (n, 6).
    on_rails
        Receives force and roll moment on the rails, shape (n, 2, 3).
    located, forces
        Written: the patches, shapes (n, 2, 2, LOCATED) and (n, 2, 2, FORCED).

    Returns
    -------
    True if all relative positions are inside the tables.
    """
    inside = True
    for i in range(motion.shape[0]):
        set_zero(wheelsets[i])
        for k in range(2):
            set_zero(on_rails[i, k])
            side = -1.0 if k == 0 else 1.0
            row = located[i, k]
            found = locate_wheel(tables, work, side, motion[i], rails[i, k], offsets[i, k], row)
            inside = inside and found
            for patch in range(2):
                normal, _ = normal_force(row[patch, STIFFNESS], row[patch, PENETRATION])
                force = forces[i, k, patch]
                patch_forces(tables, grid, work, motion[i], rails[i, k], row[patch], normal, force)
                add_resultants(row[patch], force, wheelsets[i], on_rails[i, k])
    return inside
