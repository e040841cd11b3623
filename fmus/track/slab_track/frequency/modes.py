r"""Coupled eigenmodes of wheelsets and track, and their shapes.

Every wheelset (mass, roll inertia) stands with two wheels on linearised Hertz springs
:math:`k_H`, and hangs with its primary suspension under a share of the bogie frame. In the
symmetry classes of :mod:`slab_track.assembly`, with force F on the rail and receptance A(s),

.. math:: T(s) F = \left(A(s) + \frac{1}{k_H} I + \frac{1}{D(s)} I\right) F = 0,\quad
          D = m s^2 + \frac{\kappa_p M s^2}{\kappa_p + M s^2}.

m is half the mass of a wheelset in the symmetric class, :math:`I_{wx}/(2 b^2)` in the
antisymmetric one (roll on rolling circles 2b apart); :math:`\kappa_p = k_p + s c_p`. This
non-linear eigenproblem, as small as the number of wheelsets, holds the whole track without
any further approximation. It is solved by successive linear problems (Ruhe, SIAM J. Numer.
Anal. 10, 1973, 674-689): :math:`T(s) v = \mu T'(s) v`, :math:`s \leftarrow s - \mu`.
"""

import cmath
import dataclasses
import math
from typing import NamedTuple

import numpy as np
from rail_quantities import ParameterSet, quantity

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble, plate_modes
from slab_track.errors import TrackError
from slab_track.frequency.p2 import p2_formula
from slab_track.frequency.vertical import VerticalResponse, fastener_stiffness
from slab_track.parameters import TrackParameters

_TABLE_2 = "Table 2 of the article"
_ITERATIONS = 60
_TOLERANCE = 1e-11
_LONGEST = 0.3
"""Relative length of a step of the iteration."""
_DIFFERENCE = 1e-5
"""Relative step of the central difference for T'."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wheelset(ParameterSet):
    """A wheelset as the track sees it from below."""

    GROUP = "wheelset"
    mass: float = quantity(1881.0, "kg", "Mass of the wheelset", above=0.0, source=_TABLE_2)
    roll_inertia: float = quantity(923.0, "kg.m2", "Roll inertia", above=0.0, source="CRH6")
    primary_stiffness: float = quantity(
        0.0,
        "N/m",
        "Vertical stiffness of the primary suspension per axle box; 0: none",
        at_least=0.0,
    )
    primary_damping: float = quantity(
        0.0, "N.s/m", "Vertical damping of the primary suspension per axle box", at_least=0.0
    )
    primary_half_span: float = quantity(
        1.0, "m", "Lateral distance of the axle boxes from the centre", above=0.0
    )
    frame_mass: float = quantity(
        1219.5, "kg", "Mass of the bogie frame per wheelset", above=0.0, source=_TABLE_2
    )
    frame_roll_inertia: float = quantity(
        990.0, "kg.m2", "Roll inertia of the bogie frame per wheelset", above=0.0, source="CRH6"
    )

    def dynamic_stiffness(self, s: complex, symmetry: int, half_distance: float) -> complex:
        """Return D(s) in N/m of one symmetry class.

        Parameters
        ----------
        s
            Of the time factor exp(s t), rad/s.
        symmetry
            ``SYMMETRIC`` (bounce) or ``ANTISYMMETRIC`` (roll).
        half_distance
            Half the distance of the rolling circles, m.
        """
        lever = 2.0 * half_distance**2
        mass, frame = 0.5 * self.mass, 0.5 * self.frame_mass
        suspension = self.primary_stiffness + s * self.primary_damping
        if symmetry == ANTISYMMETRIC:
            mass, frame = self.roll_inertia / lever, self.frame_roll_inertia / lever
            suspension *= (self.primary_half_span / half_distance) ** 2
        sprung = frame * s**2
        held = sprung * suspension / (suspension + sprung) if suspension else 0.0
        return mass * s**2 + held


WHEELSET_ON_PRIMARY = Wheelset(primary_stiffness=9e6, primary_damping=10.5e3)
"""With the primary suspension of the article's Table 2."""


