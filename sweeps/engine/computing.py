"""The points of a grid: their kernels, their blocks, and the loop over the missing points."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.ask import Order, ask
from stickslip.dispatch.blocks import Blocks
from stickslip.dispatch.compilation import compile_kinds
from stickslip.dispatch.lines import Lines
from stickslip.dispatch.task import Block
from stickslip.dispatch.workers import Workers
from stickslip.kernels.families import KIND
from stickslip.options import Options
from sweeps.config.load import Config
from sweeps.engine.progress import Compiling, Counts
from sweeps.engine.refine import refinement_of
from sweeps.engine.settings import options_of
from sweeps.engine.signals import Stop, wait_for
from sweeps.files.journal import Journal
from sweeps.files.result_rows import Memory
from sweeps.grid import Grid


def compile_kernels(options: Options, grid: Grid) -> None:
    """Compile or load the kernels that the points of a grid need."""
    compile_kinds(options, kinds_of(grid))


def kinds_of(grid: Grid) -> NDArray[np.float64]:
    """Return the kinds (n, k) of points that may occur in a grid, for `compile_kinds`.

    All that matters about a coefficient of the free energy is whether it is 0.
    """
    index, *coefficients = (grid.values(name) for name in KIND)
    either = [{value != 0.0: value for value in values}.values() for values in coefficients]
    return np.array(list(product(index, *either)))


def compile_first(config: Config, grid: Grid, stop: Stop, *, wanted: bool) -> bool:
    """Compile the kernels once, before several workers would begin to.

    Returns False if a stop was requested in the meantime. If `wanted` is true, a message says that
    compiling takes time. The workers of a cluster compile for themselves.
    """
    if config.execution.scheduler:
        return True
    with Compiling(wanted=wanted) as compiling:
        stop.at_once.append(compiling.stop)
        return wait_for(lambda: compile_kernels(options_of(config), grid), stop)


def order_of(
    grid: Grid, done: NDArray[np.bool_], workers: Workers, block_points: int | None = None
) -> Order:
    """Cut the points not done (size,) into blocks: of points, or of lines of a followed axis.

    Blocks have `block_points` points if that is given, else they take about
    `workers.block_seconds`; lines stay whole.
    """
    if grid.followed:
        return Lines(grid.lines(), done, workers.slots)
    seconds, slots = workers.block_seconds, workers.slots
    return Blocks(done, slots, seconds=seconds, block_points=block_points)


def missing_blocks(
    config: Config,
    grid: Grid,
    needed: NDArray[np.bool_],
    store: Journal | Memory,
    executor: Workers,
    counts: Counts,
    stop: Stop,
) -> Iterator[Block]:
    """Compute the needed points (size,) that a store lacks, and yield their blocks.

    The caller puts each block into the store before it takes the next one. On a refined grid each
    round's points depend on the values of earlier rounds; the last block has the interpolated
    points, and names no processor. After a request to stop, the blocks in flight are still
    yielded. Raises ExecutorError.
    """
    options, refinement = options_of(config), refinement_of(config.refine, grid)
    most = config.execution.block_points
    for points in refinement.rounds(store.rows) if refinement else [needed]:
        done = store.done | ~points
        left = len(done) - int(np.count_nonzero(done))
        counts.goal = counts.done + left
        blocks = ask(
            grid.rows,
            order_of(grid, done, executor, most),
            options,
            executor,
            stop=stop,
            in_flight=counts.in_flight,
            most=most,
        )
        for block in blocks:
            # If one point of a line is missing, the whole line is computed.
            fresh = int(np.count_nonzero(~store.done[block.indices]))
            counts.costs.learn(fresh, block.seconds)
            yield block
    if refinement and not stop.requested:
        numbers, rows = refinement.interpolated(store.rows())
        if len(numbers):
            yield Block(numbers, rows)
        counts.goal = counts.total
