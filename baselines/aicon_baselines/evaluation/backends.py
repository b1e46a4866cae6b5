"""Where the jobs of a comparison run: processes on this machine, or a dask cluster."""

import os
import time
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from threading import Thread
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError, check_known
from aicon_baselines.extras import naming_extra, require

with naming_extra():
    from joblib import parallel_config

BACKENDS = ("loky", "dask")
"""Names of the backends, the usual one first."""

_INTERVAL = 0.2  # s between two looks at the parent


@contextmanager
def joblib_backend(name: str, jobs: int, scheduler: str | None) -> Iterator[None]:
    """Make joblib use a backend while the context lasts.

    Args:
        name: "loky" for processes on this machine, "dask" for joblib's own dask backend.
        jobs: Number of processes.
        scheduler: Address of a running dask scheduler, which then decides about processes; without
            one, "dask" starts a cluster on this machine.
    """
    check_known("backend", name, BACKENDS)
    if scheduler is not None and name != "dask":
        raise ComparisonError(f"a scheduler belongs to the dask backend, not to {name!r}")

    # What is opened here is closed with the context, in the opposite order.
    with ExitStack() as stack:
        if name == "dask":
            _connect(stack, jobs, scheduler)
            stack.enter_context(parallel_config(name, n_jobs=jobs))
        else:
            # Even a worker that has not been given anything to do yet.
            tied: dict[str, Any] = {"initializer": end_with, "initargs": (os.getpid(),)}
            stack.enter_context(parallel_config(name, n_jobs=jobs, **tied))

            # One that has grown with what it compiled makes way for another, which is no fault.
            stack.enter_context(warnings.catch_warnings())
            warnings.filterwarnings("ignore", "A worker stopped while some jobs")
        yield


def _connect(stack: ExitStack, jobs: int, scheduler: str | None) -> None:
    """Open a client of dask that is closed with the stack, and a local cluster if need be."""
    require("the dask backend", "cluster", "distributed")
    distributed = import_module("distributed")

    if scheduler is None:
        # Port 0 is any free one: its usual port may be taken by another cluster of this machine.
        cluster = distributed.LocalCluster(
            n_workers=jobs, threads_per_worker=1, dashboard_address="localhost:0"
        )
        scheduler = stack.enter_context(cluster)

    try:
        stack.enter_context(distributed.Client(scheduler))
    except (OSError, ValueError) as error:
        raise ComparisonError(f"no dask scheduler answers at {scheduler}: {error}") from error


def end_with(parent: int) -> None:
    """End this process soon after its parent, however that ended.

    The parent may be killed without a chance to tell anyone. Its children then belong to another
    process, which is how they notice.

    Args:
        parent: Process number of the parent; where that is this process itself, nothing happens.
    """
    if os.getpid() != parent:
        Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_INTERVAL)
    os._exit(1)  # at once: there is nobody left to tell
