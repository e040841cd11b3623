r"""Closed forms beside the eigenmodes: P2 resonance, eqs. (12)-(16), and pinned-pinned mode.

The article takes one wheel with half the wheelset's mass on a Bernoulli-Euler rail, whose
fasteners are smeared to a Winkler foundation :math:`k_f = K_{pv}/l_0`; the base is rigid.
Its eq. (12) is misprinted: the root covers the whole fraction,

.. math:: f_{P2} = \frac{1}{2\pi}\sqrt{\frac{K_{Tr}}{M_{Tr} + M_w}}.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, assemble
from slab_track.frequency.receptance import middle
from slab_track.frequency.vertical import VerticalResponse
from slab_track.parameters import TrackParameters
from slab_track.rail import vertical_modes


class P2Formula(NamedTuple):
    """P2 resonance by the article's formula.

    Attributes
    ----------
    frequency
        Hz, eq. (16).
    track_stiffness, track_mass
        K_Tr in N/m, eq. (13), and M_Tr in kg, eq. (15), per rail.
    """

    frequency: float
    track_stiffness: float
    track_mass: float


def p2_formula(p: TrackParameters, wheel_mass: float, *, spacing: float | None = None) -> P2Formula:
    """Evaluate eqs. (12)-(16) for ``wheel_mass`` in kg, half a wheelset.

    ``spacing`` in m replaces the track's own l_0: the figures in the article's text follow with
    0.60 m, not with the 0.629 m of its Table 2.
    """
    bending = p.rail.youngs_modulus * p.rail.vertical_second_moment
    foundation = p.fastener.vertical_stiffness / (spacing or p.fastener.spacing)  # Eq. (14)
    stiffness = 2.0 * (4.0 * bending * foundation**3) ** 0.25  # Eq. (13)
    mass = 3.0 * p.rail.density * p.rail.area * (bending / stiffness) ** (1.0 / 3.0)  # Eq. (15)
    frequency = math.sqrt(stiffness / (mass + wheel_mass)) / (2.0 * math.pi)  # Eq. (12)
    return P2Formula(frequency, stiffness, mass)


def resonance_speed(frequency: float, spacing: float) -> float:
    """Return the speed in m/s at which fasteners ``spacing`` m apart are passed at a frequency."""
    return frequency * spacing


def pinned_pinned_frequency(p: TrackParameters) -> float:
    """Return the closed form in Hz: a Timoshenko rail hinged at two neighbouring fasteners."""
    first = vertical_modes(p.rail, p.fastener.spacing).omega_squared[0, 0]
    return math.sqrt(first) / (2.0 * math.pi)


class PinnedPinned(NamedTuple):
    """Extremes of one rail's vertical receptance near the pinned-pinned frequency, Hz.

    Attributes
    ----------
    peak
        Largest receptance half-way between two fasteners.
    dip
        Smallest receptance over a fastener.
    """

    peak: float
    dip: float


def pinned_pinned_extremes(p: TrackParameters) -> PinnedPinned:
    """Find peak and dip of the receptance within 6 % of the closed form.

    Both lie near the closed form as far as the fasteners damp lightly; the peak is a little
    below, since the fasteners give way, and disappears with heavy damping.
    """
    track, places, guess = assemble(p), middle(p), pinned_pinned_frequency(p)

    def magnitude(f: float, response: VerticalResponse) -> float:
        s = 2j * math.pi * f
        pair = response.solve(s, SYMMETRIC).rail + response.solve(s, ANTISYMMETRIC).rail
        return 0.5 * abs(pair[0, 0])

    found = []
    for place, sign in ((places.mid_bay, -1.0), (places.fastener, 1.0)):
        x = np.array([place])
        response = VerticalResponse(track, x, x)
        grid = guess * np.linspace(0.94, 1.06, 49)
        values = [sign * magnitude(f, response) for f in grid]
        best = int(np.clip(np.argmin(values), 1, grid.size - 2))
        refined = minimize_scalar(
            lambda f, response=response, sign=sign: sign * magnitude(f, response),
            bounds=(grid[best - 1], grid[best + 1]),
            method="bounded",
            options={"xatol": 1e-3},
        )
        found.append(float(refined.x))
    return PinnedPinned(*found)
