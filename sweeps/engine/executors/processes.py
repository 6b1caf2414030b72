"""Processes of this machine."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from stickslip.dispatch.children import children_started, process_pool
from stickslip.dispatch.errors import WorkersLostError
from stickslip.dispatch.stop import Stop
from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.dispatch.workers import Executor, Tasks, first_line
from sweeps.config.schema import Execution


class ProcessExecutor(Executor):
    """Computes tasks in processes that joblib's loky starts.

    The standard library's pool would run the user's `__main__` again in each process.
    """

    def __init__(self, workers: int) -> None:
        super().__init__(workers)
        self._pool: Any = None

    def __exit__(self, *exception: object) -> None:
        self._shut_down(kill=exception[0] is not None)

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        """Yield the finished blocks; a pool that has lost a process is replaced by a new one."""
        try:
            yield from super().blocks(tasks, stop)
        except WorkersLostError:
            self._shut_down(kill=True)
            raise

    def give_up(self) -> None:
        """End the processes."""
        self._shut_down(kill=True)

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to a process; the first task starts them all. Raises WorkersLostError."""
        try:
            with children_started():
                future: Future[Block] = self._started().submit(compute_block, task)
        except BrokenProcessPool as error:
            raise WorkersLostError(first_line(error)) from error
        return future

    def result(self, future: Future[Block]) -> Block:
        """Return the block of a finished task; raises WorkersLostError."""
        try:
            return future.result()
        except BrokenProcessPool as error:
            raise WorkersLostError(first_line(error)) from error

    def _started(self) -> Any:
        if self._pool is None:
            self._pool = process_pool(self.slots)
        return self._pool

    def _shut_down(self, *, kill: bool) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, kill_workers=kill)
            self._pool = None


def executor_for(execution: Execution) -> Executor:
    """Return an executor with as many processes as the config has workers."""
    return ProcessExecutor(execution.slots)
