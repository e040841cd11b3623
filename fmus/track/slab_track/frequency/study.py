"""Tables of the frequency view: receptances, P2 resonance over pad stiffness, a mode's shape."""

import dataclasses
import math
from typing import Any

import numpy as np
from rail_quantities import with_values

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, assemble
from slab_track.frequency.modes import CoupledSystem, Wheelset, hertz_stiffness
from slab_track.frequency.p2 import (
    p2_formula,
    pinned_pinned_extremes,
    pinned_pinned_frequency,
    resonance_speed,
)
from slab_track.frequency.receptance import middle, receptance
from slab_track.parameters import TrackParameters

AXLE_DISTANCE = 2.5
"""Distance of two wheelsets of the article's bogie, m."""

ARTICLE_BAY = 0.60
"""Bay in m with which the frequencies in the article's text follow."""

_PADS = np.array([20, 30, 40, 50, 60, 80, 100, 120, 140, 160, 180, 200, 225, 250]) * 1e6
_QUICK_PADS = np.array([40, 80, 140, 200]) * 1e6
_LIGHT = 1000.0
"""Fastener damping in N.s/m with which peak and dip at the pinned-pinned frequency show."""

Table = tuple[dict[str, Any], dict[str, np.ndarray]]
"""Single figures by name, and arrays by name."""


def receptance_table(p: TrackParameters, *, quick: bool = False) -> Table:
    """Return receptances from 2 Hz to 2 kHz; arrays are (f,) and (place, f).

    Places: half-way between two fasteners, and over a fastener. ``next_wheel`` is the deflection
    of the same rail :data:`AXLE_DISTANCE` further.
    """
    frequency = np.geomspace(2.0, 2000.0, 121 if quick else 481)
    places = np.array(middle(p))
    found = receptance(p, frequency, places, np.append(places, places + AXLE_DISTANCE))
    own, beyond = np.array([0, 1]), np.array([2, 3])
    columns = {
        "frequency": frequency,
        "same_rail": found.same_rail[:, own, own].T,
        "other_rail": found.other_rail[:, own, own].T,
        "next_wheel": found.same_rail[:, beyond, own].T,
        "lateral": found.lateral[:, own, own, 0, 0].T,
        "lateral_per_moment": found.lateral[:, own, own, 0, 1].T,
        "roll": found.lateral[:, own, own, 1, 1].T,
    }
    light = with_values(p, {"fastener.vertical_damping": _LIGHT})
    extremes = pinned_pinned_extremes(light)
    support = p.fastener.vertical_stiffness / (p.fastener.spacing * p.rail.density * p.rail.area)
    about = {
        "axle_distance": AXLE_DISTANCE,
        "pinned_pinned_frequency": pinned_pinned_frequency(p),
        "pinned_pinned_peak": extremes.peak,
        "pinned_pinned_dip": extremes.dip,
        "pinned_pinned_damping": _LIGHT,
        "rail_on_pads_frequency": math.sqrt(support) / (2.0 * math.pi),
    }
    return about, columns


def p2_table(p: TrackParameters, wheelset: Wheelset, *, quick: bool = False) -> Table:
    """Return P2 frequencies over the pads' stiffness; arrays are (pad,) and (place, pad).

    By the formula, and of the coupled mode: with rigid contact, with Hertz springs, and with
    the primary suspension in addition; and of the roll mode with all of it.
    """
    pads = _QUICK_PADS if quick else _PADS
    alone = dataclasses.replace(wheelset, primary_stiffness=0.0, primary_damping=0.0)
    cases = {
        "rigid_contact": (alone, math.inf, SYMMETRIC),
        "hertz": (alone, hertz_stiffness(p), SYMMETRIC),
        "primary": (wheelset, hertz_stiffness(p), SYMMETRIC),
        "roll": (wheelset, hertz_stiffness(p), ANTISYMMETRIC),
    }
    assembled = assemble(p)
    columns: dict[str, np.ndarray] = {"pad_stiffness": pads}
    for name, (standing, contact, symmetry) in cases.items():
        values = np.empty((2, pads.size), dtype=complex)
        for j, pad in enumerate(pads):
            track = assembled._replace(stiffness=float(pad))
            line = with_values(p, {"fastener.vertical_stiffness": float(pad)})
            for i, place in enumerate(middle(p)):
                system = CoupledSystem(
                    line, standing, np.array([place]), contact_stiffness=contact, track=track
                )
                values[i, j] = system.eigenvalues(symmetry)[0][0]
        columns[f"{name}_frequency"] = np.abs(values) / (2.0 * math.pi)
        columns[f"{name}_damping_ratio"] = -np.real(values) / np.abs(values)
    formulas = {"formula": p.fastener.spacing, "formula_article": ARTICLE_BAY}
    for name, bay in formulas.items():
        columns[f"{name}_frequency"] = np.array(
            [_formula(p, pad, 0.5 * wheelset.mass, bay) for pad in pads]
        )
    spacing = p.fastener.spacing
    columns["resonance_speed"] = resonance_speed(1.0, spacing) * columns["primary_frequency"]
    about = {
        "article_bay": ARTICLE_BAY,
        "spacing": spacing,
        "contact_stiffness": hertz_stiffness(p),
        "wheelset_mass": wheelset.mass,
        "pad_damping": p.fastener.vertical_damping,
    }
    return about, columns


def _formula(p: TrackParameters, pad: float, wheel_mass: float, bay: float) -> float:
    line = with_values(p, {"fastener.vertical_stiffness": float(pad)})
    return p2_formula(line, wheel_mass, spacing=bay).frequency


def mode_table(p: TrackParameters, wheelset: Wheelset, *, quick: bool = False) -> Table:
    """Return the coupled P2 mode of a wheelset half-way between two fasteners.

    Arrays: rail (x,), fasteners and seats (P,), slabs (line, S, points); positions count from the
    wheelset, m. Shapes are complex, with the wheelset's motion 1.
    """
    place = middle(p).mid_bay
    system = CoupledSystem(p, wheelset, np.array([place]))
    ((eigenvalue, force),) = system.eigenvalues()
    mode = system.mode(eigenvalue, force, points_per_bay=4 if quick else 16)
    count = p.fastener_count
    columns = {
        "rail_position": mode.rail_position - place,
        "rail": mode.rail,
        "fastener_position": (np.arange(count) + 0.5) * p.fastener.spacing - place,
        "fastener": mode.fastener,
        "seat": mode.seat,
        "slab_position": mode.slab_position - place,
        "slab": mode.slab,
    }
    under = int(np.argmin(np.abs(columns["rail_position"])))
    about = {
        "natural_frequency": mode.natural_frequency,
        "damped_frequency": mode.damped_frequency,
        "damping_ratio": mode.damping_ratio,
        "formula_frequency": p2_formula(p, 0.5 * wheelset.mass).frequency,
        "rail_under_wheel_amplitude": float(abs(mode.rail[under])),
        "rail_under_wheel_phase": float(np.angle(mode.rail[under])),
        "seat_amplitude": float(np.abs(mode.seat).max()),
        "seat_amplitude_phase": float(np.angle(mode.seat[np.argmax(np.abs(mode.seat))])),
        "pad_stiffness": p.fastener.vertical_stiffness,
        "pad_damping": p.fastener.vertical_damping,
        "spacing": p.fastener.spacing,
    }
    return about, columns
