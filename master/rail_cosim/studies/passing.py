"""What Figs. 8, 9 and 12 share: records of single runs, their last slab, their spectra."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.studies.article import BOX, Check, both
from rail_cosim.studies.article_plots import panels, spectrum_line

BOGIE, BODY = "bogie_vertical_acceleration", "car_body_vertical_acceleration"
HISTORY = (BOX, BOGIE, BODY)
"""What Figs. 8 and 12 keep; with the same, one run serves both."""
BAY, PITCH = 0.629, 8 * 0.629


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


def frequency_check(
    name: str, data: xr.Dataset, variable: str, speed: float, stated: float
) -> Check:
    """Return the check of a dominant frequency; the article gives whole numbers of Hz."""
    return Check(
        name=name,
        stated=f"{stated:g}",
        found=both(lambda one: dominant(one, variable, speed), data),
        low=stated - 1.0,
        high=stated + 1.0,
    )


def picture(speed: float, names: dict[str, str]) -> Callable[[xr.Dataset, Path], None]:
    """Return what draws time histories and spectra of runs at one speed."""

    def draw(data: xr.Dataset, path: Path) -> None:
        at = data.sel(speed=speed)

        def time(axes: Axes, one: xr.Dataset) -> None:
            draw_time(axes, one, speed, names)

        def spectrum(axes: Axes, one: xr.Dataset) -> None:
            draw_spectrum(axes, one, speed, names)

        panels(at, [time, spectrum], path, title=data.attrs["title"])

    return draw


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
        spectrum_line(axes, *lines(*record(data, name, speed)), lowest=1e-5, label=label)
    axes.set_ylabel("amplitude (m/s²)")
