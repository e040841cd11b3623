r"""Where a wheel touches a rail: placed profiles, first touch, contact patches.

All in the section across the track, for the right-hand wheel and rail (mirror
images for the left). With the wheel's rolling circle moved by ``dy`` (outwards)
and ``dz`` (down) and turned by ``roll`` against the rail, the gap over the lateral
coordinate y of the rail is ``z_r(y) - z_w(y - dy) - dz``; the wheel touches first at
``dz = h(dy, roll) = min(z_r - z_w)``.

The wheel's flange (beyond ``FLANGE_ANGLE``) and its tread are searched
separately, which gives up to two patches.
Each patch is an average over its width, see :mod:`slab_track.contact.overlap`.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rail_quantities import ParameterError

from slab_track.contact.overlap import COLUMN_COUNT, FLANGE, HEIGHT, TREAD, overlap_patch
from slab_track.contact.profiles import FloatArray, Profile

FLANGE_ANGLE = 0.70
"""Inclination of the wheel profile at which its flange begins (rad)."""

_ABSENT = -1.0
_LOWEST_FLANGE = -0.055
_OUTSIDE = 0.060
_RAIL_DEPTH = 0.020


@dataclasses.dataclass(frozen=True, kw_only=True)
class RailPlacement:
    """How rails and wheels stand to each other in the undeformed track.

    Attributes
    ----------
    gauge
        Distance of the rails' inner faces (m), measured ``gauge_depth`` below the heads (m).
    cant
        Inclination of each rail towards the track's centre (1/40: 0.025).
    rolling_circle_distance
        Distance of the rolling circles of a wheelset (m).
    wheel_radius
        Nominal rolling radius (m).
    axis_depth
        Depth of the axis, about which a rail rolls, below its head (m).
    """

    gauge: float = 1.435
    gauge_depth: float = 0.014
    cant: float = 0.025
    rolling_circle_distance: float = 1.493
    wheel_radius: float = 0.46
    axis_depth: float = 0.095


class WheelSection(NamedTuple):
    """Lowest line of a wheel seen along the track, on points of the section.

    Attributes
    ----------
    height
        z below the rolling circle (m), -1 where there is no wheel.
    angle
        Inclination, arctan(dz/dy) (rad).
    flange
        True where the point belongs to the flange.
    """

    height: FloatArray
    angle: FloatArray
    flange: NDArray[np.bool_]


class PlacedRail:
    """A rail's running surface, inclined and set to gauge, on an equidistant grid.

    Attributes
    ----------
    lateral, height, angle
        y from the track's centre (m), z below the highest point (m), arctan(dz/dy) (rad);
        shape (n,).
    spacing
        Distance of the points (m).
    axis
        y and z of the rail's axis of roll (m).
    """

    def __init__(self, profile: Profile, placement: RailPlacement, spacing: float = 5e-5) -> None:
        angle = math.atan(placement.cant)
        own = np.linspace(profile.start, profile.end, 4001)
        y, z = _turned(own, profile.derivative(own), -angle)
        top = float(np.min(z))
        z_face = z[y < y[np.argmin(z)]] - top
        if z_face.max() < placement.gauge_depth:
            raise ParameterError(
                "rail.gauge_measurement_depth",
                placement.gauge_depth,
                f"the profile {profile.name} ends {z_face.max():g} m below the head",
                "measure the gauge higher, or give a profile with more of its inner face",
            )
        face = self._face(own, y, z - top, placement.gauge_depth)
        shift = 0.5 * placement.gauge - face
        inner = self._face(own, y, z - top, min(_RAIL_DEPTH, 0.999 * float(z_face[0])))
        outer = float(np.max(y))
        self.spacing = spacing
        grid = np.arange(math.ceil(inner / spacing), math.floor(outer / spacing)) * spacing
        local = np.interp(grid, y, own)
        for _ in range(4):  # Newton: local coordinate whose turned y is on the grid.
            y_now, _ = _turned(local, profile.derivative(local), -angle)
            slope = profile.derivative(local, 1)
            local = np.clip(
                local - (y_now - grid) / (math.cos(angle) + math.sin(angle) * slope),
                profile.start,
                profile.end,
            )
        _, z_now = _turned(local, profile.derivative(local), -angle)
        slope = profile.derivative(local, 1)
        self.lateral = np.asarray(grid + shift, dtype=np.float64)
        self.height = z_now - top
        self.angle = np.arctan(slope) - angle
        axis_y, axis_z = _turned(np.array([0.0]), np.array([placement.axis_depth]), -angle)
        self.axis = (float(axis_y[0]) + shift, float(axis_z[0]) - top)

    @staticmethod
    def _face(own: FloatArray, y: FloatArray, z: FloatArray, depth: float) -> float:
        """Lateral coordinate of the inner face at a depth below the head."""
        crown = int(np.argmin(z))
        return float(np.interp(-depth, -z[:crown], y[:crown]))


def _turned(y: FloatArray, z: FloatArray, angle: float) -> tuple[FloatArray, FloatArray]:
    """Rotate points about x (y towards z) by ``angle``."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * y - sine * z, sine * y + cosine * z


