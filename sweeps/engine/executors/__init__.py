"""Executors of blocks: threads, processes, or the workers of a dask cluster."""

from __future__ import annotations

from importlib import import_module

import joblib

from stickslip.dispatch.backend import named_jobs, named_workers
from stickslip.dispatch.workers import Executor, Workers
from sweeps.config.schema import Execution
from sweeps.executor_table import EXECUTORS


def make_executor(execution: Execution) -> Executor:
    """Return the executor that a config names; entering it may raise ExecutorError."""
    module = import_module(f"{__name__}.{EXECUTORS[execution.backend].module}")
    executor: Executor = module.executor_for(execution)
    return executor


def workers_of(execution: Execution, jobs: int | None = None) -> Workers:
    """Return the workers that `joblib.parallel_config` names, else those that a config names.

    `jobs` is counted like joblib's `n_jobs`; the default is that of `parallel_config`, else that
    of the config.
    """
    jobs = next(number for number in (jobs, named_jobs(), execution.slots) if number is not None)
    if named := named_workers(jobs):
        return named
    return make_executor(execution.model_copy(update={"workers": joblib.effective_n_jobs(jobs)}))
