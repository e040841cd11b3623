"""What Figs. 8, 9 and 12 share: records of single runs, their last slab, their spectra."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.studies.article import BOX
from rail_cosim.studies.article_plots import begin_at

BOGIE, BODY = "bogie_vertical_acceleration", "car_body_vertical_acceleration"
BAY, PITCH = 0.629, 8 * 0.629
_HIGHEST = 400.0


def record(data: xr.Dataset, name: str, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and record of the first wheelset, side and bogie over the last slabs.

    Four slabs, or as many as there are after the first two; the step of these runs is the
    one of which a slab is a whole number.
    """
    values = data[f"{name}_history"]
    for dimension in ("wheelset", "side", "bogie"):
        if dimension in values.dims:
            values = values.isel({dimension: 0})
    there = values.notnull().to_numpy()
    time, values = data["time_history"].to_numpy()[there], values.to_numpy()[there]
    step = (time[-1] - time[0]) / (len(time) - 1)
    slab = round(PITCH / (speed / 3.6) / step)
    count = slab * max(1, min(4, len(time) // slab - 2))
    return time[-count:] - time[-count], values[-count:]


def lines(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (Hz) and amplitudes over whole periods: no window is needed."""
    found = np.abs(np.fft.rfft(values - values.mean())) * 2.0 / len(values)
    return np.fft.rfftfreq(len(values), time[1] - time[0]), found


def dominant(data: xr.Dataset, name: str, speed: float) -> float:
    """Return the frequency (Hz) of the largest component above the slabs' own."""
    frequencies, found = lines(*record(data, name, speed))
    return float(frequencies[int(np.argmax(found))])


def at_sleepers(data: xr.Dataset, name: str, speed: float) -> float:
    """Return the amplitude (m/s2) at the sleeper-passing frequency."""
    frequencies, found = lines(*record(data, name, speed))
    return float(found[int(np.argmin(np.abs(frequencies - speed / 3.6 / BAY)))])


def draw_time(axes: Axes, data: xr.Dataset, speed: float, names: dict[str, str]) -> None:
    """Draw records over the last slab lengths."""
    for name, label in names.items():
        time, values = record(data, name, speed)
        axes.plot(time, values, lw=1.0, label=label)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("acceleration (m/s²)")


def draw_spectrum(axes: Axes, data: xr.Dataset, speed: float, names: dict[str, str]) -> None:
    """Draw their spectra, amplitudes on a logarithmic scale."""
    for name, label in names.items():
        frequencies, found = lines(*record(data, name, speed))
        there = (frequencies > 0.0) & (frequencies <= _HIGHEST)
        axes.semilogy(frequencies[there], found[there], lw=1.0, label=label)
    begin_at(axes, 1e-5)
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("amplitude (m/s²)")


HISTORY = (BOX, BOGIE, BODY)
