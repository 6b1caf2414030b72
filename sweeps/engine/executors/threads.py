"""Threads of this process."""

from __future__ import annotations

from stickslip.dispatch.thread_pool import ThreadExecutor
from stickslip.dispatch.workers import Executor
from sweeps.config.schema import Execution


def executor_for(execution: Execution) -> Executor:
    """Return an executor with as many threads as the config has workers."""
    return ThreadExecutor(execution.slots)
