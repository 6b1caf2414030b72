"""The executor that a config asks for."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.dask import ClusterExecutor, LocalClusterExecutor
from sweeps.engine.executors.processes import ProcessExecutor
from sweeps.engine.executors.threads import ThreadExecutor


def _on_dask(execution: Execution) -> Executor:
    if execution.scheduler:
        return ClusterExecutor(execution.scheduler)
    return LocalClusterExecutor(execution.workers)


# By the name of `execution.backend` in a config; the schema lists the names too.
_EXECUTORS: Mapping[str, Callable[[Execution], Executor]] = {
    "threads": lambda execution: ThreadExecutor(execution.workers),
    "loky": lambda execution: ProcessExecutor(execution.workers),
    "dask": _on_dask,
}


def make_executor(execution: Execution) -> Executor:
    """The executor that a config asks for; entering it may raise ExecutorError."""
    return _EXECUTORS[execution.backend](execution)
