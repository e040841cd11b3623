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


def whole_run(distance: float = 60.0, rate: float = 5000.0, **attributes: object) -> xr.Dataset:
    """Return a run with everything that a report shows; forces and accelerations are sines."""
    time = times(distance / 80.0, rate)
    way = 80.0 * time
    wave = np.sin(2.0 * np.pi * way / BAY) + 0.1 * np.sin(2.0 * np.pi * way / BAY / COUNT)
    rng = np.random.default_rng(0)

    def each(dimension: str, count: int, amplitude: float) -> xr.DataArray:
        values = amplitude * (wave[:, None] + 0.01 * rng.normal(size=(time.size, count)))
        about = {"time": time, dimension: np.arange(1, count + 1)}
        return xr.DataArray(values, about, ["time", dimension], attrs={"units": "m/s2"})

    position = way[:, None] - np.array([0.0, 2.5, 17.8, 20.3])
    data = run(
        time,
        way,
        normal_force=wheels(LOAD + 5e3 * wave, time),
        vertical_wheel_force=wheels(LOAD + 5e3 * wave, time),
        guiding_force=wheels(1e3 * wave, time),
        axle_box_vertical_acceleration=wheels(3.0 * wave, time, "m/s2"),
        wheelset_longitudinal_position=xr.DataArray(position, dims=["time", "wheelset"]),
        window_start_position=xr.DataArray(np.full(time.size, -40.256), dims="time"),
        window_slide_count=xr.DataArray(np.arange(time.size) // 600, dims="time"),
        window_slide_residual=xr.DataArray(np.full(time.size, 3e-9), dims="time"),
    )
    for direction in ("vertical", "lateral"):
        data[f"bogie_{direction}_acceleration"] = each("bogie", 2, 0.5)
        data[f"car_body_floor_{direction}_acceleration"] = each("floor_place", 3, 0.1)
        data[f"car_body_{direction}_acceleration"] = each("bogie", 1, 0.1).isel(bogie=0, drop=True)
    about = {
        "command": "rail-cosim run",
        "source": "rail-cosim 0.1.0",
        "complete": 1,
        "line": "HD",
        "speed_km_h": 288.0,
        "track_fmu": "InfiniteSlabTrack.fmu",
        "track_guid": "{0}",
        "interface_energy_residual": 0.01,
        "interface_energy_residual_share": 1e-4,
        "interface_energy_residual_limit": 5e-3,
        "track.window.slab_count": 16,
        "track.slab.gap": 0.07,
        "vehicle.bogie.half_wheelbase": 1.25,
        "vehicle.car_body.half_bogie_spacing": 8.9,
        "vehicle.wheelset.radius": 0.46,
        "vehicle.speed": 80.0,
        "changed_parameters": '{"vehicle.speed": 83.3}',
    }
    return data.assign_attrs({**about, **attributes})
