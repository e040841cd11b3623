"""Workers for the points: processes of this machine, or any Dask cluster by its address."""

from __future__ import annotations

import contextlib
import logging
import os
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import dask.config
import xarray as xr
from distributed import Client, LocalCluster, WorkerPlugin, as_completed

from rail_cosim.errors import ParameterError, RailCosimError
from rail_cosim.interrupts import without_interrupts
from rail_cosim.sweeps.plan import FmuFile, Task
from rail_cosim.sweeps.point import PointResult, received, run_point

_CONNECT = "20s"
_SETTINGS = {
    # A point on which a worker died is tried once more, not three times.
    "distributed.scheduler.allowed-failures": 1,
    "distributed.comm.timeouts.connect": _CONNECT,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": False,
    # By default watching itself takes 4 % of a processor, and 3 % of each worker's.
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "500ms",
    "distributed.worker.profile.enabled": False,
}


class FmuDelivery(WorkerPlugin):
    """Writes the sweep's FMUs to the cache of each worker, also of one that comes later."""

    def __init__(self, files: Sequence[tuple[FmuFile, bytes]]) -> None:
        self.files = tuple(files)
        self.name = "rail-cosim " + " ".join(sorted(file.identity for file, _ in files))

    def setup(self, worker: object) -> None:
        """Write what is not there yet."""
        for file, content in self.files:
            deliver(file, content)


def deliver(file: FmuFile, content: bytes) -> None:
    """Write an FMU to the cache, whole or not at all."""
    path = received(file)
    if path.is_file():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    number, scratch = tempfile.mkstemp(prefix=".", dir=path.parent)
    with open(number, "wb") as target:
        target.write(content)
    os.replace(scratch, path)


def worker_count(wanted: int | None, tasks: int) -> int:
    """Return the number of local workers: as many as processors, not more than tasks.

    Raises
    ------
    ParameterError
        If less than one is wanted.
    """
    if wanted is not None and wanted < 1:
        raise ParameterError("--workers", wanted, "must be at least 1")
    available = os.cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):
        available = len(os.sched_getaffinity(0))
    return max(1, min(wanted or available, tasks))


@contextlib.contextmanager
def connected(scheduler: str | Client | None, workers: int) -> Iterator[Client]:
    """Give a client: of the scheduler at an address, or of processes started for it.

    Raises
    ------
    RailCosimError
        If no scheduler answers at the address.
    """
    if isinstance(scheduler, Client):
        yield scheduler
        return
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(_SETTINGS))
        if scheduler is None:
            stack.enter_context(_quiet())
            folder = stack.enter_context(
                tempfile.TemporaryDirectory(prefix="rail-cosim-", ignore_cleanup_errors=True)
            )
            with without_interrupts():
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,  # pyright: ignore[reportArgumentType]
                    local_directory=folder,
                    silence_logs=logging.CRITICAL,
                )
            stack.enter_context(cluster)
            scheduler = str(cluster.scheduler_address)
        try:
            client = stack.enter_context(Client(scheduler, timeout=_CONNECT))
        except (OSError, ValueError) as error:
            raise RailCosimError(
                f"--scheduler = {scheduler!r}: there is no Dask scheduler at this address ({error})"
            ) from error
        yield client


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep Dask's own log off the terminal while the cluster comes and goes.

    So it is with its warning that another sweep has the usual port of its status page.
    """
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Port .* is already in use")
            yield
    finally:
        logger.setLevel(before)


def results(
    client: Client,
    tasks: Sequence[Task],
    files: Mapping[str, Path],
    evaluate: Callable[[Task], PointResult] = run_point,
) -> Iterator[tuple[Task, PointResult]]:
    """Run tasks on the workers and give each one's result as soon as it is there.

    Parameters
    ----------
    client
        Of the cluster.
    tasks
        No two with the same key.
    files
        The FMUs by identity; the workers are sent them.
    evaluate
        What the workers do with a task.
    """
    names = {file.identity: file for task in tasks for file in task.fmus.values()}
    sent = [(names[identity], path.read_bytes()) for identity, path in files.items()]
    client.register_plugin(FmuDelivery(sent))
    waiting = {
        client.submit(evaluate, task, key=f"rail-cosim-{task.key}", pure=False): task
        for task in tasks
    }
    for future in as_completed(list(waiting)):
        task = waiting.pop(future)
        yield task, _result(future)
        future.release()


def _result(future) -> PointResult:
    error = future.exception() if future.status == "error" else None
    if error is None and future.status == "finished":
        return future.result()
    reason = f"{type(error).__name__}: {error}" if error else f"the task was {future.status}"
    return PointResult(data=xr.Dataset(), error=f"no result ({reason})", lasting=False)
