"""Fig. 16 of the article: deflection of the primary suspension, and its spectrogram."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rail_cosim.reporter import Reporter
from rail_cosim.results import check_netcdf, write_netcdf
from rail_cosim.studies import article
from rail_cosim.studies.article import Check
from rail_cosim.studies.article_plots import panels
from rail_cosim.studies.base import StudyOptions, StudyResult
from rail_cosim.studies.zx_line import BASES, BASIS, CAM, PITCH, ZX

SPRING = "primary_suspension_vertical_deflection"
_SPEED = 350.0
_LOWEST, _HIGHEST = 8.0, 60.0  # Hz; below it the bogie's and the body's own motions
_CAMS = [300e6, 5000e6]
_COLOURS = {"per_bay": "#0072B2", "per_slab": "#D55E00"}
_RUNNING = 0.25  # s; the running mean over it is not drawn
_MICRO = 1e6


def run(options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study: steady runs at 350 km/h, and one that speeds up to it.

    The state of the measured track's mortar layer is not known: steady runs take the nominal
    and a soft one, in both readings; the speeding-up run the soft one.
    """
    data, picture = options.out / "fig16.nc", options.out / "fig16.png"
    check_netcdf(data)
    title = "Fig. 16: deflection of the primary suspension, ZX line (measured in the article)"
    first, distance = (300.0, 400.0) if options.quick else (250.0, 1200.0)
    runs = {
        "steady": {BASIS: list(BASES), CAM: _CAMS, "speed": [_SPEED]},
        "ramp": {BASIS: ["per_slab"], CAM: [_CAMS[0]], "speed": [first]},
    }
    ramp = {"final_speed": _SPEED, "until_steady": False, "distance": distance, "record_every": 10}
    parts = {}
    for name, grid in runs.items():
        study = article.ArticleStudy(
            name="fig16",
            title=title,
            grid=grid,
            settings=ZX,
            run=ramp if name == "ramp" else {"distance": 100.0 if options.quick else 200.0},
            keep={},
            history=(SPRING, "distance"),
            checks=lambda one: [],
            draw=lambda one, path: None,
        )
        parts[name] = article.compute(study, options, reporter).isel(speed=0, drop=True)
    parts["ramp"] = parts["ramp"].isel({BASIS: 0, CAM: 0}, drop=True)
    found = checks(parts)
    joined = join(parts)
    joined.attrs |= article.attributes(study, options, found)
    write_netcdf(joined, data)
    draw(parts, picture, title)
    return StudyResult(
        table=article.table(study, found),
        conclusion=article.conclude(found, joined),
        files=[data, picture],
    )


def join(parts: dict[str, xr.Dataset]) -> xr.Dataset:
    """Return both runs in one Dataset; names begin with steady or ramp."""
    joined = xr.Dataset()
    for name, part in parts.items():
        kept = part.drop_vars(["error", "remarks"])
        names = {n: f"{name}_{n}" for n in (*kept.data_vars, "record")}
        joined = joined.merge(kept.rename(names))
    return joined


def records(one: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), way (m) and deflection (m) at the first wheelset's left spring."""
    values = one[f"{SPRING}_history"].isel(wheelset=0, side=0).to_numpy()
    there = np.isfinite(values)
    time, way = one["time_history"].to_numpy(), one["distance_history"].to_numpy()
    return time[there], way[there], values[there]


