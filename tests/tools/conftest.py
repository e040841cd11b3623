"""The pair for other tools, and what our own master makes of it with the algorithm they have."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tool_hosts import STEPS, missing

WAY = 26.0  # m, five slides


@dataclasses.dataclass(frozen=True)
class Pair:
    """The built system at rest, and the records of our master's Jacobi run of it."""

    folder: Path
    records: xr.Dataset

    @property
    def ssp(self) -> Path:
        return self.folder / "VehicleOnSlabTrack.ssp"

    def __getitem__(self, name: str) -> np.ndarray:
        """Return an output by its name in the FMU, shape (steps + 1,)."""
        records = self.records
        if name == "window.slide_count":
            return records["window_slide_count"].to_numpy()
        group, _, last = name.partition("].")
        which = {"wheelset": int(group[-1])}
        if last.startswith(("left.", "right.")):
            side, _, last = last.partition(".")
            which["side"] = side
        quantity = {"axle_box": f"axle_box_{last}", "wheelset": last}[group.partition("[")[0]]
        if quantity == "vertical_displacement":
            quantity = "wheelset_vertical_displacement"
        return records[quantity].sel(which).to_numpy()


@pytest.fixture(scope="session")
def pair(fmus, tmp_path_factory) -> Pair:
    folder = tmp_path_factory.mktemp("pair")
    fmus.command("build", "--at-rest", "--out", folder)
    path = folder / "reference.nc"
    system = folder / "VehicleOnSlabTrack.ssp"
    fmus.invoke("run", system, "--algorithm", "jacobi", "--distance", WAY, "--out", path)
    with xr.open_dataset(path, engine="h5netcdf") as file:
        records = file.load()
    assert records.sizes["time"] == STEPS + 1
    assert records["window_slide_count"][-1] >= 5
    return Pair(folder, records)


def pytest_collection_modifyitems(items):
    """Mark the tests of this folder, and skip those whose tool is not there, saying why."""
    here = Path(__file__).parent
    for item in items:
        if here not in item.path.parents:
            continue
        item.add_marker(pytest.mark.tools)
        tool = getattr(item.module, "TOOL", None)
        if tool and (reason := missing(tool)):
            item.add_marker(pytest.mark.skip(reason=reason))
