"""Wheel/rail contact as one object over plain arrays.

>>> contact = WheelRailContact.build(ContactParameters(rail_profile="60E1"))  # doctest: +SKIP
>>> result = contact.evaluate(motion)                                         # doctest: +SKIP
"""

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slab_track.contact.fastsim import fastsim_grid
from slab_track.contact.parameters import ContactParameters
from slab_track.contact.tables import ContactTables, build_tables
from slab_track.contact.wheelset import FORCED, LOCATED, ContactWork, wheel_rail_contact

FloatArray = NDArray[np.float64]


class ContactResult(NamedTuple):
    """What the contact of n wheelsets gives.

    Attributes
    ----------
    wheelset
        Force (N) and moment (N.m) on each wheelset about its centre, track frame, shape (n, 6).
    rail
        Lateral and vertical force (N) and roll moment (N.m) on each rail about its axis,
        shape (n, 2, 3), left first.
    located
        Patches, shape (n, 2, 2, LOCATED): wheelset, side, tread or flange; columns in
        :mod:`slab_track.contact.wheelset`.
    forces
        Forces of the patches, shape (n, 2, 2, FORCED).
    inside
        False if a wheel is so far from its rail that the tables end (derailed).
    """

    wheelset: FloatArray
    rail: FloatArray
    located: FloatArray
    forces: FloatArray
    inside: bool


@dataclasses.dataclass(frozen=True, kw_only=True)
class WheelRailContact:
    """Contact of wheelsets on two rails, from tables.

    Attributes
    ----------
    tables
        What :func:`slab_track.contact.wheelset.wheel_rail_contact` and its parts take.
    """

    tables: ContactTables

    @classmethod
    def build(cls, parameters: ContactParameters, **track: Any) -> "WheelRailContact":
        """Compute the tables; ``track`` as for :func:`slab_track.contact.tables.build_tables`."""
        return cls(tables=build_tables(parameters, **track))

    def evaluate(
        self,
        motion: FloatArray,
        rails: FloatArray | None = None,
        offsets: FloatArray | None = None,
    ) -> ContactResult:
        """Return the contact at an instant.

        Parameters
        ----------
        motion
            Wheelset motions in the order of the contract's columns, shape (n, 11). Heights
            count from first touch of the centred wheelset on undisplaced rails.
        rails
            Displacements and velocities of the rails' axes at the wheels: y, z, roll and
            rates, shape (n, 2, 6); default at rest.
        offsets
            Lateral and vertical irregularity (m), shape (n, 2, 2); default none.
        """
        count = motion.shape[0]
        rails = np.zeros((count, 2, 6)) if rails is None else rails
        offsets = np.zeros((count, 2, 2)) if offsets is None else offsets
        wheelset, rail = np.zeros((count, 6)), np.zeros((count, 2, 3))
        located = np.zeros((count, 2, 2, LOCATED))
        forces = np.zeros((count, 2, 2, FORCED))
        grid = fastsim_grid(self.tables.columns, self.tables.strips)
        inside = wheel_rail_contact(
            self.tables,
            grid,
            ContactWork.of(count),
            np.ascontiguousarray(motion, dtype=float),
            np.ascontiguousarray(rails),
            np.ascontiguousarray(offsets),
            wheelset,
            rail,
            located,
            forces,
        )
        return ContactResult(wheelset, rail, located, forces, bool(inside))