def last_slabs(one: xr.Dataset, count: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and deflection (m) without its mean over the last whole slab lengths."""
    time, _, values = records(one)
    step = (time[-1] - time[0]) / (len(time) - 1)
    rows = count * round(PITCH / (_SPEED / 3.6) / step)
    return time[-rows:] - time[-rows], values[-rows:] - values[-rows:].mean()


def lines(one: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (Hz) and amplitudes (m) of the steady run."""
    time, values = last_slabs(one)
    found = np.abs(np.fft.rfft(values)) * 2.0 / len(values)
    return np.fft.rfftfreq(len(values), time[1] - time[0]), found


def spectrogram(
    one: xr.Dataset, length: float = 1.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the short-time Fourier transform of the run at growing speed.

    Parameters
    ----------
    one
        The run.
    length
        Of a Hann window in s.

    Returns
    -------
    tuple of ndarray
        Middle of each window (s), mean speed in it (m/s), frequencies (Hz) and amplitudes (m)
        of shape (frequencies, windows).
    """
    time, way, values = records(one)
    step = (time[-1] - time[0]) / (len(time) - 1)
    rows = min(round(length / step), len(values) // 3)
    starts = np.arange(0, len(values) - rows, max(1, rows // 16))
    window = np.hanning(rows + 1)[:-1]
    pieces = np.stack([values[i : i + rows] for i in starts])
    pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * window
    padded = 4 * rows  # finer lines: the ridge is read off them
    found = np.abs(np.fft.rfft(pieces, padded, axis=1)).T * 2.0 / window.sum()
    speed = (way[starts + rows - 1] - way[starts]) / ((rows - 1) * step)
    return time[starts] + 0.5 * rows * step, speed, np.fft.rfftfreq(padded, step), found


def ridge(one: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency of the largest component and slab-passing frequency (Hz) over time."""
    _, speed, frequencies, found = spectrogram(one)
    there = (frequencies >= _LOWEST) & (frequencies <= _HIGHEST)
    return frequencies[there][found[there].argmax(axis=0)], speed / PITCH


def checks(parts: dict[str, xr.Dataset]) -> list[Check]:
    """Return what the text says of the figure."""

    def dominant(one: xr.Dataset, basis: str, cam: float) -> float:
        frequencies, found = lines(one.sel({BASIS: basis, CAM: cam}))
        there = frequencies <= _HIGHEST
        return float(frequencies[int(np.argmax(found[there]))])

    def away(one: xr.Dataset) -> float:
        found, passing = ridge(one)
        return float(np.abs(found - passing).max())

    found = [
        Check(
            name=f"dominant frequency below {_HIGHEST:g} Hz at 350 km/h, "
            f"layer {cam / 1e6:g} MN/m {words}, Hz",
            stated="17",
            found=article.both(lambda one, b=basis, k=cam: dominant(one, b, k), parts["steady"]),
            low=16.5,
            high=17.5,
        )
        for basis, words in BASES.items()
        for cam in _CAMS
    ]
    found.append(
        Check(
            name="dominant frequency while speeding up, off the slab passing, Hz",
            stated="caused by the slabs (here: 0.5)",
            found=article.both(away, parts["ramp"]),
            high=0.5,
            digits=2,
        )
    )
    return found


def draw(parts: dict[str, xr.Dataset], path: Path, title: str) -> None:
    """Draw time history and spectrum at 350 km/h, and the spectrogram of the ramp."""

    def steady_of(axes: Axes, one: xr.Dataset, cam: float) -> None:
        part = parts["steady"].sel({"setting": one["setting"], CAM: cam})
        for basis, words in BASES.items():
            time, values = last_slabs(part.sel({BASIS: basis}), 4)
            label = f"{cam / 1e6:g} MN/m {words}"
            axes.plot(time, values * _MICRO, color=_COLOURS[basis], lw=1.0, label=label)
        axes.set_xlabel("time (s), 350 km/h")
        axes.set_ylabel("deflection (µm)")

    def spectrum(axes: Axes, one: xr.Dataset) -> None:
        part = parts["steady"].sel(setting=one["setting"])
        for cam, marker in zip(_CAMS, ("o", "x"), strict=True):
            for basis, words in BASES.items():
                frequencies, found = lines(part.sel({BASIS: basis, CAM: cam}))
                there = (frequencies > 0.0) & (frequencies <= 200.0) & (found > 1e-9)
                label = f"{cam / 1e6:g} MN/m {words}"
                axes.semilogy(
                    frequencies[there],
                    found[there] * _MICRO,
                    marker,
                    ms=4,
                    color=_COLOURS[basis],
                    label=label,
                )
        axes.set_xlabel("frequency (Hz), 350 km/h")
        axes.set_ylabel("amplitude (µm)")

    def profile(axes: Axes, one: xr.Dataset) -> None:
        time, way, values = records(parts["ramp"].sel(setting=one["setting"]))
        rows = round(_RUNNING / (time[1] - time[0]))
        slow = np.convolve(values, np.full(rows, 1.0 / rows), mode="same")
        there = slice(2 * rows, -rows)
        axes.plot(time[there], (values - slow)[there] * _MICRO, color="#0072B2", lw=0.6)
        axes.set_xlabel("time (s), speeding up, 300 MN/m per slab")
        axes.set_ylabel("deflection (µm)")
        speed = axes.twinx()
        speed.plot(time[there], 3.6 * np.gradient(way, time)[there], color="#D55E00", lw=1.4)
        speed.set_ylabel("speed (km/h)", color="#D55E00")

    def map_of(axes: Axes, one: xr.Dataset) -> None:
        part = parts["ramp"].sel(setting=one["setting"])
        time, speed, frequencies, found = spectrogram(part)
        there = frequencies <= _HIGHEST
        decibel = 20.0 * np.log10(np.maximum(found[there] * _MICRO, 1e-3))
        top = float(decibel[frequencies[there] > _LOWEST].max())
        about = {"vmin": top - 40.0, "vmax": top, "rasterized": True}
        picture = axes.pcolormesh(time, frequencies[there], decibel, **about)
        axes.plot(time, speed / PITCH, ":", color="w", lw=1.4)
        axes.set_xlabel("time (s), speeding up; dotted: slab passing")
        axes.set_ylabel("frequency (Hz)")
        bar = axes.inset_axes((1.02, 0.0, 0.03, 1.0))
        axes.figure.colorbar(picture, cax=bar, label="dB (1 µm)")

    settings = parts["steady"][["steady"]].isel({BASIS: 0, CAM: 0}, drop=True)
    rows = [
        *(lambda axes, one, k=cam: steady_of(axes, one, k) for cam in _CAMS),
        spectrum,
        profile,
        map_of,
    ]
    panels(settings, rows, path, title=title, height=2.6)
