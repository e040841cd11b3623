r"""A contact patch as an average over the strip in which two profiles overlap.

A tangent point jumps where profiles are nearly conformal. A real contact
has a width, so position, angle and curvature are averages over the strip in which the
profiles would overlap at a *reference penetration* (that of the static load):

.. math:: \bar q = \frac{\int p^{3/2} q\,ds}{\int p^{3/2}\,ds},\qquad
          p = d - s \cos\gamma,\qquad
          B = \frac{d'}{(\frac34 \int p'/d'\,ds)^2},\; d' = 0.55 d

with the vertical separation s, overlap p, and 0.55 the share of the approach that fits the
width of a Hertzian contact. For constant curvature this is exact at any d; for ``d -> 0``
it is the rigid contact point with its local curvature.

References
----------
W. Kik, J. Piotrowski, A fast approximate method to calculate normal load at
contact between wheel and rail, 1996 (overlap 0.55). E. Vollebregt, Detailed
wheel/rail geometry processing using the planar contact approach, Vehicle
System Dynamics 60 (2022), 1253-1291 (position weighted by overlap).
"""

import math

from rail_native import Indices, Vector

from slab_track.core import core

TREAD, FLANGE = 0, 1
"""Patch indices."""

HEIGHT, SLOPE, RAIL_Y, RAIL_Z, CURVATURE, SHARE = range(6)
"""Columns of a patch description: height of first touch (m), tan of the contact
angle, position on the rail (m, m), half of the relative curvature across (1/m), share."""

COLUMN_COUNT = 6

_VIRTUAL_SHARE = 0.55
_STEEPEST = 10.0
# Patches that meet at the flange's beginning carry two halves of one ellipse; half
# an ellipse of half the width is about 0.7 as stiff, so they must not count fully.
_MEETING_SHARE = 0.7


@core.entry
def overlap_patch(
    rail_z: Vector,
    rail_angle: Vector,
    rail_y: Vector,
    wheel_z: Vector,
    wheel_angle: Vector,
    inside: Indices,
    spacing: float,
    depth: float,
    out: Vector,
) -> bool:
    """Describe one patch; arguments are arrays over the same points of the section.

    Parameters
    ----------
    rail_z, rail_angle, rail_y, wheel_z, wheel_angle
        The profiles (m, rad), shape (n,).
    inside
        1 for the points that belong to the patch's zone, else 0.
    spacing, depth
        Distance of the points and reference penetration (m).
    out
        Receives the :data:`COLUMN_COUNT` columns.

    Returns
    -------
    True if the zone has a point of contact.
    """
    count = rail_z.size
    best, lowest = -1, 1.0
    for i in range(count):
        if inside[i] != 0 and wheel_z[i] > -0.5 and rail_z[i] - wheel_z[i] < lowest:
            lowest = rail_z[i] - wheel_z[i]
            best = i
    if best < 0:
        return False
    if 0 < best < count - 1 and inside[best - 1] * inside[best + 1] != 0:
        before = rail_z[best - 1] - wheel_z[best - 1] - lowest
        after = rail_z[best + 1] - wheel_z[best + 1] - lowest
        bend = before + after
        if bend > 0.0 and wheel_z[best - 1] > -0.5 and wheel_z[best + 1] > -0.5:
            lowest -= 0.125 * (before - after) ** 2 / bend
    total = sum_y = sum_z = sum_angle = area = 0.0
    virtual = _VIRTUAL_SHARE * depth
    edge = -1.0
    for i in range(count):
        if inside[i] == 0 or wheel_z[i] < -0.5:
            continue
        vertical = rail_z[i] - wheel_z[i] - lowest
        ends = i == 0 or i == count - 1 or inside[i - 1] * inside[i + 1] == 0
        if vertical > _STEEPEST * depth and not ends:
            continue  # No overlap at any inclination that a patch can have.
        angle = 0.5 * (rail_angle[i] + wheel_angle[i])
        cosine = math.cos(angle)
        separation = vertical * cosine
        if ends and (edge < 0.0 or separation < edge):
            edge = separation
        overlap = depth - separation
        if overlap <= 0.0:
            continue
        length = spacing / cosine
        weight = overlap * math.sqrt(overlap) * length
        total += weight
        sum_y += weight * rail_y[i]
        sum_z += weight * rail_z[i]
        sum_angle += weight * angle
        if separation < virtual:
            area += (virtual - separation) * length
    half_width = 0.75 * area / virtual
    out[HEIGHT] = lowest
    out[SLOPE] = math.tan(sum_angle / total)
    out[RAIL_Y] = sum_y / total
    out[RAIL_Z] = sum_z / total
    out[CURVATURE] = virtual / half_width**2
    prominence = min(max(edge / depth, 0.0), 1.0)
    out[SHARE] = _MEETING_SHARE + (1.0 - _MEETING_SHARE) * prominence
    return True
