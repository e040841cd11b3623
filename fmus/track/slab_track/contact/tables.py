"""Tables of the contact for time integration, and their smooth interpolation.

Patches are tabulated over the wheel's outward shift and its roll against the
rail; ellipse factors and Kalker's coefficients over the ratio of curvatures.
Interpolation is by Catmull-Rom splines (once continuously differentiable).
"""

import functools
import hashlib
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rail_native import Array3, Array4, IndexMatrix, Matrix, Vector, kernel
from rail_quantities import kept_array

from slab_track.contact.geometry import ContactGeometry
from slab_track.contact.hertz import contact_modulus, hertz_factors
from slab_track.contact.kalker import kalker_coefficients
from slab_track.contact.overlap import COLUMN_COUNT, HEIGHT, overlap_patch
from slab_track.contact.parameters import ContactParameters, Steel
from slab_track.contact.profile_file import load_profile
from slab_track.core import core

LATERAL_LIMIT = 0.022
"""Largest tabulated shift of a wheel against its rail (m)."""

ROLL_LIMIT = 0.040
"""Largest tabulated roll of a wheel against its rail (rad)."""

_PACKAGE = Path(__file__).parents[1]
_LATERAL_STEPS = 880
_ROLL_STEPS = 80
_RATIO_LIMIT = 9.0
_RATIO_COUNT = 361


class ContactTables(NamedTuple):
    """Everything that the contact needs while running; plain arrays and numbers.

    Attributes
    ----------
    patch
        Shape (2, rolls, shifts, COLUMN_COUNT): see :mod:`slab_track.contact.overlap`.
    lateral_start, lateral_step, roll_start, roll_step
        Grid of ``patch`` (m, rad).
    ellipse
        Shape (ratios, 6) at equidistant ``ln(A/B)``: ``ln(a/b)``, F_1, F_2, C11, C22, C23.
    ratio_start, ratio_step
        Grid of ``ellipse``.
    half_distance, wheel_radius
        Half the distance of the rolling circles and their radius (m).
    touch_height
        Lowest point of the centred wheels' rolling circles at first touch (m): heights
        of wheelsets count from there.
    axis_y, axis_z
        Place of the right rail's axis of roll (m).
    modulus, shear_modulus
        Contact modulus E* and shear modulus (Pa).
    stiffness_override
        ``K`` of ``N = K d^1.5`` from ``contact.hertz_constant`` (N/m^1.5); 0 if the profiles rule.
    friction
        Coefficient of friction.
    columns, strips
        FASTSIM grid.
    """

    patch: Array4
    lateral_start: float
    lateral_step: float
    roll_start: float
    roll_step: float
    ellipse: Matrix
    ratio_start: float
    ratio_step: float
    half_distance: float
    wheel_radius: float
    touch_height: float
    axis_y: float
    axis_z: float
    modulus: float
    shear_modulus: float
    stiffness_override: float
    friction: float
    columns: int
    strips: int


def build_tables(
    parameters: ContactParameters,
    *,
    gauge: float = 1.435,
    gauge_measurement_depth: float = 0.014,
    cant: float = 0.025,
    rail_axis_depth: float = 0.095,
    steel: Steel | None = None,
) -> ContactTables:
    """Return the tables of a wheelset on a track (about a second; the last ones are kept).

    Parameters
    ----------
    parameters
        The group ``contact``.
    gauge, gauge_measurement_depth, cant
        The track's (m, m, 1): ``rail.gauge`` and so on.
    rail_axis_depth
        Depth below the head of the axis to which a rail's displacement and roll refer (m).
    steel
        Elastic constants of wheel and rail.

    Raises
    ------
    ParameterError
        If a profile is unknown, unreadable, or too short.
    """
    placement = (gauge, gauge_measurement_depth, cant, rail_axis_depth)
    files = tuple(_file_state(name) for name in (parameters.wheel_profile, parameters.rail_profile))
    return _build_tables(parameters, placement, steel or Steel(), files)


