"""Blocks of points over the cores: what joblib runs, and how the blocks are cut."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from stickslip.kernels import RESULT_COLUMNS
from stickslip.orbit import Options, compute_orbits, failed_row, prepare_kernels
from sweeps.grid import Grid

log = logging.getLogger(__name__)

# A block lasts about a second: long against the cost of handing it out, short against patience.
_BLOCK_SECONDS = 1.0
_FIRST_BLOCK = 256  # points, before anything is known of their cost
_LARGEST_BLOCK = 65_536

# Fewer points do not keep the lanes of a kernel busy.
_SMALLEST_BLOCK = 64


@dataclass(frozen=True)
class Block:
    """Computed points: the rows `start` to `start + len(results)` of the grid."""

    start: int
    results: NDArray[np.float64]
    seconds: float

    @property
    def failures(self) -> int:
        """How many of the points did not end ok."""
        return int(np.count_nonzero(self.results[:, -1]))


class BlockSizes:
    """Cuts a number of points into blocks of about a second, learning their cost on the way.

    Towards the end the blocks get smaller, so that no core waits long for the last one. The size
    of the blocks never changes a result: every point is computed from its own parameters alone.
    """

    def __init__(self, size: int, workers: int, block_points: int | None = None) -> None:
        self._size, self._workers, self._fixed = size, workers, block_points
        self._seconds_per_point: float | None = None
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[tuple[int, int]]:
        start = 0
        while start < self._size:
            stop = min(self._size, start + self._next(self._size - start))
            yield start, stop
            start = stop

    def learn(self, block: Block) -> None:
        """Take in what a finished block cost."""
        cost = block.seconds / len(block.results)
        with self._lock:
            known = self._seconds_per_point
            self._seconds_per_point = cost if known is None else 0.5 * (known + cost)

    def _next(self, left: int) -> int:
        if self._fixed is not None:
            return self._fixed
        with self._lock:
            cost = self._seconds_per_point
        wanted = _FIRST_BLOCK if cost is None else int(_BLOCK_SECONDS / max(cost, 1e-9))
        fair = left // (2 * self._workers)
        return max(_SMALLEST_BLOCK, min(wanted, fair, _LARGEST_BLOCK))


def compile_kernels(options: Options, grid: Grid) -> None:
    """Compile or load what the grid needs, before threads would wait for it."""
    prepare_kernels(options, grid.values("rheological_index"))


def compute(
    grid: Grid,
    options: Options,
    *,
    workers: int,
    block_points: int | None = None,
    on_block: Callable[[Block], None] | None = None,
) -> NDArray[np.float64]:
    """The result rows of all points of a grid.

    Parameters
    ----------
    grid, options
        What to compute, and how.
    workers
        Threads; the kernels release the interpreter's lock.
    block_points
        Points in a block; by default about a second's work.
    on_block
        Called, in the calling thread, with each block as it is finished, in any order.

    Returns
    -------
    array
        (grid.size, 13), columns as `kernels.RESULT_COLUMNS`; a point whose computation raised
        has the status `failed`, and the log has the traceback.

    Raises
    ------
    RuntimeError
        Blocks were lost on the way.
    """
    results = np.full((grid.size, len(RESULT_COLUMNS)), np.nan)
    sizes, done = BlockSizes(grid.size, workers, block_points), 0
    tasks = (delayed(_block)(grid, start, stop, options) for start, stop in sizes)
    pool = Parallel(
        n_jobs=workers,
        backend="threading",
        return_as="generator_unordered",
        pre_dispatch=workers,  # a block is cut when a core is free, with what is known by then
        batch_size=1,
    )
    for block in pool(tasks):
        results[block.start : block.start + len(block.results)] = block.results
        done += len(block.results)
        sizes.learn(block)
        if on_block is not None:
            on_block(block)
    if done != grid.size:
        raise RuntimeError(f"only {done} of {grid.size} points came back from the workers")
    return results


def _block(grid: Grid, start: int, stop: int, options: Options) -> Block:
    points = grid.points(start, stop)
    begun = time.monotonic()
    try:
        results, _ = compute_orbits(points, options)
    except Exception:  # a point must not take the others with it
        log.debug("a block failed; its points are computed one by one", exc_info=True)
        results = np.array([_alone(point, options) for point in points])
    return Block(start, results, time.monotonic() - begun)


def _alone(point: NDArray[np.float64], options: Options) -> NDArray[np.float64]:
    try:
        results, _ = compute_orbits(point, options)
        return np.asarray(results[0])
    except Exception as error:  # recorded as the point's status
        detail = log.isEnabledFor(logging.DEBUG)
        log.error("the computation of point %s failed: %r", point.tolist(), error, exc_info=detail)
        return failed_row()