class CoupledMode(NamedTuple):
    """One eigenmode; shapes are complex, scaled so that the largest wheel motion is 1.

    Attributes
    ----------
    eigenvalue
        s in rad/s.
    symmetry
        SYMMETRIC (both rails alike) or ANTISYMMETRIC (opposite; shapes are the right side's).
    wheel
        Vertical motion of the wheelsets at the wheels, m/m, (w,).
    contact_force
        Force on the rail per unit wheel motion, (w,), N/m.
    rail
        Deflection of the rail at ``rail_position``, m/m, (x,).
    rail_position
        m from the window's start, (x,).
    fastener
        Compression of the fasteners, m/m, (P,).
    seat
        Deflection of the slabs at the rail seats, m/m, (P,).
    slab
        Deflection of the slabs along the rail and along the slabs' edge, m/m, (2, S, points).
    slab_position
        m from the window's start, (S, points).
    """

    eigenvalue: complex
    symmetry: int
    wheel: np.ndarray
    contact_force: np.ndarray
    rail: np.ndarray
    rail_position: np.ndarray
    fastener: np.ndarray
    seat: np.ndarray
    slab: np.ndarray
    slab_position: np.ndarray

    @property
    def natural_frequency(self) -> float:
        """|s|/(2 pi), Hz."""
        return abs(self.eigenvalue) / (2.0 * math.pi)

    @property
    def damped_frequency(self) -> float:
        """Im s/(2 pi), Hz."""
        return self.eigenvalue.imag / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re s/|s|."""
        return -self.eigenvalue.real / abs(self.eigenvalue)


class CoupledSystem:
    """Wheelsets at rest on the track.

    Parameters
    ----------
    p
        Parameters of the track.
    wheelset
        What stands on it.
    positions
        Places of the wheelsets, m from the window's start, shape (w,).
    contact_stiffness
        Linearised Hertz stiffness k_H per wheel in N/m; infinite for a rigid contact; without
        it that of eq. (1) under ``static_wheel_load``.
    track
        The track assembled from ``p``, if it is there already.
    """

    def __init__(
        self,
        p: TrackParameters,
        wheelset: Wheelset,
        positions: np.ndarray,
        *,
        contact_stiffness: float | None = None,
        track: LinearTrack | None = None,
    ) -> None:
        self.parameters, self.wheelset = p, wheelset
        self.positions = np.atleast_1d(np.asarray(positions, dtype=float))
        self.track = assemble(p) if track is None else track
        stiffness = hertz_stiffness(p) if contact_stiffness is None else contact_stiffness
        self._contact_compliance = 1.0 / stiffness
        self._half_distance = 0.5 * p.contact.rolling_circle_distance
        self._response = VerticalResponse(self.track, self.positions, self.positions)

    def matrix(self, s: complex, symmetry: int = SYMMETRIC) -> np.ndarray:
        """Return T(s), shape (w, w), in m/N.

        Parameters
        ----------
        s
            Of the time factor exp(s t), rad/s.
        symmetry
            ``SYMMETRIC`` or ``ANTISYMMETRIC``.
        """
        wheel = self.wheelset.dynamic_stiffness(s, symmetry, self._half_distance)
        result = np.array(self._response.solve(s, symmetry).rail, dtype=complex)
        result[np.diag_indices_from(result)] += self._contact_compliance + 1.0 / wheel
        return result

    def eigenvalues(
        self, symmetry: int = SYMMETRIC, guess: float | None = None
    ) -> list[tuple[complex, np.ndarray]]:
        """Return one eigenvalue (rad/s) and vector of contact forces, shape (w,), per wheelset.

        Parameters
        ----------
        symmetry
            ``SYMMETRIC`` or ``ANTISYMMETRIC``.
        guess
            Hz, where the search starts; the P2 frequency by eq. (16) unless given.

        Raises
        ------
        TrackError
            If it does not converge.
        """
        if guess is None:
            guess = p2_formula(self.parameters, 0.5 * self.wheelset.mass).frequency
        start = 2.0 * math.pi * guess * (1j - 0.1)
        _, vectors = self._linearised(start, symmetry)
        return [self._converged(start, v, symmetry) for v in vectors.T]

    def _linearised(self, s: complex, symmetry: int) -> tuple[np.ndarray, np.ndarray]:
        """Solve T v = mu T' v at s."""
        step = _DIFFERENCE * abs(s)
        slope = self.matrix(s + step, symmetry) - self.matrix(s - step, symmetry)
        values, vectors = np.linalg.eig(
            np.linalg.solve(slope / (2.0 * step), self.matrix(s, symmetry))
        )
        return values, vectors

    def _converged(
        self, s: complex, vector: np.ndarray, symmetry: int
    ) -> tuple[complex, np.ndarray]:
        """Follow the eigenvector that resembles ``vector`` to its eigenvalue."""
        start = s
        for _ in range(_ITERATIONS):
            values, vectors = self._linearised(s, symmetry)
            vectors /= np.linalg.norm(vectors, axis=0)
            best = int(np.argmax(np.abs(vectors.conj().T @ vector)))
            vector = vectors[:, best]
            change = complex(values[best])
            if not cmath.isfinite(change):
                break
            if abs(change) < _TOLERANCE * abs(s):
                return s - change, vector
            s -= change * min(1.0, _LONGEST * abs(s) / abs(change))
        raise TrackError(
            f"no eigenvalue found near {start.imag / (2.0 * math.pi):g} Hz in {_ITERATIONS} steps; "
            "start the search at another frequency"
        )

    def mode(
        self,
        eigenvalue: complex,
        contact_force: np.ndarray,
        symmetry: int = SYMMETRIC,
        *,
        points_per_bay: int = 8,
    ) -> CoupledMode:
        """Return the shapes that belong to an eigenvalue.

        Parameters
        ----------
        eigenvalue
            rad/s, as from :meth:`eigenvalues`.
        contact_force
            Its vector, shape (w,), of any unit: the shapes are scaled.
        symmetry
            ``SYMMETRIC`` or ``ANTISYMMETRIC``.
        points_per_bay
            Number of points of the rail's shape between two fasteners.
        """
        track, s = self.track, eigenvalue
        bays = track.fastener_count
        x = np.linspace(0.0, track.length, bays * points_per_bay + 1)
        solved = VerticalResponse(track, self.positions, x).solve(s, symmetry)
        wheel = -contact_force / self.wheelset.dynamic_stiffness(s, symmetry, self._half_distance)
        # Largest motion 1, in phase with time zero.
        scale = 1.0 / wheel[np.argmax(np.abs(wheel))]
        force = contact_force * scale
        fastener = solved.fastener @ force
        slab = np.einsum("snw,w->sn", solved.slab, force)
        slab_position, shapes = self._slab_shapes(symmetry)
        seat_forces = fastener.reshape(track.slab_count, -1)
        seats = track.slabs[symmetry]
        seat = slab @ seats.seats + seat_forces @ seats.residual
        return CoupledMode(
            eigenvalue=s,
            symmetry=symmetry,
            wheel=wheel * scale,
            contact_force=force,
            rail=solved.rail @ force,
            rail_position=x,
            fastener=fastener / fastener_stiffness(track, s),
            seat=seat.ravel(),
            # The class's rail motion is sqrt(2) times that of either rail; so are its seats.
            slab=np.sqrt(2.0) * np.einsum("enx,sn->esx", shapes, slab),
            slab_position=slab_position,
        )

    def _slab_shapes(self, symmetry: int) -> tuple[np.ndarray, np.ndarray]:
        """Places along the slabs (S, points) and their modes at rail and edge, (2, n, points)."""
        p = self.parameters
        plate = plate_modes(p)
        local = np.linspace(-0.5, 0.5, 41) * p.slab_length
        of_class = plate.even if symmetry == SYMMETRIC else ~plate.even
        across = (self._half_distance, 0.5 * p.slab.width)
        shapes = [plate.shapes(local, np.full_like(local, y))[of_class] for y in across]
        centres = (np.arange(p.window.slab_count) + 0.5) * p.pitch
        return centres[:, None] + local, np.array(shapes)


