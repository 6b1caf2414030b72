"""The loop that computes the points missing in a store: a journal, or memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sweeps.config.load import Config
from sweeps.engine.counts import Counts
from sweeps.engine.dispatch import finished_blocks
from sweeps.engine.executors.base import Workers
from sweeps.engine.executors.kernels import compile_kernels
from sweeps.engine.executors.worker import Block
from sweeps.engine.order.refine import refinement_of
from sweeps.engine.progress import Compiling
from sweeps.engine.settings import options_of
from sweeps.engine.signals import Stop, wait_for
from sweeps.engine.store import Store
from sweeps.grid import Grid


def compiled(config: Config, grid: Grid, stop: Stop, *, wanted: bool) -> bool:
    """Compile what the points need, once, before several workers would begin to.

    Returns False where a stop was requested meanwhile; where it is `wanted`, it is said that this
    takes time. The workers of a cluster compile for themselves.
    """
    if config.execution.scheduler:
        return True
    with Compiling(wanted=wanted) as compiling:
        stop.at_once.append(compiling.stop)
        return wait_for(lambda: compile_kernels(options_of(config), grid), stop)


def missing_blocks(
    config: Config,
    grid: Grid,
    needed: NDArray[np.bool_],
    store: Store,
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
    for points in refinement.rounds(store.rows) if refinement else [needed]:
        done = store.done | ~points
        left = len(done) - int(np.count_nonzero(done))
        counts.goal = counts.done + left
        blocks = finished_blocks(
            grid,
            options,
            done,
            executor,
            stop,
            counts.in_flight,
            block_points=config.execution.block_points,
        )
        for block in blocks:
            # A line is computed as a whole where one of its points is missing.
            fresh = int(np.count_nonzero(~store.done[block.indices]))
            counts.costs.learn(fresh, block.seconds)
            yield block
    if refinement and not stop.requested:
        yield Block(*refinement.interpolated(store.rows()))
        counts.goal = counts.total