def _file_state(name: str) -> bytes | None:
    """Return the digest of a profile's file; ``None`` for a built-in profile."""
    try:
        return hashlib.sha256(Path(name).read_bytes()).digest()
    except (OSError, ValueError):
        return None


@functools.lru_cache(maxsize=2)  # runs at several speeds in one process, as in a sweep
def _build_tables(
    parameters: ContactParameters, placement: tuple[float, ...], steel: Steel, files: tuple
) -> ContactTables:
    geometry = ContactGeometry(
        load_profile("wheel", parameters.wheel_profile, parameters.profile_noise),
        load_profile("rail", parameters.rail_profile, parameters.profile_noise),
        parameters.placement(*placement),
        reference_penetration=parameters.reference_penetration,
        spacing=2.0 * LATERAL_LIMIT / _LATERAL_STEPS,
    )
    key = (parameters, placement, files)
    patch = kept_array("contact", key, lambda: tabulate_patches(geometry), _PACKAGE)
    constant = parameters.hertz_constant
    return ContactTables(
        patch=patch,
        lateral_start=-LATERAL_LIMIT,
        lateral_step=2.0 * LATERAL_LIMIT / _LATERAL_STEPS,
        roll_start=-ROLL_LIMIT,
        roll_step=2.0 * ROLL_LIMIT / _ROLL_STEPS,
        ellipse=tabulate_ellipse(steel.poisson_ratio),
        ratio_start=-_RATIO_LIMIT,
        ratio_step=2.0 * _RATIO_LIMIT / (_RATIO_COUNT - 1),
        half_distance=geometry.rolling_circle,
        wheel_radius=parameters.wheel_radius,
        touch_height=float(np.min(patch[:, _ROLL_STEPS // 2, _LATERAL_STEPS // 2, 0])),
        axis_y=geometry.rail.axis[0],
        axis_z=geometry.rail.axis[1],
        modulus=contact_modulus(steel.youngs_modulus, steel.poisson_ratio),
        shear_modulus=0.5 * steel.youngs_modulus / (1.0 + steel.poisson_ratio),
        stiffness_override=constant**-1.5 if constant > 0.0 else 0.0,
        friction=parameters.friction_coefficient,
        columns=parameters.fastsim_columns,
        strips=parameters.fastsim_strips,
    )


def tabulate_patches(geometry: ContactGeometry) -> NDArray[np.float64]:
    """Return the patches at all nodes, shape (2, rolls, shifts, COLUMN_COUNT)."""
    rail, step = geometry.rail, geometry.rail.spacing
    half = _LATERAL_STEPS // 2
    # Shifts are multiples of the spacing: the wheel is sampled once per roll.
    count = rail.lateral.size + _LATERAL_STEPS
    first = rail.lateral[0] - geometry.rolling_circle - half * step
    lateral = first + step * np.arange(count)
    rolls = np.linspace(-ROLL_LIMIT, ROLL_LIMIT, _ROLL_STEPS + 1)
    table = np.empty((2, rolls.size, _LATERAL_STEPS + 1, COLUMN_COUNT))
    found = np.empty((2, _LATERAL_STEPS + 1), dtype=np.int64)
    patches = np.empty((2, _LATERAL_STEPS + 1, COLUMN_COUNT))
    for row, roll in enumerate(rolls):
        section = geometry.wheel.section(lateral, float(roll))
        zone = np.stack([~section.flange, section.flange]).astype(np.int64)
        _fill_row(
            rail.height,
            rail.angle,
            rail.lateral,
            section.height,
            section.angle,
            zone,
            step,
            geometry.reference_penetration,
            found,
            patches,
        )
        table[:, row] = patches
    return table


@core.entry
def _fill_row(
    rail_z: Vector,
    rail_angle: Vector,
    rail_y: Vector,
    wheel_z: Vector,
    wheel_angle: Vector,
    zone: IndexMatrix,
    spacing: float,
    depth: float,
    found: IndexMatrix,
    out: Array3,
) -> None:
    """Write ``out`` (2, shifts, columns), and where there are patches, for one roll angle."""
    shifts, count = out.shape[1], rail_z.size
    for shift in range(shifts):
        # A wheel shifted outwards meets the rail with points nearer to its flange.
        first = shifts - 1 - shift
        z, angle = wheel_z[first : first + count], wheel_angle[first : first + count]
        for patch in range(2):
            inside = zone[patch, first : first + count]
            is_found = overlap_patch(
                rail_z, rail_angle, rail_y, z, angle, inside, spacing, depth, out[patch, shift]
            )
            found[patch, shift] = 1 if is_found else 0
    for patch in range(2):
        _continue_ends(found[patch], out[patch])


@kernel
def _continue_ends(found, out):
    """Where profiles are beside each other, repeat the nearest patch: it never touches."""
    count = found.size
    for shift in range(count):
        if found[shift] != 0:
            continue
        near = -1
        for reach in range(1, count):
            if shift >= reach and found[shift - reach] != 0:
                near = shift - reach
                break
            if shift + reach < count and found[shift + reach] != 0:
                near = shift + reach
                break
        for column in range(out.shape[1]):
            # A zone that the profile lacks, as a flange: 1 m away everywhere.
            missing = 1.0 if column == HEIGHT else 0.0
            out[shift, column] = out[near, column] if near >= 0 else missing


def tabulate_ellipse(poisson_ratio: float) -> NDArray[np.float64]:
    """Return ``ln(a/b)``, F_1, F_2, C11, C22, C23 at the nodes of ``ln(A/B)``, shape (n, 6)."""
    factors = hertz_factors(_RATIO_LIMIT, _RATIO_COUNT)
    kalker = [kalker_coefficients(math.exp(log), poisson_ratio) for log in factors[:, 0]]
    return np.hstack([factors, np.array(kalker)])


@kernel
def _weights(fraction):
    """Catmull-Rom weights of the four nodes around an interval."""
    t, s = fraction, 1.0 - fraction
    return (
        -0.5 * t * s * s,
        s * (1.0 + t - 1.5 * t * t),
        t * (1.0 + s - 1.5 * s * s),
        -0.5 * s * t * t,
    )


@kernel
def _locate(value, start, step, count):
    """Return the interval's index and the fraction in it, and whether the value is inside."""
    position = (value - start) / step
    inside = 1.0 <= position <= count - 2.0
    position = min(max(position, 1.0), count - 2.0 - 1e-9)
    index = int(position)
    return index, position - index, inside


@kernel
def lookup_patch(tables, patch, lateral, roll, columns, out):
    """Interpolate the first ``columns`` columns of a patch into ``out``.

    Returns
    -------
    True if shift and roll are inside the table; outside it the nearest edge counts.
    """
    data = tables.patch
    i, f, inside_roll = _locate(roll, tables.roll_start, tables.roll_step, data.shape[1])
    j, g, inside_shift = _locate(lateral, tables.lateral_start, tables.lateral_step, data.shape[2])
    across, along = _weights(f), _weights(g)
    for c in range(columns):
        out[c] = 0.0
    for m in range(4):
        for n in range(4):
            weight = across[m] * along[n]
            for c in range(columns):
                out[c] += weight * data[patch, i - 1 + m, j - 1 + n, c]
    return inside_roll and inside_shift


@kernel
def lookup_ellipse(tables, curvature_a, curvature_b, out):
    """Interpolate ``ln(a/b)``, F_1, F_2, C11, C22, C23 into ``out`` for the half-curvatures."""
    data = tables.ellipse
    log = math.log(curvature_a / curvature_b)
    i, f, _ = _locate(log, tables.ratio_start, tables.ratio_step, data.shape[0])
    weight = _weights(f)
    for c in range(6):
        out[c] = 0.0
        for m in range(4):
            out[c] += weight[m] * data[i - 1 + m, c]
