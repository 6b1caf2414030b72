"""Workers that are threads of this process; kernels release the interpreter's lock."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial

from stickslip.dispatch.stop import in_thread
from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.dispatch.workers import Executor


class ThreadExecutor(Executor):
    """Computes each task in a new thread of this process.

    The threads are daemons. After Ctrl-C the threads of `concurrent.futures` would keep the
    interpreter alive until their blocks are finished, which can take minutes.
    """

    in_this_process = True

    def __exit__(self, *exception: object) -> None:
        pass  # a thread ends with its block

    def most_in_flight(self) -> int:
        """Return one block for each slot: handing it over takes no time, so none has to wait."""
        return self.slots

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to a thread."""
        return in_thread(partial(compute_block, task))
