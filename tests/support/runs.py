"""Runs of ``rail-cosim run`` for tests, and what is looked at in their results."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import xarray as xr
from product import Product
from reference_fe import band_limited_amplitude

GOLDEN = Path(__file__).parents[1] / "golden" / "steady_state_amplitudes.json"


@dataclasses.dataclass(frozen=True)
class Run:
    """Results of one run, and what it printed."""

    data: xr.Dataset
    out: str
    err: str
    folder: Path

    def __getitem__(self, name: str) -> np.ndarray:
        return self.data[name].to_numpy()

    @property
    def slides(self) -> np.ndarray:
        """The way by which the window moved at each slide, m."""
        moved = np.diff(self["window_start_position"])
        return moved[moved != 0.0]

    def amplitude(self, name: str, pitch: float) -> np.ndarray:
        """Half the peak-to-peak up to 500 Hz over the last slab pitch."""
        time, way = self["time"], self["distance"]
        speed = (way[-1] - way[0]) / (time[-1] - time[0])
        return band_limited_amplitude(time, self[name], window=pitch / speed)


def run(product: Product, folder: Path, *arguments: object) -> Run:
    """Run the command line with these arguments and read its file."""
    done = product.invoke("run", *arguments, "--out", folder / "run.nc")
    with xr.open_dataset(folder / "run.nc", engine="h5netcdf") as file:
        return Run(file.load(), done.stdout, done.stderr, folder)


def golden_amplitudes(speed_kmh: float, pad_stiffness: float) -> tuple[np.ndarray, float] | None:
    """Return wheel-force amplitudes of the whole vehicle (N, per wheelset) and their error.

    From the independent finite-element track; None where the table has no such case.
    """
    table = json.loads(GOLDEN.read_text())
    wanted = ("vehicle", speed_kmh, pad_stiffness, 52e3)
    for case in table["cases"]:
        keys = ("vehicle", "speed_kmh", "pad_stiffness", "pad_damping")
        if tuple(case[key] for key in keys) == wanted:
            return np.array(case["wheel_force_amplitude"]), case["error_estimate"]
    return None
