"""Values of the track beside their references, as JSON on standard output."""

from rail_quantities.comparison import as_json

from slab_track.verification import curves, rows

print(as_json(rows(), curves()))
