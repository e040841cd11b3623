"""What Figs. 16 to 18 share: the ZX line, the two readings of the layer's stiffness."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rail_cosim.slave import Value

BAY, BAYS = 0.63, 9
PITCH = BAY * BAYS

ZX: dict[str, Value] = {
    "track.fastener.spacing": BAY,
    "track.fastener.count_per_slab": BAYS,
    "track.slab.thickness": 0.2,
}
"""The line of Table 2; set on top of the numerical settings of either column."""

CAM, BASIS = "track.slab_support.vertical_stiffness", "track.slab_support.basis"
BASES = {"per_bay": "per bay", "per_slab": "per slab"}
"""The article does not say to what its stiffness of the CAM layer belongs. Per bay gives its
Table 3, per slab the depth of the dips at the joints."""


def last_slabs(data: xr.Dataset, name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return way (m, of the leading wheelset) and record of the leading left wheel.

    Over the last ``count`` whole slabs between joints, which lie at multiples of the pitch.
    """
    values = data[f"{name}_history"].isel(wheelset=0, side=0).to_numpy()
    way = data["distance_history"].to_numpy()
    there = np.isfinite(values) & np.isfinite(way)
    way, values = way[there], values[there]
    stop = np.floor(way[-1] / PITCH + 1e-6) * PITCH
    chosen = (way >= stop - (count + 1e-6) * PITCH) & (way <= stop + 1e-6)
    return way[chosen] - stop + count * PITCH, values[chosen]
