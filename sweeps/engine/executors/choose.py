"""The executor that a config asks for."""

from __future__ import annotations

from importlib import import_module

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor
from sweeps.executor_table import EXECUTORS


def make_executor(execution: Execution) -> Executor:
    """The executor that a config asks for; entering it may raise ExecutorError."""
    module = import_module(f"{__package__}.{EXECUTORS[execution.backend].module}")
    executor: Executor = module.executor_for(execution)
    return executor
