r"""The contact as equations: forces between given wheelsets and given rails.

Where profiles touch comes from their tables (:mod:`slab_track.contact.tables`), FASTSIM from
:mod:`slab_track.contact.fastsim`; what is made of both stands here, in plain numpy. Directions of
forces on a rail: lateral, vertical, roll; sides: left, right; w wheelsets.
"""

import math
from typing import NamedTuple

import numpy as np

from slab_track.contact.creepage import creepages
from slab_track.contact.fastsim import fastsim, fastsim_grid
from slab_track.contact.tables import ContactTables
from slab_track.contact.wheelset import FORCED, LOCATED, ContactWork, wheel_rail_contact

SIDES = np.array([-1.0, 1.0])
"""Sign of y on the left and on the right."""


class Contact(NamedTuple):
    """Forces between wheels and rails.

    Attributes
    ----------
    on_rail
        Force on the rails' axes: lateral, vertical, roll moment, (w, 2, 3), N and N.m.
    on_wheelset
        Force and moment on each wheelset about its centre, (w, 6), N and N.m.
    normal, creep
        Normal force (w, 2), and longitudinal and lateral creep force (w, 2, 2) of each wheel, N.
    """

    on_rail: np.ndarray
    on_wheelset: np.ndarray
    normal: np.ndarray
    creep: np.ndarray


def no_contact(count: int) -> Contact:
    """Return the contact of ``count`` wheelsets in the air."""
    return Contact(*(np.zeros((count, *shape)) for shape in ((2, 3), (6,), (2,), (2, 2))))


def level_contact(
    row: np.ndarray, offsets: np.ndarray, rail: np.ndarray, half_distance: float, G_H: float
) -> Contact:
    """Return the contact of eq. (1) on a level tread at the rolling circle; no creep forces.

    Parameters
    ----------
    row
        Motion of the wheelsets, (w, 11), SI units; heights count from first touch.
    offsets
        Irregularity, (w, 2, 2): side, direction (vertical, lateral), m.
    rail
        Motion of the rails' axes: y, z, roll and rates, (w, 2, 6), SI units.
    half_distance, G_H
        Of the rolling circles, m; Hertz constant, m/N^(2/3).
    """
    out, b = no_contact(len(row)), half_distance * SIDES
    delta = row[:, 2, None] + b * row[:, 3, None] - offsets[..., 0] - rail[..., 1]
    out.normal[:] = (np.maximum(delta, 0.0) / G_H) ** 1.5  # Eq. (1)
    out.on_rail[..., 1] = out.normal
    out.on_wheelset[:, 2], out.on_wheelset[:, 3] = -out.normal.sum(axis=1), -out.normal @ b
    return out


def profile_contact(
    tables: ContactTables, row: np.ndarray, offsets: np.ndarray, rail: np.ndarray
) -> Contact:
    """Return the contact of real profiles, ``tables``; other parameters as above."""
    out = no_contact(len(row))
    patches = _patches(tables, row, offsets, rail)
    for w, side, patch in np.argwhere(patches[..., 0] > 0.0):
        delta, g, *arms, K, ratio, scale, c11, c22, c23 = patches[w, side, patch]
        arm, (s_y, s_z) = arms[:3], arms[3:]  # from the wheelset's centre, from the rail's axis
        N = K * delta**1.5  # Eq. (1), K from the curvatures of the profiles
        a, b = scale * N ** (1 / 3) * math.sqrt(ratio), scale * N ** (1 / 3) / math.sqrt(ratio)
        xi, eta, phi, way = creepages(row[w], rail[w, side], *arm, s_y, s_z, g)
        T_x, T_s, M_n = fastsim(
            N, a, b, c11, c22, c23, tables.shear_modulus, tables.friction,
            way * xi, way * eta, phi, tables.columns, tables.strips,
        )  # fmt: skip
        T_x, T_s = way * T_x, way * T_s  # rolling backwards the patch is turned by half a turn
        into_rail = np.array([0.0, -math.sin(g), math.cos(g)])
        across = np.array([0.0, math.cos(g), math.sin(g)])
        f = np.array([T_x, 0.0, 0.0]) + T_s * across - N * into_rail  # on the wheel
        out.on_wheelset[w] += np.concatenate([f, np.cross(arm, f) + M_n * into_rail])
        out.on_rail[w, side] -= f[1], f[2], s_y * f[2] - s_z * f[1]
        out.normal[w, side] += N
        out.creep[w, side] += T_x, T_s
    return out


def _patches(
    tables: ContactTables, row: np.ndarray, offsets: np.ndarray, rail: np.ndarray
) -> np.ndarray:
    """Where the patches are, and their elastic constants: (w, 2, 2, LOCATED)."""
    count = len(row)
    found = np.zeros((count, 2, 2, LOCATED))
    grid = fastsim_grid(tables.columns, tables.strips)
    wheel_rail_contact(
        tables, grid, ContactWork.of(count), row, rail,
        np.ascontiguousarray(offsets[..., ::-1]), np.zeros((count, 6)), np.zeros((count, 2, 3)),
        found, np.zeros((count, 2, 2, FORCED)),
    )  # fmt: skip
    return found
