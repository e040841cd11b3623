"""Parameter sweeps: many runs on a Dask cluster, each kept as soon as it is done.

>>> import rail_cosim
>>> data = rail_cosim.sweep(
...     grid={"speed": [200, 250, 300], "track.fastener.vertical_stiffness": [40e6, 140e6]},
...     out="sweep.nc",
... )  # doctest: +SKIP

In a script of one's own this stands below ``if __name__ == "__main__":``, since local
workers are new processes that read the script.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from rail_cosim.cache import cache_directory
from rail_cosim.plot import check_format
from rail_cosim.results import check_netcdf, check_writable, write_netcdf
from rail_cosim.slave import Value
from rail_cosim.sweeps.assembly import assemble
from rail_cosim.sweeps.cluster import connected, results, worker_count
from rail_cosim.sweeps.plan import Plan, Task, make_plan
from rail_cosim.sweeps.plot import check_drawable, plot_sweep
from rail_cosim.sweeps.point import PointResult, run_point
from rail_cosim.sweeps.specification import (
    KEPT,
    SweepSpecification,
    read_specification,
    steps,
)
from rail_cosim.sweeps.store import Store
from rail_cosim.trust import foreign_remark

if TYPE_CHECKING:
    from distributed import Client

    from rail_cosim.reporter import Reporter

__all__ = [
    "KEPT",
    "Plan",
    "PointResult",
    "Store",
    "SweepSpecification",
    "execute_sweep",
    "make_plan",
    "plot_sweep",
    "read_specification",
    "run_plan",
    "steps",
    "store_of",
    "sweep",
]


def sweep(
    specification: str | Path | SweepSpecification | None = None,
    *,
    grid: Mapping[str, Sequence[Value]] | None = None,
    points: Sequence[Mapping[str, Value]] = (),
    run: Mapping[str, Any] | None = None,
    settings: Mapping[str, Value] | None = None,
    keep: Mapping[str, Sequence[str]] | None = None,
    window: Mapping[str, Any] | None = None,
    history: Sequence[str] = (),
    history_every: int = 1,
    scheduler: str | Client | None = None,
    workers: int | None = None,
    out: str | Path | None = None,
    store: str | Path | None = None,
    plot: str | Path | None = None,
    reporter: Reporter | None = None,
) -> xr.Dataset:
    """Run a vehicle on a track at many points; mirrors ``rail-cosim sweep``.

    Parameters
    ----------
    specification
        A TOML file (:func:`read_specification`), or what is made of it; or ``None``, and
        the next eight arguments.
    grid, points, run, settings, keep, window, history, history_every
        As in :class:`SweepSpecification`.
    scheduler
        Address of a Dask scheduler, or a client; ``None`` starts processes on this machine.
    workers
        Number of these processes; ``None`` for one per processor.
    out
        NetCDF file for the result.
    store
        Folder of the finished points; ``None`` for ``out`` with the ending ``.points``,
        without ``out`` a folder in the user's cache.
    plot
        Plot of a sweep over one or two axes (:func:`rail_cosim.plot_sweep`).
    reporter
        Told of stages, progress and warnings.

    Returns
    -------
    xarray.Dataset
        See :func:`rail_cosim.sweeps.assembly.assemble`.

    Raises
    ------
    RailCosimError
        If nothing can be run. Points that fail are in the result.
    """
    from rail_cosim.reporter import Quiet

    if specification is None:
        specification = SweepSpecification(
            grid=grid or {},
            points=points,
            run=run or {},
            settings=settings or {},
            keep=KEPT if keep is None else keep,
            window=window or {},
            history=history,
            history_every=history_every,
        )
    elif not isinstance(specification, SweepSpecification):
        specification = read_specification(Path(specification))
    return execute_sweep(
        specification,
        scheduler=scheduler,
        workers=workers,
        out=None if out is None else Path(out),
        store=None if store is None else Path(store),
        plot=None if plot is None else Path(plot),
        reporter=reporter or Quiet(),
    )


def execute_sweep(
    specification: SweepSpecification,
    *,
    scheduler: str | Client | None,
    workers: int | None,
    out: Path | None,
    store: Path | None,
    reporter: Reporter,
    plot: Path | None = None,
) -> xr.Dataset:
    """Run a sweep (see :func:`sweep`)."""
    if out:
        check_netcdf(out)
    if plot:
        check_format(plot)
        check_writable(plot)
        check_drawable(specification.axes if specification.grid else ())
    reporter.stage("finding the FMUs")
    plan = make_plan(specification)
    if not all(task.options.trust for task in plan.tasks):
        for path in plan.files.values():
            if text := foreign_remark(path):
                reporter.notice(text.replace("--trust", "trust = true below [run]"))
    found = run_plan(
        plan, Store(store or store_of(out)), reporter, scheduler=scheduler, workers=workers
    )
    dataset = assemble(plan, found)
    if out:
        write_netcdf(dataset, out)
    if plot and not bool((dataset["error"] != "").all()):
        plot_sweep(dataset, plot)
    return dataset


def store_of(out: Path | None) -> Path:
    """Return the folder in which the points of a result are kept unless another is named."""
    return out.with_suffix(".points") if out else cache_directory() / "points"


def run_plan(
    plan: Plan,
    store: Store,
    reporter: Reporter,
    *,
    scheduler: str | Client | None = None,
    workers: int | None = None,
    evaluate: Callable[[Task], PointResult] = run_point,
) -> list[PointResult]:
    """Return the results of all tasks of a plan: from the store, or run and put there.

    Raises
    ------
    RailCosimError
        If there are no workers, or the store cannot be written.
    """
    tasks = {task.key: task for task in plan.tasks}
    workers = worker_count(workers, len(tasks))
    done = {key: result for key in tasks if (result := store.load(key)) is not None}
    todo = [task for key, task in tasks.items() if key not in done]
    said: set[str] = set()
    for result in done.values():
        _pass_on(result, said, reporter)
    if todo:
        reporter.stage("starting the workers")
        with connected(scheduler, min(workers, len(todo))) as client:
            reporter.stage("running the points")
            reporter.progress(len(done), len(tasks))
            for task, result in results(client, todo, plan.files, evaluate):
                if result.lasting:
                    store.save(task.key, result)
                done[task.key] = result
                _pass_on(result, said, reporter)
                reporter.progress(len(done), len(tasks))
    return [done[task.key] for task in plan.tasks]


def _pass_on(result: PointResult, said: set[str], reporter: Reporter) -> None:
    for text in result.remarks:
        if text not in said:
            said.add(text)
            reporter.notice(text)
