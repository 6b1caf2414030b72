"""The points of a grid over the workers of an executor, whatever happens to the workers."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from stickslip.options import Options
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.schema import Execution
from sweeps.engine.counts import InFlight
from sweeps.engine.executors.base import Executor, ExecutorError, Workers, WorkersLostError
from sweeps.engine.executors.worker import Block, Task, failed_block, is_answer, task_of
from sweeps.engine.order.follow import Lines
from sweeps.engine.order.listed import Listed
from sweeps.engine.order.product import Blocks
from sweeps.engine.order.stragglers import Stragglers
from sweeps.engine.signals import Stop
from sweeps.executor_table import EXECUTORS
from sweeps.grid import Grid

log = logging.getLogger(__name__)

# A worker may die for reasons of its own, such as a machine that is taken away.
_DEATHS_OF_A_POINT = 3

_NONE = np.array([], dtype=np.int64)

_WRONG = (
    "what came back from a worker cannot be the block that it was given; what is finished is kept, "
    "and the same command resumes"
)


def make_executor(execution: Execution) -> Executor:
    """Make the executor that a config asks for; entering it may raise ExecutorError."""
    module = import_module(f"sweeps.engine.executors.{EXECUTORS[execution.backend].module}")
    executor: Executor = module.executor_for(execution)
    return executor


def blocks_of(
    grid: Grid,
    done: NDArray[np.bool_],
    slots: int,
    *,
    seconds: float = 1.0,
    block_points: int | None = None,
) -> Blocks | Lines:
    """Cut blocks of points, or of whole lines where an axis is followed; arguments as `Blocks`."""
    if grid.followed:
        return Lines(grid, done, slots)
    return Blocks(done, slots, seconds=seconds, block_points=block_points)


def finished_blocks(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    executor: Workers,
    stop: Stop,
    in_flight: InFlight,
    *,
    block_points: int | None = None,
) -> Iterator[Block]:
    """Compute the points of a grid that are not done; as `computed_blocks` does."""
    seconds, slots = executor.block_seconds, executor.slots
    blocks = blocks_of(grid, done, slots, seconds=seconds, block_points=block_points)
    yield from computed_blocks(grid, options, blocks, executor, stop, in_flight, block_points)


def computed_blocks(
    grid: Grid | Listed,
    options: Options,
    blocks: Blocks | Lines | Listed,
    executor: Workers,
    stop: Stop,
    in_flight: InFlight,
    block_points: int | None = None,
    *,
    limit: int = 0,
) -> Iterator[Block]:
    """Compute blocks of points, and yield them as they are finished; there may come more meanwhile.

    Points that take more than `limit` drive periods, where it is not 0, come back `pending`.

    After a request to stop no further block is begun. Those in flight still come for a while, but
    for points that may take any time (`Task.is_unlimited`): they are given up. Where workers die,
    the blocks in flight are computed again one at a time and in ever smaller pieces, until the
    point, or the line, is alone that no worker survives; it gets the status `failed`. `in_flight`
    always knows which tasks have not come back. Raises ExecutorError.
    """
    stragglers = Stragglers(block_points, ever=not grid.followed)
    tasks = _Tasks(grid, options, blocks, stragglers, executor, stop, in_flight, limit)
    # There may be tasks again after there was none: those of points that came back as late.
    while (first := next(tasks, None)) is not None:
        try:
            for block in executor.blocks(chain([first], tasks), stop):
                if len((finished := tasks.finished(block)).indices):
                    yield finished
        except WorkersLostError:
            _require_workers(task_of(grid, _NONE, options), executor, stop)
            for task in in_flight.clear():
                yield from _suspect(replace(task, patience=0), executor, stop, in_flight)


class _Tasks:
    """The tasks of a sweep; the threads of an executor may take them too."""

    def __init__(
        self,
        grid: Grid | Listed,
        options: Options,
        blocks: Blocks | Lines | Listed,
        stragglers: Stragglers,
        executor: Workers,
        stop: Stop,
        in_flight: InFlight,
        limit: int,
    ) -> None:
        self._grid, self._options, self._stop, self._limit = grid, options, stop, limit
        self._blocks, self._cut = blocks, iter(blocks)
        self._stragglers = stragglers
        self._rest: list[NDArray[np.int64]] = []
        self._late: set[int] = set()  # first points of tasks for late points
        self._wrong: set[int] = set()  # first points of tasks that came back wrong once
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
        """Take late points where there are enough of them, else a block of the cut, then the rest.

        Raises StopIteration where nothing can be begun before blocks in flight come back.
        """
        late = self._stragglers.together()
        if late is None and (block := next(self._cut, None)) is not None:
            patience = 0 if self._limit else self._stragglers.patience
            return task_of(self._grid, block, self._options, patience, self._limit)
        if late is None:
            if not any(task.patience for task in self._in_flight.tasks):
                self._rest += self._stragglers.rest(self._executor.slots)
            if not self._rest:
                raise StopIteration
            late = self._rest.pop(0)
        self._late.add(int(late[0]))
        return task_of(self._grid, late, self._options, limit=self._limit)

    def finished(self, block: Block) -> Block:
        """Take in a block that has come back; returns it without the points that are late.

        A task that came back wrong is begun again, by whichever worker is free. Raises
        ExecutorError where it is wrong again, or the block of no task.
        """
        with self._lock:
            task = self._in_flight.end(block)
            if task is None or not is_answer(block, task):
                self._rest.append(self._once_more(task))
                return Block(_NONE, np.empty((0, len(RESULT_COLUMNS))))
            late = int(block.indices[0]) in self._late
            learning = self._stragglers if late else self._blocks
            learning.learn(len(block.indices), block.seconds)
            if self._limit:
                return block
            return block.part(self._stragglers.finished(block.indices, block.results))

    def _once_more(self, task: Task | None) -> NDArray[np.int64]:
        """Return the points of a task that came back wrong for the first time."""
        if task is None or int(task.indices[0]) in self._wrong:
            raise ExecutorError(_WRONG)
        log.warning("a block came back damaged from a worker; it is computed again")
        self._wrong.add(int(task.indices[0]))
        return task.indices


def _require_workers(nothing: Task, executor: Workers, stop: Stop) -> None:
    """Raise ExecutorError if workers do not even survive a task without points.

    Then the deaths are no point's fault: a worker that cannot begin never worked.
    """
    try:
        for _ in executor.blocks(iter([nothing]), stop):
            pass
    except WorkersLostError as error:
        raise ExecutorError(
            f"the workers end before they compute anything ({error}); what is finished is kept, "
            "and the same command resumes"
        ) from error


def _suspect(task: Task, executor: Workers, stop: Stop, in_flight: InFlight) -> Iterator[Block]:
    """Compute a task that may have killed its worker, and nothing beside it."""
    deaths, reason = 0, ""
    while deaths < _DEATHS_OF_A_POINT:
        if stop.requested:
            return
        in_flight.begin(task)
        try:
            for block in executor.blocks(iter([task]), stop):
                expected = in_flight.end(block)
                if expected is None or not is_answer(block, expected):
                    raise ExecutorError(_WRONG)
                yield block
            return
        except WorkersLostError as error:
            in_flight.clear()
            if len(task.indices) > task.line:
                for half in _halves(task):
                    yield from _suspect(half, executor, stop, in_flight)
                return
            deaths, reason = deaths + error.deaths, str(error)
    yield failed_block(task, reason)


def _halves(task: Task) -> list[Task]:
    middle = len(task.indices) // task.line // 2 * task.line
    parts = (slice(None, middle), slice(middle, None))
    return [replace(task, indices=task.indices[p], points=task.points[p]) for p in parts]