def hertz_stiffness(p: TrackParameters) -> float:
    """Return the stiffness in N/m of eq. (1), linearised under ``static_wheel_load``."""
    return 1.5 * p.static_wheel_load ** (1.0 / 3.0) / p.contact.hertz_constant_used


def coupled_modes(
    p: TrackParameters,
    wheelset: Wheelset,
    positions: np.ndarray,
    *,
    symmetry: int = SYMMETRIC,
    contact_stiffness: float | None = None,
    guess: float | None = None,
) -> list[CoupledMode]:
    """Return one coupled mode per wheelset, by rising frequency; see :class:`CoupledSystem`.

    Parameters
    ----------
    p
        The track.
    wheelset
        What stands on it.
    positions
        Places of the wheelsets, m from the window's start, shape (w,).
    symmetry
        ``SYMMETRIC`` or ``ANTISYMMETRIC``.
    contact_stiffness
        Of each wheel, N/m; that of eq. (1) under ``static_wheel_load`` unless given.
    guess
        Hz, where the search starts; the P2 frequency by eq. (16) unless given.
    """
    system = CoupledSystem(p, wheelset, positions, contact_stiffness=contact_stiffness)
    found = system.eigenvalues(symmetry, guess)
    found.sort(key=lambda pair: abs(pair[0]))
    return [system.mode(s, vector, symmetry) for s, vector in found]
