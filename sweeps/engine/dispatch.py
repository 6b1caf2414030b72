"""The points of a grid over the workers of an executor, whatever happens to the workers."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.options import Options
from sweeps.engine.executors.base import Executor, ExecutorError, WorkersLostError
from sweeps.engine.executors.worker import Block, Task, failed_block, is_answer, task_of
from sweeps.engine.order.cut import blocks_of
from sweeps.engine.order.follow import Lines
from sweeps.engine.order.product import Blocks
from sweeps.engine.order.stragglers import Stragglers
from sweeps.engine.progress.in_flight import InFlight
from sweeps.engine.signals import Stop
from sweeps.grid import Grid

# A worker may die for reasons of its own, such as a machine that is taken away.
_DEATHS_OF_A_POINT = 3


def finished_blocks(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    executor: Executor,
    stop: Stop,
    *,
    block_points: int | None = None,
    pilot: int = 0,
    in_flight: InFlight | None = None,
) -> Iterator[Block]:
    """The points of a grid that are not done, computed, block by block as they are finished.

    After a request to stop no further block is begun, and those in flight still come. Where workers
    die, the blocks in flight are given again one at a time and in ever smaller pieces, until the
    point, or the line, is alone that no worker survives; it gets the status `failed`. `in_flight`
    always knows which tasks have not come back.

    Raises ExecutorError where something else than a block comes back.
    """
    seconds = executor.block_seconds
    blocks = blocks_of(
        grid, done, executor.slots, seconds=seconds, block_points=block_points, pilot=pilot
    )
    in_flight = in_flight or InFlight()
    stragglers = Stragglers(block_points, ever=not grid.followed)
    tasks = _Tasks(grid, options, blocks, stragglers, executor, stop, in_flight)
    suspects: list[Task] | None = []
    while suspects is not None:
        yield from _one_at_a_time(suspects, executor, stop, in_flight)
        suspects = None
        try:
            for block in executor.blocks(tasks, stop):
                if len((finished := tasks.finished(block)).indices):
                    yield finished
        except WorkersLostError:
            suspects = [replace(task, patience=0) for task in in_flight.clear()]


class _Tasks:
    """The tasks of a sweep, taken by several threads."""

    def __init__(
        self,
        grid: Grid,
        options: Options,
        blocks: Blocks | Lines,
        stragglers: Stragglers,
        executor: Executor,
        stop: Stop,
        in_flight: InFlight,
    ) -> None:
        self._grid, self._options, self._stop = grid, options, stop
        self._blocks, self._cut = blocks, iter(blocks)
        self._stragglers = stragglers
        self._rest: list[NDArray[np.int64]] = []
        self._late: set[int] = set()  # first points of tasks for late points
        self._in_flight, self._executor = in_flight, executor
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[Task]:
        return self

    def __next__(self) -> Task:
        with self._lock:
            if self._stop.requested:
                raise StopIteration
            task = self._next()
            self._in_flight.begin(task)
            return task

    def _next(self) -> Task:
        """Late points where there are enough of them, else a block of the cut, then the rest.

        Raises StopIteration where nothing can be begun before blocks in flight come back.
        """
        late = self._stragglers.together()
        if late is None and (block := next(self._cut, None)) is not None:
            return task_of(self._grid, block, self._options, self._stragglers.patience)
        if late is None:
            if not any(task.patience for task in self._in_flight.tasks):
                self._rest += self._stragglers.rest(self._executor.slots)
            if not self._rest:
                raise StopIteration
            late = self._rest.pop(0)
        self._late.add(int(late[0]))
        return task_of(self._grid, late, self._options)

    def finished(self, block: Block) -> Block:
        """What is finished of a block; raises ExecutorError where it is that of no task."""
        task = self._in_flight.end(_first_point(block))
        _require_answer(block, task)
        if task is not None:
            late = int(task.indices[0]) in self._late
            learning = self._stragglers if late else self._blocks
            learning.learn(len(block.indices), block.seconds)
        return block.part(self._stragglers.finished(block.indices, block.results))


def _one_at_a_time(
    suspects: list[Task], executor: Executor, stop: Stop, in_flight: InFlight
) -> Iterator[Block]:
    waiting, deaths = deque(suspects), 0
    while waiting and not stop.requested:
        task = waiting.popleft()
        in_flight.begin(task)
        try:
            for block in executor.blocks(iter([task]), stop):
                _require_answer(block, in_flight.end(_first_point(block)))
                yield block
            deaths = 0
        except WorkersLostError as error:
            in_flight.clear()
            if len(task.indices) > task.line:
                waiting.extendleft(reversed(_halves(task)))
                continue
            deaths += error.deaths
            if deaths < _DEATHS_OF_A_POINT:
                waiting.appendleft(task)
            else:
                deaths = 0
                yield failed_block(task, str(error))


def _first_point(block: object) -> int:
    """The number of the first point of a block; -1 for what is none."""
    return int(block.indices[0]) if isinstance(block, Block) and len(block.indices) else -1


def _require_answer(block: object, task: Task | None) -> None:
    """Raise ExecutorError where something else came back than the block of a task."""
    if task is None or not is_answer(block, task):
        raise ExecutorError(
            "what came back from a worker is not the block that was asked for; what is finished is "
            "kept, and the same command resumes"
        )


def _halves(task: Task) -> list[Task]:
    middle = len(task.indices) // task.line // 2 * task.line
    parts = (slice(None, middle), slice(middle, None))
    return [replace(task, indices=task.indices[p], points=task.points[p]) for p in parts]
