r"""Contact geometry of a wheelset: table over the lateral displacement, equivalent conicity.

References
----------
UIC 519 and EN 15302: equivalent conicity from the wavelength of the kinematic motion
``y'' = -(r_right - r_left) / (e r_0)`` of a wheelset, non-linear in y.
"""

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray
from rail_quantities import ParameterError
from scipy.integrate import cumulative_simpson
from scipy.interpolate import BSpline, PchipInterpolator, make_interp_spline
from scipy.optimize import root_scalar

from slab_track.contact.geometry import ContactGeometry
from slab_track.contact.overlap import HEIGHT, RAIL_Y, RAIL_Z, SLOPE

FloatArray = NDArray[np.float64]
LEFT, RIGHT = 0, 1


@dataclasses.dataclass(frozen=True, kw_only=True)
class ContactTable:
    """Contact of a wheelset over its lateral displacement; sides as columns, left first.

    Attributes
    ----------
    lateral_displacement
        To the right (m), shape (n,).
    roll_angle, vertical_displacement
        With both wheels touching (rad; m, down, from the centred wheelset), shape (n,).
    rolling_radius_difference
        Right less left wheel (m), shape (n,).
    contact_angle
        Inclination of the tangent plane (rad), positive towards the flange, shape (n, 2).
    wheel_position
        Outwards from the rolling circle (m), shape (n, 2).
    rail_position
        Outwards from the top of the inclined rail head (m), shape (n, 2).
    """

    lateral_displacement: FloatArray
    roll_angle: FloatArray
    vertical_displacement: FloatArray
    rolling_radius_difference: FloatArray
    contact_angle: FloatArray
    wheel_position: FloatArray
    rail_position: FloatArray


def contact_table(geometry: ContactGeometry, lateral_displacement: FloatArray) -> ContactTable:
    """Return where a wheelset, resting on both rails, touches them.

    Parameters
    ----------
    geometry
        Wheel on rail; its ``reference_penetration`` decides between rigid contact
        points (about 1e-6 m) and those of a loaded, elastic contact.
    lateral_displacement
        To the right (m), shape (n,).
    """
    rows = [_resting(geometry, float(y)) for y in lateral_displacement]
    crown = float(geometry.rail.lateral[np.argmin(geometry.rail.height)])
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    roll, vertical, patches, wheels, radii = columns
    return ContactTable(
        lateral_displacement=np.asarray(lateral_displacement, dtype=float),
        roll_angle=roll,
        vertical_displacement=vertical,
        rolling_radius_difference=radii[:, RIGHT] - radii[:, LEFT],
        contact_angle=-np.arctan(patches[:, :, SLOPE]),
        wheel_position=wheels,
        rail_position=patches[:, :, RAIL_Y] - crown,
    )


def _resting(
    geometry: ContactGeometry, lateral: float
) -> tuple[float, float, FloatArray, FloatArray, FloatArray]:
    """Roll, height, patches, positions and radii with both wheels touching."""

    def heights(roll: float) -> FloatArray:
        return np.array(
            [_touching_height(geometry, side * lateral, side * roll) for side in (-1, 1)]
        )

    def excess(roll: float) -> float:
        left, right = heights(roll)
        return float(left - right)

    roll = root_scalar(excess, bracket=(-0.03, 0.03), xtol=1e-10).root
    patches = np.array([_patch(geometry, side * lateral, side * roll)[0] for side in (-1, 1)])
    wheels, radii = _wheel_points(geometry, lateral, roll, patches)
    centred = _touching_height(geometry, 0.0, 0.0)
    return roll, float(np.mean(heights(roll))) - centred, patches, wheels, radii


def _patch(geometry: ContactGeometry, lateral: float, roll: float) -> tuple[FloatArray, float]:
    """First patch of the right wheel, and the height of its rolling circle above the centre's."""
    b, radius = geometry.rolling_circle, geometry.placement.wheel_radius
    shift = lateral + b * (math.cos(roll) - 1.0) - radius * math.sin(roll)
    lowering = b * math.sin(roll) + radius * (math.cos(roll) - 1.0)
    return geometry.first_patch(shift, roll), lowering


def _touching_height(geometry: ContactGeometry, lateral: float, roll: float) -> float:
    """Height of the wheelset's centre (m, down) at which the right wheel touches."""
    patch, lowering = _patch(geometry, lateral, roll)
    return float(patch[HEIGHT]) - lowering


