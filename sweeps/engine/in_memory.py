"""A sweep from a config to a Dataset, in memory and without files."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

import numpy as np

from stickslip.dispatch.task import Block
from stickslip.dispatch.workers import Workers
from sweeps.config.load import Config
from sweeps.config.pull import refuse_pull
from sweeps.engine.computing import compiled, missing_blocks
from sweeps.engine.counts import Counts
from sweeps.engine.executors import workers_of
from sweeps.engine.progress import display_of
from sweeps.engine.signals import Stop
from sweeps.engine.store import Memory
from sweeps.files.attributes import result_dataset
from sweeps.files.columns import Rows
from sweeps.grid import Grid

if TYPE_CHECKING:
    import xarray as xr

log = logging.getLogger(__name__)


def run_in_memory(
    config: Config,
    *,
    workers: int | Workers | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
) -> xr.Dataset:
    """Compute a sweep; returns its result, as the command line would write it to a file.

    Nothing is written. Arguments and errors are those of `sweeps.run`.
    """
    rows = compute(config, workers=workers, progress=progress, on_block=on_block)
    return result_dataset(config, Grid.from_config(config), rows)


def compute(
    config: Config,
    *,
    workers: int | Workers | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
) -> Rows:
    """Compute a sweep; returns the result rows (size, columns) of its points.

    `workers` are counted as joblib's `n_jobs`, or are given ones that are ready. Where points are
    lost on the way, it raises RuntimeError.
    """
    refuse_pull(config.simulation.drive)
    grid = Grid.from_config(config)
    memory, stop = Memory(grid.size), Stop()
    counts = Counts(grid.size, memory)
    compiled(config, grid, stop, wanted=True)
    with (
        _workers_of(config, workers) as executor,
        display_of(counts, wanted=progress),
    ):
        counts.begin(lambda: executor.slots)
        needed = np.ones(grid.size, dtype=bool)
        for block in missing_blocks(config, grid, needed, memory, executor, counts, stop):
            memory.append(block.indices, block.results)
            for message in block.messages:
                log.error(message)
            if on_block is not None:
                on_block(block)
    if counts.left:
        raise RuntimeError(f"only {counts.done} of {grid.size} points came back from the workers")
    return memory.rows()


def _workers_of(config: Config, workers: int | Workers | None) -> AbstractContextManager[Workers]:
    if isinstance(workers, Workers):
        return nullcontext(workers)
    return workers_of(config.execution, workers)
