"""The points of a grid over the workers of a backend, whatever happens to the workers."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from stickslip.options import Options
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.schema import Execution
from sweeps.engine.blocks import Blocks
from sweeps.engine.executors.backends import Backend, WorkersLostError, make_backend
from sweeps.engine.signals import Stop
from sweeps.engine.worker import Block, Task, failed_block, task_of
from sweeps.grid import Grid

log = logging.getLogger(__name__)

_DEFAULT = Execution()

# A worker may die for reasons of its own, such as a machine that is taken away.
_DEATHS_OF_A_POINT = 3


def finished_blocks(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    backend: Backend,
    stop: Stop,
    *,
    block_points: int | None = None,
    pilot: int = 0,
) -> Iterator[Block]:
    """The points of a grid that are not done, computed, block by block as they are finished.

    After a request to stop no further block is begun, and those in flight still come. Where workers
    die, the blocks in flight are given again one at a time and in ever smaller pieces, until the
    point is alone that no worker survives; it gets the status `failed`.
    """
    blocks = Blocks(
        done,
        backend.slots,
        seconds=backend.block_seconds,
        block_points=block_points,
        pilot=pilot,
    )
    tasks = _Tasks(grid, options, blocks, stop)
    suspects: list[Task] | None = []
    while suspects is not None:
        yield from _one_at_a_time(suspects, backend, stop)
        suspects = None
        try:
            for block in backend.blocks(tasks, stop):
                tasks.finished(block)
                yield block
        except WorkersLostError:
            suspects = tasks.in_flight()


class _Tasks:
    """The tasks of a sweep, taken by several threads, and which of them have not come back."""

    def __init__(self, grid: Grid, options: Options, blocks: Blocks, stop: Stop) -> None:
        self._grid, self._options, self._stop = grid, options, stop
        self._blocks, self._cut = blocks, iter(blocks)
        self._flying: dict[int, Task] = {}
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[Task]:
        return self

    def __next__(self) -> Task:
        with self._lock:
            if self._stop.requested:
                raise StopIteration
            task = task_of(self._grid, next(self._cut), self._options)
            self._flying[int(task.indices[0])] = task
            return task

    def finished(self, block: Block) -> None:
        with self._lock:
            del self._flying[int(block.indices[0])]
        self._blocks.learn(len(block.indices), block.seconds)

    def in_flight(self) -> list[Task]:
        """The tasks that have not come back; they are forgotten here."""
        with self._lock:
            flying, self._flying = list(self._flying.values()), {}
        return flying


def _one_at_a_time(suspects: list[Task], backend: Backend, stop: Stop) -> Iterator[Block]:
    waiting, deaths = deque(suspects), 0
    while waiting and not stop.requested:
        task = waiting.popleft()
        try:
            yield from backend.blocks(iter([task]), stop)
            deaths = 0
        except WorkersLostError as error:
            if len(task.indices) > 1:
                waiting.extendleft(reversed(_halves(task)))
                continue
            deaths += error.deaths
            if deaths < _DEATHS_OF_A_POINT:
                waiting.appendleft(task)
            else:
                deaths = 0
                yield failed_block(task, str(error))


def _halves(task: Task) -> list[Task]:
    middle = len(task.indices) // 2
    parts = (slice(None, middle), slice(middle, None))
    return [Task(task.indices[part], task.points[part], task.options, task.code) for part in parts]


def compute(
    grid: Grid,
    options: Options,
    *,
    execution: Execution = _DEFAULT,
    on_block: Callable[[Block], None] | None = None,
) -> NDArray[np.float64]:
    """The result rows of all points of a grid, in memory.

    Parameters
    ----------
    grid, options
        What to compute, and how.
    execution
        Workers, backend, size of the blocks.
    on_block
        Called, in the calling thread, with each block as it is finished, in any order.

    Returns
    -------
    array
        (grid.size, 13), columns as `kernels.RESULT_COLUMNS`; a point whose computation raised
        has the status `failed`.

    Raises
    ------
    BackendError
        The workers cannot be had.
    RuntimeError
        Points were lost on the way.
    """
    results = np.full((grid.size, len(RESULT_COLUMNS)), np.nan)
    done = np.zeros(grid.size, dtype=bool)
    with make_backend(execution) as backend:
        for block in finished_blocks(
            grid, options, done, backend, Stop(), block_points=execution.block_points
        ):
            results[block.indices], done[block.indices] = block.results, True
            for message in block.messages:
                log.error(message)
            if on_block is not None:
                on_block(block)
    if not done.all():
        raise RuntimeError(f"only {done.sum()} of {grid.size} points came back from the workers")
    return results
