"""Threads of this process: the kernels release the interpreter's lock."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.worker import Block, Task, compute_block


class ThreadExecutor(Executor):
    """Computes tasks in threads of this process."""

    def __init__(self, workers: int) -> None:
        super().__init__(workers)
        self._pool = ThreadPoolExecutor(workers)

    def __exit__(self, *exception: object) -> None:
        self._pool.shutdown(wait=exception[0] is None, cancel_futures=True)

    def most_in_flight(self) -> int:
        """A task for each slot: handing over takes no time, so blocks are cut as late as can be."""
        return self.slots

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to a thread."""
        return self._pool.submit(compute_block, task)


def executor_for(execution: Execution) -> Executor:
    """As many threads as the config has workers."""
    return ThreadExecutor(execution.workers)
