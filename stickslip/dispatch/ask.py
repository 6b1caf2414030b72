"""Points over workers, whatever happens to the workers: the one way to rows of results."""

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

# A worker may die for reasons of its own, such as a machine that is taken away.
_DEATHS_OF_A_POINT = 3

_NONE = np.array([], dtype=np.int64)

_WRONG = (
    "what came back from a worker cannot be the block that it was given; what is finished is kept, "
    "and the same command resumes"
)

RowsOf: TypeAlias = Callable[[NDArray[np.int64]], NDArray[np.float64]]
"""The parameters (n, parameters) of points by their numbers (n,)."""


class Order(Protocol):
    """The order in which points are computed: their numbers, cut into blocks.

    `line` points at a time belong together, each starting from the one before; 1 for points alone.
    Late points are left over, and computed together, where it `defers` them.
    """

    @property
    def line(self) -> int: ...  # noqa: D102 - a protocol
    @property
    def defers(self) -> bool: ...  # noqa: D102

    def __iter__(self) -> Iterator[NDArray[np.int64]]: ...

    def learn(self, points: int, seconds: float) -> None:
        """Take in what a finished block cost."""


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
    """Compute points, and yield their blocks as they are finished; more may be ordered meanwhile.

    Points that take more than `limit` drive periods, where it is not 0, come back `pending`.

    Late points are computed together at the end where the order defers them, `most` at a time where
    that is given. After a request to stop no further block is begun. Those in flight still come for
    a while, but for points that may take any time (`Task.is_unlimited`): they are given up. Where
    workers die, the blocks in flight are computed again one at a time and in ever smaller pieces,
    until the point, or the line, is alone that no worker survives; it gets the status `failed`.
    `in_flight` always knows which tasks have not come back. Raises ExecutorError.
    """
    if is_of_this_process(options.friction) and not workers.in_this_process:
        raise ExecutorError(
            f"the friction law {options.friction.partition('@')[0]!r} was registered in this "
            "process, and loky or dask would compute in others, which do not know it: take threads "
            "(`execution: {backend: threads}`), or make the law a package "
            "(docs/how-to/friction-law.md)"
        )
    stop, in_flight = stop or Stop(), in_flight or InFlight()
    tasks = _Tasks(rows_of, order, options, workers, stop, in_flight, most, limit)
    # There may be tasks again after there was none: those of points that came back as late.
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
    """The tasks of all points; the threads of an executor may take them too."""

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
        self._late: set[int] = set()  # first points of tasks for late points
        self._wrong: set[int] = set()  # first points of tasks that came back wrong once
        self._in_flight, self._workers = in_flight, workers
        self._lock = threading.Lock()

    def task_of(self, indices: NDArray[np.int64], patience: int = 0) -> Task:
        """Make the task of computing some of the points."""
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
        """Take late points where there are enough of them, else a block of the cut, then the rest.

        Raises StopIteration where nothing can be begun before blocks in flight come back.
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
            learning = self._stragglers if late else self._order
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


def _require_workers(nothing: Task, workers: Workers, stop: Stop) -> None:
    """Raise ExecutorError if workers do not even survive a task without points.

    Then the deaths are no point's fault: a worker that cannot begin never worked.
    """
    try:
        for _ in workers.blocks(iter([nothing]), stop):
            pass
    except WorkersLostError as error:
        raise ExecutorError(
            f"the workers end before they compute anything ({error}); what is finished is kept, "
            "and the same command resumes"
        ) from error


def _suspect(task: Task, workers: Workers, stop: Stop, in_flight: InFlight) -> Iterator[Block]:
    """Compute a task that may have killed its worker, and nothing beside it."""
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
