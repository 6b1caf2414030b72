"""One block after the other, in the process that asks for them."""

from __future__ import annotations

from concurrent.futures import Future

from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.dispatch.workers import Executor
from sweeps.config.schema import Execution


class SerialExecutor(Executor):
    """Computes a task while it is handed over."""

    def __exit__(self, *exception: object) -> None:
        pass

    def most_in_flight(self) -> int:
        """One task: the next would be computed before this one is taken."""
        return 1

    def submit(self, task: Task) -> Future[Block]:
        """Compute a task."""
        future: Future[Block] = Future()
        future.set_result(compute_block(task))
        return future


def executor_for(execution: Execution) -> Executor:
    """One slot, however many workers the config has."""
    return SerialExecutor(slots=1)
