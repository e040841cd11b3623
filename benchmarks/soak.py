"""A long run in one go: nothing drifts, and the memory does not grow.

    python benchmarks/soak.py --kilometres 100 --out soak

Runs ``rail-cosim run`` as a process of its own, at 300 km/h on the line HD, watches its memory,
and then reads its results part by part. Writes soak.json and soak.png; exit status 1 if something
drifts or grows.
"""

from __future__ import annotations

import argparse
import itertools
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

EVERY = 10
GROWTH = 0.02  # of the memory after the first tenth of the run
DRIFT = 1e-4  # of the mean wheel force on smooth track, from the second interval to the last


def resident(process: int) -> float:
    """Resident memory of a process in MB."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * 4096e-6


def watched(command: list[str], out: Path, seconds: float = 5.0) -> list[tuple[float, float, bool]]:
    """Run a command; return its memory over time: s, MB, whether it is writing its results."""
    begin, curve = time.monotonic(), []
    with subprocess.Popen(command) as process:
        while process.poll() is None:
            writing = any(out.glob(".*.nc.*.part")) or any(out.glob("*.nc"))
            curve.append((time.monotonic() - begin, resident(process.pid), writing))
            time.sleep(seconds)
    if process.returncode:
        sys.exit(process.returncode)
    return curve


def intervals(file: Path, length: float) -> dict[str, list[float]]:
    """Figures of each interval of so many metres."""
    found: dict[str, list[float]] = {
        name: [] for name in ("end", "mean_force", "half_range", "rms_acceleration", "window")
    }
    with xr.open_dataset(file, engine="h5netcdf") as data:
        way = data["distance"].to_numpy()
        edges = np.searchsorted(way, np.arange(0.0, way[-1] + 1e-6, length))
        for first, last in itertools.pairwise(edges):
            part = data.isel(time=slice(first, last))
            force = part["normal_force"].to_numpy()
            position = part["wheelset_longitudinal_position"].isel(wheelset=0).to_numpy()
            found["end"].append(float(way[last - 1]))
            found["mean_force"].append(float(force.mean()))
            found["half_range"].append(float(np.ptp(force, axis=0).max() / 2.0))
            box = part["axle_box_vertical_acceleration"].to_numpy()
            found["rms_acceleration"].append(float(np.sqrt(np.mean(box**2))))
            ahead = position - part["window_start_position"].to_numpy()
            found["window"].append(float(ahead.max()))
        found["energy_share"] = [float(data.attrs["interface_energy_residual_share"])]
        found["slides"] = [float(data["window_slide_count"][-1])]
        found["real_time_factor"] = [float(data.attrs["real_time_factor"])]
    return found


def picture(
    curve: list[tuple[float, float, bool]], found: dict[str, list[float]], path: Path
) -> None:
    """Draw memory over time, mean force and acceleration over distance."""
    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1)
    top.plot([t / 60.0 for t, _, _ in curve], [m for _, m, _ in curve])
    top.set(xlabel="time (min)", ylabel="memory (MB)", ylim=(0.0, None))
    way = [1e-3 * end for end in found["end"]]
    middle.plot(way, found["mean_force"], ".-")
    middle.set(xlabel="distance (km)", ylabel="mean wheel force (N)")
    middle.ticklabel_format(useOffset=False)
    bottom.plot(way, found["rms_acceleration"], ".-")
    bottom.set(xlabel="distance (km)", ylabel="axle-box acceleration,\nrms (m/s²)")
    figure.savefig(path, dpi=150)


def main() -> int:
    """Run, evaluate, judge."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kilometres", type=float, default=100.0)
    parser.add_argument("--irregularity", default="", help="name or file; smooth by default")
    parser.add_argument("--out", type=Path, default=Path("soak"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    file = asked.out / "soak.nc"
    command = [sys.executable, "-m", "rail_cosim.cli", "run", "--line", "HD", "--speed", "300"]
    command += ["--distance", str(1e3 * asked.kilometres), "--record-every", str(EVERY)]
    command += ["--out", str(file)]
    if asked.irregularity:
        command += ["--irregularity", asked.irregularity]
    file.unlink(missing_ok=True)
    curve = watched(command, asked.out)
    found = intervals(file, 50.0 * asked.kilometres)
    stepping = [memory for _, memory, writing in curve if not writing]
    stepping = stepping[len(stepping) // 10 :]
    growth = max(stepping) / stepping[0] - 1.0
    largest = max(memory for _, memory, _ in curve)
    drift = abs(found["mean_force"][-1] / found["mean_force"][1] - 1.0)
    result = {
        "memory_growth": growth,
        "largest_memory": largest,
        "mean_force_drift": drift,
        "memory": curve,
        **found,
    }
    (asked.out / "soak.json").write_text(json.dumps(result, indent=1))
    picture(curve, found, asked.out / "soak.png")
    print(
        f"memory: {stepping[0]:.1f} MB after a tenth of the run, grew by {100 * growth:.3f} % to "
        f"its end; {largest:.0f} MB while results are written and evaluated"
    )
    print(f"mean wheel force: changed by {100 * drift:.4f} % from the second interval to the last")
    print(f"slides {found['slides'][0]:.0f}, energy share {found['energy_share'][0]:.3g}")
    return int(growth > GROWTH or (drift > DRIFT and not asked.irregularity))


if __name__ == "__main__":
    sys.exit(main())
