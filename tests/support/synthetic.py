"""Data sets made by hand, as runs have them: every signal is known in closed form."""

import numpy as np
import xarray as xr

BAY, COUNT = 0.629, 8
LOAD = 70e3


def times(duration: float, rate: float) -> np.ndarray:
    """Return records ``1/rate`` apart, half-open, (n,), s."""
    return np.arange(round(duration * rate)) / rate


def signal(values: np.ndarray, time: np.ndarray, unit: str = "m/s2") -> xr.DataArray:
    """Return a signal of one channel or more, (time, channel)."""
    dims = ["time", "channel"][: np.ndim(values)]
    return xr.DataArray(values, dims=dims, coords={"time": time}, attrs={"units": unit})


def wheels(values: np.ndarray, time: np.ndarray, unit: str = "N") -> xr.DataArray:
    """Return the same signal (n,) for every wheel, (time, wheelset, side)."""
    everywhere = np.broadcast_to(values[:, None, None], (len(time), 4, 2))
    about = {"time": time, "wheelset": [1, 2, 3, 4], "side": ["left", "right"]}
    return xr.DataArray(
        everywhere.copy(), dims=["time", "wheelset", "side"], coords=about, attrs={"units": unit}
    )


def run(time: np.ndarray, distance: np.ndarray, **variables: xr.DataArray) -> xr.Dataset:
    """Return a run with its way and parameters."""
    about = {
        "track.fastener.spacing": BAY,
        "track.fastener.count_per_slab": COUNT,
        "vehicle.static_wheel_load": LOAD,
    }
    return xr.Dataset({"distance": ("time", distance), **variables}, {"time": time}, about)
