"""The points of a grid: their kernels, their blocks, and the loop over those a store lacks."""

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
    """Compile or load what the points of a grid need."""
    compile_kinds(options, kinds_of(grid))


def kinds_of(grid: Grid) -> NDArray[np.float64]:
    """Return the kinds (n, k) of points that may occur in a grid, as `compile_kinds` takes them.

    Of a coefficient of the free energy it matters only whether it is 0.
    """
    index, *coefficients = (grid.values(name) for name in KIND)
    either = [{value != 0.0: value for value in values}.values() for values in coefficients]
    return np.array(list(product(index, *either)))


def compile_first(config: Config, grid: Grid, stop: Stop, *, wanted: bool) -> bool:
    """Compile what the points need, once, before several workers would begin to.

    Returns False where a stop was requested meanwhile; where it is `wanted`, it is said that this
    takes time. The workers of a cluster compile for themselves.
    """
    if config.execution.scheduler:
        return True
    with Compiling(wanted=wanted) as compiling:
        stop.at_once.append(compiling.stop)
        return wait_for(lambda: compile_kernels(options_of(config), grid), stop)


def order_of(
    grid: Grid, done: NDArray[np.bool_], workers: Workers, block_points: int | None = None
) -> Order:
    """Cut what is not done (size,) into blocks: of points, or of lines where an axis is followed.

    They have `block_points`, where that is given, and last some seconds else; lines are whole.
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
    """Compute what a store lacks of the points (size,) that are needed, and yield their blocks.

    Each block is to be kept in the store before the next one is taken. Of a refined grid what to
    compute follows, round by round, from what was computed; the last block is what was
    interpolated, and has no processor. After a request to stop the blocks in flight still come.
    Raises ExecutorError.
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
            # A line is computed as a whole where one of its points is missing.
            fresh = int(np.count_nonzero(~store.done[block.indices]))
            counts.costs.learn(fresh, block.seconds)
            yield block
    if refinement and not stop.requested:
        yield Block(*refinement.interpolated(store.rows()))
        counts.goal = counts.total