class Wheel:
    """A wheel as a body of revolution, seen in the section across the track."""

    def __init__(self, profile: Profile, placement: RailPlacement) -> None:
        self.profile = profile
        self.radius = placement.wheel_radius
        start = max(profile.start, _LOWEST_FLANGE)
        self.own = np.linspace(start, min(profile.end, _OUTSIDE), 6001)
        steep = np.arctan(-profile.derivative(self.own, 1)) > FLANGE_ANGLE
        inner = steep & (self.own < -0.02)
        self.flange_start = float(self.own[inner].max()) if inner.any() else start

    def section(self, lateral: FloatArray, roll: float, yaw: float = 0.0) -> WheelSection:
        """Return the wheel's lowest line at ``lateral`` (m, from the rolling circle).

        The wheel is turned by ``roll`` and ``yaw`` (rad) about the rolling circle's lowest
        point. With yaw the lowest line is that of the points whose normal has no
        component along the track; they lie before or behind the axle by
        ``R tan(yaw) (dz/dy)``.
        """
        y, _ = self._silhouette(self.own, roll, yaw)
        # Where the line turns back (flange back in yaw) only its lower branch counts.
        order = np.argsort(y, kind="stable")
        own = np.interp(lateral, y[order], self.own[order])
        y_now, height = self._silhouette(own, roll, yaw)
        angle = np.arctan(self.profile.derivative(own, 1)) + roll
        # Interpolation leaves some nanometres along the profile.
        height = height + np.tan(angle) * (lateral - y_now)
        outside = (lateral < y.min()) | (lateral > y.max())
        return WheelSection(
            height=np.where(outside, _ABSENT, height),
            angle=angle,
            flange=own < self.flange_start,
        )

    def _silhouette(
        self, own: FloatArray, roll: float, yaw: float
    ) -> tuple[FloatArray, FloatArray]:
        own = np.clip(own, self.own[0], self.own[-1])
        depth = self.profile.derivative(own)
        if yaw == 0.0:
            return _turned(own, depth, roll)
        radius = self.radius + depth
        slope = self.profile.derivative(own, 1)
        sine = -math.tan(yaw) * (slope * math.cos(roll) + math.sin(roll))
        sine = np.clip(sine, -0.9, 0.9)
        down = radius * np.sqrt(1.0 - sine**2) - self.radius
        y, z = _turned(own, down, roll)
        # Lateral offset of points before the axle; the origin is turned with the wheelset.
        return math.cos(yaw) * y + radius * sine * math.sin(yaw), z


class ContactGeometry:
    """A wheel on a rail: contact at any relative position, without tables.

    Parameters
    ----------
    wheel, rail
        Profiles.
    placement
        Gauge, inclination, rolling circles.
    reference_penetration
        Overlap over which the patch is averaged (m); see the module's text.
    spacing
        Distance of the section's points (m).
    """

    def __init__(
        self,
        wheel: Profile,
        rail: Profile,
        placement: RailPlacement,
        *,
        reference_penetration: float = 7e-5,
        spacing: float = 1e-5,
    ) -> None:
        self.placement = placement
        self.reference_penetration = reference_penetration
        self.rail = PlacedRail(rail, placement, spacing)
        self.wheel = Wheel(wheel, placement)
        self.rolling_circle = 0.5 * placement.rolling_circle_distance

    def patches(self, lateral: float, roll: float = 0.0, yaw: float = 0.0) -> FloatArray:
        """Return both patches of the right-hand wheel, shape (2, COLUMN_COUNT).

        ``lateral`` is the outward shift (m) of the wheel's rolling circle from its place
        on the centred wheelset, ``roll`` and ``yaw`` the wheel's angles against the rail (rad).
        A row of NaN means that the zone has no point at all.
        """
        rail = self.rail
        section = self.wheel.section(rail.lateral - self.rolling_circle - lateral, roll, yaw)
        result = np.full((2, COLUMN_COUNT), np.nan)
        for patch, zone in ((TREAD, ~section.flange), (FLANGE, section.flange)):
            overlap_patch(
                rail.height,
                rail.angle,
                rail.lateral,
                section.height,
                section.angle,
                zone.astype(np.int64),
                rail.spacing,
                self.reference_penetration,
                result[patch],
            )
        return result

    def first_patch(self, lateral: float, roll: float = 0.0, yaw: float = 0.0) -> FloatArray:
        """Return the patch that touches first, shape (COLUMN_COUNT,)."""
        both = self.patches(lateral, roll, yaw)
        return both[int(np.nanargmin(both[:, HEIGHT]))]
