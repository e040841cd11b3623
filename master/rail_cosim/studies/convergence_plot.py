"""Figure of the study of convergence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from rail_cosim.studies.plots import _BLUE, _DPI, _GRID, _RED, _figure

_STYLES = {"force": ("o-", "wheel force"), "acceleration": ("s--", "axle-box acceleration")}
_WORDS = {1: (_BLUE, "with residual compliance"), 0: (_RED, "plain series")}
_FLOOR = 1e-3  # %


def plot_convergence(dataset: xr.Dataset, path: Path) -> None:
    """Draw the errors over the number of modes, a row for each part, a column for each case."""
    cases = [str(case) for case in dataset["case"].to_numpy()]
    figure = _figure(8.4, 6.6)
    grid = figure.subplots(2, len(cases), sharex="row", sharey=True, squeeze=False)
    for row, part in zip(grid, ("rail", "slab"), strict=True):
        modes = dataset[f"{part}_modes"].to_numpy()
        for axes, case in zip(row, cases, strict=True):
            for residual, (colour, words) in _WORDS.items():
                for quantity, (style, name) in _STYLES.items():
                    error = dataset[f"{part}_{quantity}_error"]
                    values = 100.0 * np.abs(error.sel(residual=residual, case=case).to_numpy())
                    # The reference itself has no error to draw.
                    values = np.where(values > 0.0, values.clip(_FLOOR), np.nan)
                    label = f"{name}, {words}"
                    axes.loglog(modes, values, style, color=colour, lw=1.1, ms=3.5, label=label)
            other = f"{part}_force_finite_elements"
            if other in dataset:
                level = 100.0 * abs(float(dataset[other].sel(case=case)))
                label = "finite elements, wheel force"
                axes.axhline(max(level, _FLOOR), color="0.35", ls=":", lw=1.2, label=label)
            axes.set_xticks(modes, [str(m) for m in modes])
            axes.tick_params(axis="x", labelrotation=45, labelsize=8)
            axes.minorticks_off()
            axes.set_title(case, loc="left", fontsize=10)
            axes.set_xlabel(f"{part} modes")
            axes.grid(**_GRID)
        row[0].set_ylabel("error against the finest (%)")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False, fontsize=8)
    figure.savefig(path, dpi=_DPI)
