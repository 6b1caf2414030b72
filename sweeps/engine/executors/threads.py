"""Threads of this process: the kernels release the interpreter's lock."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.worker import Block, Task, compute_block
from sweeps.engine.signals import in_thread


class ThreadExecutor(Executor):
    """Computes tasks in threads of this process, each in one of its own.

    They are daemons: after Ctrl-C those of `concurrent.futures` would keep the interpreter alive
    until their blocks are finished, which can take minutes.
    """

    def __exit__(self, *exception: object) -> None:
        pass  # a thread ends with its block

    def most_in_flight(self) -> int:
        """Return one for each slot: handing over takes no time, so blocks are cut late."""
        return self.slots

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to a thread."""
        return in_thread(partial(compute_block, task))


def executor_for(execution: Execution) -> Executor:
    """Make as many threads as the config has workers."""
    return ThreadExecutor(execution.slots)
