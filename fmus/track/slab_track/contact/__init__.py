"""Wheel/rail contact on real profiles: geometry, Hertz, Kalker, FASTSIM.

Pure physics over plain arrays. :class:`WheelRailContact` evaluates all wheels at an
instant; its parts in :mod:`slab_track.contact.wheelset` fit into an implicit time
integration; :class:`ContactGeometry` and :func:`contact_table` give
contact points without tables.
"""

from slab_track.contact.fastsim import fastsim
from slab_track.contact.geometry import ContactGeometry, RailPlacement
from slab_track.contact.hertz import HertzContact, hertz_contact
from slab_track.contact.kalker import kalker_coefficients
from slab_track.contact.model import ContactResult, WheelRailContact
from slab_track.contact.parameters import ContactParameters, Steel
from slab_track.contact.profile_file import load_profile, profile_from_points
from slab_track.contact.profiles import Profile
from slab_track.contact.study import ContactTable, contact_table, equivalent_conicity
from slab_track.contact.tables import ContactTables, build_tables

__all__ = [
    "ContactGeometry",
    "ContactParameters",
    "ContactResult",
    "ContactTable",
    "ContactTables",
    "HertzContact",
    "Profile",
    "RailPlacement",
    "Steel",
    "WheelRailContact",
    "build_tables",
    "contact_table",
    "equivalent_conicity",
    "fastsim",
    "hertz_contact",
    "kalker_coefficients",
    "load_profile",
    "profile_from_points",
]
