"""The computation of many points by workers, some of which may die."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.cache import source_hash
from stickslip.dispatch.errors import ExecutorError, WorkersLostError
from stickslip.dispatch.in_flight import InFlight
from stickslip.dispatch.stop import Stop
from stickslip.dispatch.stragglers import Stragglers
from stickslip.dispatch.task import Block, Task, failed_block, is_answer
from stickslip.dispatch.workers import Workers
from stickslip.laws import is_of_this_process
from stickslip.options import Options
from stickslip.variables import RESULT_COLUMNS

log = logging.getLogger(__name__)

# A worker may also die for another reason, such as a machine that is switched off.
_DEATHS_OF_A_POINT = 3

_NONE = np.array([], dtype=np.int64)

_WRONG = (
    "a worker returned something other than its block; finished points are kept, and the same "
    "command resumes the sweep"
)

RowsOf: TypeAlias = Callable[[NDArray[np.int64]], NDArray[np.float64]]
"""The parameters (n, parameters) of points by their numbers (n,)."""


class Order(Protocol):
    """The order in which points are computed, as blocks of their numbers.

    Each `line` of points belongs together, because every point starts from the one before; single
    points are lines of 1. If the order `defers` late points, they are computed together later.
    """

    @property
    def line(self) -> int: ...  # noqa: D102 - a protocol
    @property
    def defers(self) -> bool: ...  # noqa: D102

    def __iter__(self) -> Iterator[NDArray[np.int64]]: ...

    def learn(self, points: int, seconds: float) -> None:
        """Take note of the cost of a finished block."""


def ask(
    rows_of: RowsOf,
    order: Order,
    options: Options,
    workers: Workers,
    *,
    stop: Stop | None = None,
    in_flight: InFlight | None = None,
    most: int | None = None,
    limit: int = 0,
) -> Iterator[Block]:
    """Compute points, and yield their blocks as they finish; the order may grow meanwhile.

    Points that take more than `limit` drive periods come back `pending`; 0 means no limit.

    If the order defers late points, they are computed together at the end, `most` at a time. After
    a request to stop no further block begins. For a while we still wait for the blocks in flight,
    except those that may take any time (`Task.is_unlimited`), which are given up. If workers die,
    the blocks in flight are computed again, one at a time and in ever smaller pieces. A single
    point or line that no worker survives gets the status `failed`. `in_flight` always holds the
    tasks that have not come back. Raises ExecutorError.
    """
    if is_of_this_process(options.friction) and not workers.in_this_process:
        raise ExecutorError(
            f"the friction law {options.friction.partition('@')[0]!r} was registered in this "
            "process, and loky or dask compute in other processes, which lack it; use threads "
            "(`execution: {backend: threads}`) or make the law a package "
            "(docs/how-to/friction-law.md)"
        )
    stop, in_flight = stop or Stop(), in_flight or InFlight()
    tasks = _Tasks(rows_of, order, options, workers, stop, in_flight, most, limit)
    # After the last task there may be new ones, for points that came back late.
    while (first := next(tasks, None)) is not None:
        try:
            for block in workers.blocks(chain([first], tasks), stop):
                if len((finished := tasks.finished(block)).indices):
                    yield finished
        except WorkersLostError:
            _require_workers(tasks.task_of(_NONE), workers, stop)
            for task in in_flight.clear():
                yield from _suspect(replace(task, patience=0), workers, stop, in_flight)


class _Tasks:
    """The tasks of all points, which several threads may take."""

    def __init__(
        self,
        rows_of: RowsOf,
        order: Order,
        options: Options,
        workers: Workers,
        stop: Stop,
        in_flight: InFlight,
        most: int | None,
        limit: int,
    ) -> None:
        self._rows_of, self._options, self._stop, self._limit = rows_of, options, stop, limit
        self._order, self._cut = order, iter(order)
        self._stragglers = Stragglers(most, ever=order.defers)
        self._rest: list[NDArray[np.int64]] = []
        self._late: set[int] = set()  # the first point of each task for late points
        self._wrong: set[int] = set()  # the first point of each task that came back wrong once
        self._in_flight, self._workers = in_flight, workers
        self._lock = threading.Lock()

    def task_of(self, indices: NDArray[np.int64], patience: int = 0) -> Task:
        """Return the task to compute some of the points."""
        points, line = self._rows_of(indices), self._order.line
        return Task(indices, points, self._options, source_hash(), line, patience, self._limit)

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
        """Take late points if there are enough of them, else a block of the order, then the rest.

        Raises StopIteration if nothing can begin before blocks in flight come back.
        """
        late = self._stragglers.together()
        if late is None and (block := next(self._cut, None)) is not None:
            patience = 0 if self._limit else self._stragglers.patience
            return self.task_of(block, patience)
        if late is None:
            if not any(task.patience for task in self._in_flight.tasks):
                self._rest += self._stragglers.rest(self._workers.slots)
            if not self._rest:
                raise StopIteration
            late = self._rest.pop(0)
        self._late.add(int(late[0]))
        return self.task_of(late)

    def finished(self, block: Block) -> Block:
        """Take note of a block that has come back, and return it without the late points.

        A task whose block is wrong is computed once more, by any worker. Raises ExecutorError if it
        comes back wrong again, or if the block belongs to no task.
        """
        with self._lock:
            task = self._in_flight.end(block)
            if task is None or not is_answer(block, task):
                if task is None or int(task.indices[0]) in self._wrong:
                    raise ExecutorError(_WRONG)
                log.warning("a block came back damaged from a worker; it is computed again")
                self._wrong.add(int(task.indices[0]))
                self._rest.append(task.indices)
                return Block(_NONE, np.empty((0, len(RESULT_COLUMNS))))
            late = int(block.indices[0]) in self._late
            learner = self._stragglers if late else self._order
            learner.learn(len(block.indices), block.seconds)
            if self._limit:
                return block
            return block.part(self._stragglers.finished(block.indices, block.results))


def _require_workers(nothing: Task, workers: Workers, stop: Stop) -> None:
    """Raise ExecutorError if workers do not survive even a task without points.

    In that case the workers cannot start at all, and no point is to blame.
    """
    try:
        for _ in workers.blocks(iter([nothing]), stop):
            pass
    except WorkersLostError as error:
        raise ExecutorError(
            f"the workers die before computing anything ({error}); finished points are kept, "
            "and the same command resumes the sweep"
        ) from error


def _suspect(task: Task, workers: Workers, stop: Stop, in_flight: InFlight) -> Iterator[Block]:
    """Compute a task that may have killed its worker, with no other task in flight."""
    deaths, reason = 0, ""
    while deaths < _DEATHS_OF_A_POINT:
        if stop.requested:
            return
        in_flight.begin(task)
        try:
            for block in workers.blocks(iter([task]), stop):
                expected = in_flight.end(block)
                if expected is None or not is_answer(block, expected):
                    raise ExecutorError(_WRONG)
                yield block
            return
        except WorkersLostError as error:
            in_flight.clear()
            if len(task.indices) > task.line:
                for half in _halves(task):
                    yield from _suspect(half, workers, stop, in_flight)
                return
            deaths, reason = deaths + error.deaths, str(error)
    yield failed_block(task, reason)


def _halves(task: Task) -> list[Task]:
    middle = len(task.indices) // task.line // 2 * task.line
    parts = (slice(None, middle), slice(middle, None))
    return [replace(task, indices=task.indices[p], points=task.points[p]) for p in parts]
