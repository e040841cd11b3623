"""Known values of rail, slab, contact, P2 resonance and irregularities, computed anew.

Each value comes from the functions that the time domain uses. ``python -m
slab_track.verification`` prints all as JSON. A row's source says where its reference is
from; "closed form" ones were evaluated for Table 2 of the article apart from this code.
"""

from rail_quantities.comparison import Curve, Row

from slab_track.verification.contact import contact_curves, contact_rows
from slab_track.verification.irregularity import irregularity_rows
from slab_track.verification.p2 import p2_rows
from slab_track.verification.rail import rail_curves, rail_rows
from slab_track.verification.slab import slab_rows

__all__ = ["curves", "rows"]


def rows() -> list[Row]:
    """Return all values of the track."""
    return [*rail_rows(), *slab_rows(), *contact_rows(), *p2_rows(), *irregularity_rows()]


def curves() -> list[Curve]:
    """Return the lines and points of the track's plots."""
    return [*rail_curves(), *contact_curves()]
