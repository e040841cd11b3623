"""Cross-section profiles of wheels and rails as functions of the lateral coordinate.

Convention, for the right-hand wheel and rail seen in running direction (the
left-hand ones are mirror images): ``y`` to the field side (away from the track
centre), ``z`` down, both in metres. A wheel's origin is its rolling circle, so
``z`` is the wheel's radius there less the nominal one, and the flange is at
``y < 0``. A rail's origin is the top of the uninclined head, and the gauge
side is at ``y < 0``. This is the orientation of EN 13715.
"""

import dataclasses
from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


@runtime_checkable
class Profile(Protocol):
    """What the contact geometry needs of a profile."""

    @property
    def name(self) -> str:
        """Name for messages."""
        ...

    @property
    def start(self) -> float:
        """Smallest lateral coordinate (m)."""
        ...

    @property
    def end(self) -> float:
        """Largest lateral coordinate (m)."""
        ...

    def derivative(self, y: ArrayLike, order: int = 0) -> FloatArray:
        """Return height (order 0, m), slope (1) or second derivative (2, 1/m) at ``y``."""
        ...


def curvature(profile: Profile, y: ArrayLike) -> FloatArray:
    """Return the curvature ``z'' / (1 + z'^2)^(3/2)`` (1/m); positive where a rail is convex."""
    return profile.derivative(y, 2) / (1.0 + profile.derivative(y, 1) ** 2) ** 1.5


@dataclasses.dataclass(frozen=True, kw_only=True)
class PolynomialPiece:
    """``z = sum c_k y^k`` between ``start`` and ``end`` (all SI)."""

    start: float
    end: float
    coefficients: tuple[float, ...]

    def derivative(self, y: FloatArray, order: int) -> FloatArray:
        """Return the derivative of the given order, 0 to 2."""
        coefficients = np.array(self.coefficients)
        if order > 0:
            coefficients = np.polynomial.polynomial.polyder(coefficients, order)
        return np.asarray(np.polynomial.polynomial.polyval(y, coefficients), dtype=np.float64)


@dataclasses.dataclass(frozen=True, kw_only=True)
class ArcPiece:
    """``z = centre_z + side * sqrt(radius^2 - (y - centre_y)^2)``, ``side`` 1 below, -1 above."""

    start: float
    end: float
    centre_y: float
    centre_z: float
    radius: float
    side: float

    def derivative(self, y: FloatArray, order: int) -> FloatArray:
        """Return the derivative of the given order, 0 to 2."""
        offset = y - self.centre_y
        root = np.sqrt(self.radius**2 - offset**2)
        if order == 0:
            return self.centre_z + self.side * root
        if order == 1:
            return -self.side * offset / root
        return -self.side * self.radius**2 / root**3


@dataclasses.dataclass(frozen=True, kw_only=True)
class PiecewiseProfile:
    """Profile of adjoining pieces in ascending order; exact derivatives on each piece.

    Attributes
    ----------
    name
        Name for messages.
    pieces
        Pieces whose intervals adjoin.
    """

    name: str
    pieces: tuple[PolynomialPiece | ArcPiece, ...]

    @property
    def start(self) -> float:
        """Smallest lateral coordinate (m)."""
        return self.pieces[0].start

    @property
    def end(self) -> float:
        """Largest lateral coordinate (m)."""
        return self.pieces[-1].end

    def derivative(self, y: ArrayLike, order: int = 0) -> FloatArray:
        """Return height (order 0), slope (1) or second derivative (2); NaN outside."""
        lateral = np.asarray(y, dtype=float)
        result = np.full(lateral.shape, np.nan)
        for piece in self.pieces:
            here = (lateral >= piece.start) & (lateral <= piece.end)
            result[here] = piece.derivative(lateral[here], order)
        return result


def mirrored(pieces: Sequence[PolynomialPiece | ArcPiece]) -> list[PolynomialPiece | ArcPiece]:
    """Return the mirror images in ``y = 0`` of pieces, in ascending order again."""
    images: list[PolynomialPiece | ArcPiece] = []
    for piece in reversed(pieces):
        interval = {"start": -piece.end, "end": -piece.start}
        if isinstance(piece, ArcPiece):
            images.append(dataclasses.replace(piece, centre_y=-piece.centre_y, **interval))
        else:
            signs = ((-1) ** k * c for k, c in enumerate(piece.coefficients))
            images.append(dataclasses.replace(piece, coefficients=tuple(signs), **interval))
    return images
