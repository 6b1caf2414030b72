"""The common part of all executors: their interface, and the loop that hands out tasks."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import queue
import signal
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from concurrent.futures import Future
from itertools import islice
from typing import Self

from stickslip.dispatch.errors import WorkersLostError
from stickslip.dispatch.stop import Stop
from stickslip.dispatch.task import Block, Task

Tasks = Iterator[Task]
_Finished = queue.SimpleQueue[Future[Block]]
_InFlight = dict[Future[Block], Task]

SILENCE_SECONDS = 5.0  # after this time without a block we ask the executor for the reason
_LOOK_SECONDS = 0.5  # a signal that arrives just before a wait takes effect after it


class Workers(ABC):
    """Workers compute tasks and return blocks in any order; used as a context manager.

    They compute `slots` tasks at the same time, a number that may change as workers come and go. A
    block should last `block_seconds`, so that handing it over costs next to nothing.
    """

    block_seconds = 1.0

    in_this_process = False
    """Whether they know the laws that were registered in this process."""

    def __init__(self, slots: int) -> None:
        self.slots = slots

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *exception: object) -> None: ...

    @abstractmethod
    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        """Yield the finished blocks of the tasks; take a task only when it can start soon.

        After a request to stop, blocks that have no worker or no time limit are not yielded, and
        after a while none are.

        Raises WorkersLostError when no more blocks can arrive; the caller must then compute the
        missing ones again.
        """

    def kill(self) -> None:
        """Kill all processes at once."""
        # A signal handler calls this, so it must not wait for a lock.
        for child in multiprocessing.active_children():
            with contextlib.suppress(OSError):
                os.kill(child.pid or 0, signal.SIGKILL)


class Executor(Workers):
    """Workers that get one task after the other."""

    @abstractmethod
    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to a worker; raises WorkersLostError."""

    def result(self, future: Future[Block]) -> Block:
        """Return the block of a finished task; raises WorkersLostError and ExecutorError."""
        return future.result()

    def most_in_flight(self) -> int:
        """Return the largest number of tasks in flight: two for each slot, one of them waiting."""
        return 2 * self.slots

    def is_deserted(self) -> bool:
        """Return whether there are no workers at present."""
        return False

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        """Yield the finished blocks, keeping `most_in_flight` tasks in flight."""
        finished: _Finished = queue.SimpleQueue()
        in_flight: _InFlight = {}
        lost = None
        while True:
            try:
                if lost is None:
                    self._hand_out(tasks, in_flight, finished)
            except WorkersLostError as error:
                lost = error
            future = self._next(finished, in_flight, stop) if in_flight else None
            if future is None:
                break
            del in_flight[future]
            try:
                block = self.result(future)
            except WorkersLostError as error:
                lost = error  # other blocks in flight may still come
            else:
                yield block
        if in_flight:
            self.give_up()
        if lost is not None:
            raise lost

    def give_up(self) -> None:
        """End the computations in flight, if the workers can."""

    def _hand_out(self, tasks: Tasks, in_flight: _InFlight, finished: _Finished) -> None:
        for task in islice(tasks, max(self.most_in_flight() - len(in_flight), 0)):
            future = self.submit(task)
            in_flight[future] = task
            future.add_done_callback(finished.put)

    def _next(self, finished: _Finished, in_flight: _InFlight, stop: Stop) -> Future[Block] | None:
        """Return the next finished future; None if a stop was requested and the wait is over."""
        since = time.monotonic()
        while True:
            with contextlib.suppress(queue.Empty):
                return finished.get(timeout=_LOOK_SECONDS)
            if stop.requested and all(task.is_unlimited for task in in_flight.values()):
                return None
            if stop.is_over:
                return None
            if time.monotonic() - since < SILENCE_SECONDS:
                continue
            if self.is_deserted() and stop.requested:
                return None
            since = time.monotonic()


def first_line(error: BaseException) -> str:
    """Return the first line of an error's message."""
    return (str(error).splitlines() or [repr(error)])[0]