def _wheel_points(
    geometry: ContactGeometry, lateral: float, roll: float, patches: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Positions on the wheels from their rolling circles, and rolling radii, both (2,)."""
    b, radius = geometry.rolling_circle, geometry.placement.wheel_radius
    positions, radii = np.empty(2), np.empty(2)
    for k, side in enumerate((-1.0, 1.0)):
        phi = side * roll
        height = _touching_height(geometry, side * lateral, phi) - radius
        y = patches[k, RAIL_Y] - side * lateral
        z = patches[k, RAIL_Z] - height
        positions[k] = math.cos(phi) * y + math.sin(phi) * z - b
        radii[k] = radius + float(geometry.wheel.profile.derivative(positions[k]))
    return positions, radii


def equivalent_conicity(
    lateral_displacement: FloatArray,
    rolling_radius_difference: FloatArray,
    *,
    amplitude: float = 3e-3,
) -> float:
    """Return the equivalent conicity from the wavelength of the non-linear kinematic motion.

    It is the cone's tangent for which ``lambda = 2 pi sqrt(e r_0 / (2 tan gamma_e))`` is the
    wavelength of ``y'' = -(r_right - r_left) / (e r_0)`` between turning points
    ``2 amplitude`` apart; ``e r_0`` cancels.

    Parameters
    ----------
    lateral_displacement, rolling_radius_difference
        As in :class:`ContactTable` (m), shape (n,), ascending displacement.
    amplitude
        Half the distance of the turning points (m).

    Raises
    ------
    ParameterError
        If the table does not reach both turning points, or if the motion does not run from one
        to the other: the radius differences of a hollow wheel steer it away from the centre.
    """
    fine = np.linspace(lateral_displacement[0], lateral_displacement[-1], 20001)
    difference = PchipInterpolator(lateral_displacement, rolling_radius_difference)(fine)
    # Potential of the motion; its two turning points have the same value.
    potential = cumulative_simpson(difference, x=fine, initial=0.0)
    potential = make_interp_spline(fine, potential - potential.min(), k=3)
    low, high = fine[0], fine[-1]

    def level(left: FloatArray | float) -> FloatArray:
        return potential(left + 2.0 * amplitude) - potential(left)

    lefts = fine[fine <= high - 2.0 * amplitude]
    crossings = np.flatnonzero(np.diff(np.sign(level(lefts))))
    if crossings.size == 0:
        raise ParameterError(
            "amplitude",
            amplitude,
            f"no turning points {2e3 * amplitude:g} mm apart between {1e3 * low:g} and "
            f"{1e3 * high:g} mm",
            "give a table over a wider range of lateral displacements, or a smaller amplitude",
        )
    # A hollow tread has several pairs of turning points: that about the centre is meant.
    nearest = crossings[np.argmin(np.abs(lefts[crossings] + amplitude))]
    left = root_scalar(level, bracket=lefts[nearest : nearest + 2], xtol=1e-12).root
    return _conicity_between(potential, left, amplitude)


def _conicity_between(potential: BSpline, left: float, amplitude: float) -> float:
    """Conicity from the wavelength between the turning points ``left + (0, 2 amplitude)``."""
    # y = middle + amplitude sin(theta) removes the singularity at the turning points.
    node, weight = np.polynomial.legendre.leggauss(400)
    theta = 0.5 * math.pi * node
    y = left + amplitude * (1.0 + np.sin(theta))
    energy = float(potential(left)) - potential(y)
    if energy.min() <= 0.0:
        barrier = y[int(np.argmin(energy))]
        raise ParameterError(
            "amplitude",
            amplitude,
            f"no kinematic motion between turning points at {1e3 * left:.2f} and "
            f"{1e3 * (left + 2.0 * amplitude):.2f} mm: the rolling radius difference steers the "
            f"wheelset away from {1e3 * barrier:.2f} mm (hollow tread)",
            "the equivalent conicity may be defined at another amplitude",
        )
    speed = np.sqrt(2.0 * energy)  # y' sqrt(e r_0)
    half_wave = float(np.sum(0.5 * math.pi * weight * amplitude * np.cos(theta) / speed))
    return 0.5 * (math.pi / half_wave) ** 2
