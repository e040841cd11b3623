r"""Closed forms beside the eigenmodes: P2 resonance, eqs. (12)-(16), and pinned-pinned mode.

The article takes one wheel with half the wheelset's mass on a Bernoulli-Euler rail, whose
fasteners are smeared to a Winkler foundation :math:`k_f = K_{pv}/l_0`; the base is rigid.
Its eq. (12) is misprinted: the root covers the whole fraction,

.. math:: f_{P2} = \frac{1}{2\pi}\sqrt{\frac{K_{Tr}}{M_{Tr} + M_w}}.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, LinearTrack, assemble
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
    """Return the speed in m/s at which fasteners ``spacing`` m apart pass at ``frequency`` Hz."""
    return frequency * spacing


def pinned_pinned_frequency(p: TrackParameters) -> float:
    """Return the closed form in Hz: a Timoshenko rail hinged at two neighbouring fasteners."""
    first = vertical_modes(p.rail, p.fastener.spacing).omega_squared[0, 0]
    return math.sqrt(first) / (2.0 * math.pi)


class PinnedPinned(NamedTuple):
    """Extremes of one rail's vertical receptance near the pinned-pinned frequency.

    Attributes
    ----------
    peak
        Frequency of the largest receptance half-way between two fasteners, Hz.
    dip
        Frequency of the smallest receptance over a fastener, Hz.
    """

    peak: float
    dip: float


def pinned_pinned_extremes(p: TrackParameters) -> PinnedPinned:
    """Find peak and dip of the receptance within 6 % of the closed form.

    With light damping the peak lies on the closed form, where a mode has nodes at all
    fasteners, and the dip a little above. In a window whose ends reflect
    (``window.method = "moving_mass"``, or little ``window.end_damping``) both stand with an
    envelope between the hinges, up to a per cent lower.
    """
    track, places, guess = assemble(p), middle(p), pinned_pinned_frequency(p)
    return PinnedPinned(
        peak=_extreme(track, places.mid_bay, guess, -1.0),
        dip=_extreme(track, places.fastener, guess, 1.0),
    )


def _extreme(track: LinearTrack, place: float, guess: float, sign: float) -> float:
    """Frequency in Hz near ``guess`` where ``sign`` times the receptance is least."""
    x = np.array([place])
    response = VerticalResponse(track, x, x)

    def signed(f: float) -> float:
        s = 2j * math.pi * f
        pair = response.solve(s, SYMMETRIC).rail + response.solve(s, ANTISYMMETRIC).rail
        return sign * 0.5 * abs(pair[0, 0])

    grid = guess * np.linspace(0.94, 1.06, 96)
    best = int(np.clip(np.argmin([signed(f) for f in grid]), 1, grid.size - 2))
    low, high = float(grid[best - 1]), float(grid[best + 1])
    return _golden(signed, low, high)


def _golden(function: Callable[[float], float], low: float, high: float) -> float:
    """Minimum of a function with one minimum in an interval, to 1 mHz."""
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    a, b = high - ratio * (high - low), low + ratio * (high - low)
    at_a, at_b = function(a), function(b)
    while high - low > 1e-3:
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = function(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = function(b)
    return 0.5 * (low + high)
