"""The built-in profiles: wheel S1002, rails 60E1 and CHN60, made from their definitions.

Sources: wheel S1002 of EN 13715 (pieces A to H); rail heads of EN 13674-1
(60E1) and of the Chinese 60 kg/m rail as tangent arcs R300, R80, R13 and a
flank of 1:20. ``60E1_manchester`` is the head that the Manchester contact
benchmark distributes under the name UIC60: the same arcs with the joint of
R300 and R80 at 10.5 mm, recovered from its published points (it reproduces
them within 0.2 um).
"""

import math
from collections.abc import Callable

from rail_quantities import ParameterError, nearest

from slab_track.contact.profiles import (
    ArcPiece,
    PiecewiseProfile,
    PolynomialPiece,
    Profile,
    mirrored,
)

_MM = 1e-3
_FLANK_SLOPE = 20.0
_FLANK_DEPTH = 0.035


def _polynomial(start: float, end: float, *coefficients: float) -> PolynomialPiece:
    """Make a piece from coefficients in millimetres."""
    scaled = tuple(c * _MM ** (1 - k) for k, c in enumerate(coefficients))
    return PolynomialPiece(start=start * _MM, end=end * _MM, coefficients=scaled)


def _arc(
    start: float, end: float, centre: tuple[float, float], radius: float, side: float
) -> ArcPiece:
    """Make an arc from millimetres."""
    return ArcPiece(
        start=start * _MM,
        end=end * _MM,
        centre_y=centre[0] * _MM,
        centre_z=centre[1] * _MM,
        radius=radius * _MM,
        side=side,
    )


def wheel_s1002() -> PiecewiseProfile:
    """Return the wheel profile S1002 of EN 13715, from the flange's back (H) to the outside (A)."""
    a, b, c, d, e, f, g = (32.15796, -26.0, -35.0, -38.426669071, -39.764473993, -49.662510381,
                           -62.764705882)  # fmt: skip
    return PiecewiseProfile(
        name="S1002",
        pieces=(
            _arc(-70.0, g, (-49.5, 9.519259302), 20.5, 1.0),
            _arc(g, f, (-55.0, 16.0), 12.0, 1.0),
            _arc(f, e, (-58.558326413, 8.834924130), 20.0, 1.0),
            _polynomial(e, d, -93.576667419, -2.747477419),
            _arc(d, c, (-26.210665, 16.446), 13.0, -1.0),
            _polynomial(c, b, -4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875,
                        -2.054332446e-1, -4.169739389e-3, -4.687195829e-5, -2.252755540e-7),
            _polynomial(b, a, 0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5,
                        5.844240864e-8, -1.562379023e-8, 5.309217349e-15, -5.957839843e-12,
                        2.646656573e-13),
            _polynomial(a, 60.0, 1.364323640, -0.066666667),
        ),
    )  # fmt: skip


def rail_of_arcs(
    name: str,
    *,
    joints: tuple[float, float],
    radii: tuple[float, float, float] = (300.0, 80.0, 13.0),
) -> PiecewiseProfile:
    """Return a symmetric rail head of three tangent arcs and a flank of 1:20.

    Parameters
    ----------
    name
        Name for messages.
    joints
        Lateral coordinates of the joints of the first and second, and of the
        second and third arc (mm).
    radii
        Radii from the crown outwards (mm).
    """
    crown, shoulder, corner = radii
    # Tangent arcs: the centres of neighbours and their joint are in one line.
    sine = joints[0] / crown
    centre_2 = (
        joints[0] - shoulder * sine,
        crown - (crown - shoulder) * math.sqrt(1.0 - sine**2),
    )
    sine = (joints[1] - centre_2[0]) / shoulder
    centre_3 = (
        joints[1] - corner * sine,
        centre_2[1] - (shoulder - corner) * math.sqrt(1.0 - sine**2),
    )
    norm = math.hypot(1.0, _FLANK_SLOPE)
    flank_y = centre_3[0] + corner * _FLANK_SLOPE / norm
    flank_z = centre_3[1] - corner / norm
    flank_end = flank_y + _FLANK_DEPTH / _MM / _FLANK_SLOPE
    right = [
        _arc(0.0, joints[0], (0.0, crown), crown, -1.0),
        _arc(joints[0], joints[1], centre_2, shoulder, -1.0),
        _arc(joints[1], flank_y, centre_3, corner, -1.0),
        _polynomial(flank_y, flank_end, flank_z - _FLANK_SLOPE * flank_y, _FLANK_SLOPE),
    ]
    return PiecewiseProfile(name=name, pieces=(*mirrored(right), *right))


def rail_60e1() -> PiecewiseProfile:
    """Return the head of the rail 60E1 (EN 13674-1)."""
    return rail_of_arcs("60E1", joints=(10.228, 26.0265))


def rail_60e1_manchester() -> PiecewiseProfile:
    """Return the head of the rail UIC60 as the Manchester contact benchmark has it."""
    return rail_of_arcs("60E1_manchester", joints=(10.5, 25.988))


def rail_chn60() -> PiecewiseProfile:
    """Return the head of the Chinese 60 kg/m rail."""
    return rail_of_arcs("CHN60", joints=(10.0, 25.35))


WHEELS: dict[str, Callable[[], Profile]] = {"S1002": wheel_s1002}
RAILS: dict[str, Callable[[], Profile]] = {
    "60E1": rail_60e1,
    "CHN60": rail_chn60,
    "60E1_manchester": rail_60e1_manchester,
}


def builtin_profile(kind: str, name: str) -> Profile:
    """Return the built-in ``"wheel"`` or ``"rail"`` profile of a name.

    Raises
    ------
    ParameterError
        For a name that is not built in; the message lists those that are.
    """
    known = WHEELS if kind == "wheel" else RAILS
    if name not in known:
        close = nearest(name, known)
        hint = f"did you mean {' or '.join(close)}? " if close else ""
        raise ParameterError(
            f"contact.{kind}_profile",
            name,
            "is neither a built-in profile nor a readable file",
            f"{hint}built in are {', '.join(known)}; for a file give its path",
        )
    return known[name]()
