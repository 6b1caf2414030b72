"""An executor that computes one block after the other in this process."""

from __future__ import annotations

from concurrent.futures import Future

from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.dispatch.workers import Executor
from sweeps.config.schema import Execution


class SerialExecutor(Executor):
    """Computes each task when it is submitted."""

    def __exit__(self, *exception: object) -> None:
        pass

    def most_in_flight(self) -> int:
        """Return one, or the next task would be computed before this block is taken."""
        return 1

    def submit(self, task: Task) -> Future[Block]:
        """Compute a task, and return its finished future."""
        future: Future[Block] = Future()
        future.set_result(compute_block(task))
        return future


def executor_for(execution: Execution) -> Executor:
    """Return an executor with one slot, however many workers the config has."""
    return SerialExecutor(slots=1)
