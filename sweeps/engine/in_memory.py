"""A sweep from a config to a Dataset, in memory and without files."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.options import Options
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import Config
from sweeps.config.refinement import Refine
from sweeps.config.schema import Execution
from sweeps.engine.dispatch import finished_blocks
from sweeps.engine.executors.choose import make_executor
from sweeps.engine.executors.kernels import compile_kernels
from sweeps.engine.executors.worker import Block, compute_block, task_of
from sweeps.engine.order.cut import blocks_of
from sweeps.engine.order.refine import refinement_of
from sweeps.engine.order.stragglers import Stragglers
from sweeps.engine.progress.compiling import Compiling
from sweeps.engine.progress.counts import Counts
from sweeps.engine.progress.display import make_progress
from sweeps.engine.settings import options_of
from sweeps.engine.signals import Stop
from sweeps.files.attributes import result_dataset
from sweeps.files.columns import STATUS, STATUS_CODES, status_counts
from sweeps.grid import Grid

if TYPE_CHECKING:
    import xarray as xr

log = logging.getLogger(__name__)

_DEFAULT = Execution()


def run_in_memory(
    config: Config,
    *,
    workers: int | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
) -> xr.Dataset:
    """The result of a sweep, as the command line would write it to a file.

    Nothing is written. `workers` are counted as joblib's `n_jobs`; the rest is said, with the
    errors, in `sweeps.run`.
    """
    grid = Grid.from_config(config)
    statuses = np.zeros(STATUS_CODES, dtype=np.int64)
    counts = Counts(grid.size, statuses)

    def take_in(block: Block) -> None:
        statuses[:] += status_counts(block.results[:, STATUS])
        counts.costs.learn(len(block.indices), block.seconds)
        if on_block is not None:
            on_block(block)

    with make_progress(counts, wanted=progress):
        results = compute(
            grid,
            options_of(config),
            refine=config.refine,
            execution=config.execution,
            workers=workers,
            on_block=take_in,
        )
    return result_dataset(config, grid, results)


def compute(
    grid: Grid,
    options: Options,
    *,
    refine: Refine | None = None,
    execution: Execution = _DEFAULT,
    workers: int | None = None,
    on_block: Callable[[Block], None] | None = None,
) -> NDArray[np.float64]:
    """The result rows of all points of a grid: (grid.size, columns of `RESULT_COLUMNS`).

    A point whose computation raised has the status `failed`. `refine` computes part of the points
    and interpolates the others. Arguments and errors are those of `run`.
    """
    results = np.full((grid.size, len(RESULT_COLUMNS)), np.nan)
    refinement = refinement_of(refine, grid)
    rounds = refinement.rounds(lambda: results) if refinement else [np.ones(grid.size, bool)]
    for needed in rounds:
        done = ~needed | ~np.isnan(results[:, STATUS])
        _compute_round(grid, options, done, results, execution, workers, on_block)
    if refinement:
        numbers, rows = refinement.interpolated(results)
        results[numbers] = rows
    return results


def _compute_round(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    results: NDArray[np.float64],
    execution: Execution,
    workers: int | None,
    on_block: Callable[[Block], None] | None,
) -> None:
    """Compute the points that are not `done` (size,) into their rows of the results."""
    lost: BaseException | None = None
    there = done.copy()
    try:
        for block in _blocks(grid, options, done, execution, workers):
            results[block.indices], there[block.indices] = block.results, True
            for message in block.messages:
                log.error(message)
            if on_block is not None:
                on_block(block)
    except BrokenProcessPool as error:  # joblib gives up all blocks in flight
        lost = error
    if not there.all():
        raise RuntimeError(
            f"only {there.sum()} of {grid.size} points came back from the workers"
        ) from lost


def _blocks(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    execution: Execution,
    workers: int | None,
) -> Iterator[Block]:
    """The finished blocks, in any order, from where the person or the config wants them."""
    import joblib
    from joblib.parallel import get_active_backend

    wanted = (workers, get_active_backend()[1], execution.workers)
    jobs = next(number for number in wanted if number is not None)
    if execution.backend == "threads" or _joblib_has_a_backend():
        yield from _by_joblib(grid, options, done, jobs, execution.block_points)
        return
    counted = execution.model_copy(update={"workers": joblib.effective_n_jobs(jobs)})
    with make_executor(counted) as executor:
        yield from finished_blocks(
            grid, options, done, executor, Stop(), block_points=execution.block_points
        )


def _joblib_has_a_backend() -> bool:
    """Whether `parallel_config` names one: then a preference of ours does not change it."""
    from joblib.parallel import get_active_backend

    threads, processes = (get_active_backend(prefer=kind)[0] for kind in ("threads", "processes"))
    return threads is processes


def _by_joblib(
    grid: Grid,
    options: Options,
    done: NDArray[np.bool_],
    jobs: int,
    block_points: int | None,
) -> Iterator[Block]:
    import joblib

    with Compiling():
        compile_kernels(options, grid)  # once, before several workers would begin to
    slots = joblib.effective_n_jobs(jobs)
    blocks = blocks_of(grid, done, slots, block_points=block_points)
    stragglers = Stragglers(block_points, ever=not grid.followed)
    # Blocks are small and read once, so that mapping them into memory as files gains nothing.
    parallel = joblib.Parallel(
        jobs, prefer="threads", return_as="generator_unordered", batch_size=1, max_nbytes=None
    )
    task = joblib.delayed(compute_block)
    impatient = (task(task_of(grid, cut, options, stragglers.patience)) for cut in blocks)
    for block in parallel(impatient):
        blocks.learn(len(block.indices), block.seconds)
        yield block.part(stragglers.finished(block.indices, block.results))
    if rest := stragglers.rest(slots):
        yield from parallel(task(task_of(grid, late, options)) for late in rest)
