"""A sweep from a config to a Dataset, in memory and without files."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from typing import TYPE_CHECKING

import joblib
import numpy as np
from joblib.parallel import get_active_backend

from sweeps.config.load import Config
from sweeps.config.pull import refuse_pull
from sweeps.config.schema import Execution
from sweeps.engine.computing import compiled, missing_blocks
from sweeps.engine.counts import Counts
from sweeps.engine.dispatch import make_executor
from sweeps.engine.executors.base import Tasks, Workers, WorkersLostError, first_line
from sweeps.engine.executors.children import children_started
from sweeps.engine.executors.worker import Block, compute_block
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
    workers: int | None = None,
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
    workers: int | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
) -> Rows:
    """Compute a sweep; returns the result rows (size, columns) of its points.

    `workers` are counted as joblib's `n_jobs`. Where points are lost on the way, it raises
    RuntimeError.
    """
    refuse_pull(config.simulation.drive)
    grid = Grid.from_config(config)
    memory, stop = Memory(grid.size), Stop()
    counts = Counts(grid.size, memory)
    compiled(config, grid, stop, wanted=True)
    with (
        _executor_of(config.execution, workers) as executor,
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


def _executor_of(execution: Execution, workers: int | None) -> Workers:
    """Make the executor that `joblib.parallel_config` names, else that of the config."""
    wanted = (workers, get_active_backend()[1], execution.slots)
    jobs = next(number for number in wanted if number is not None)
    if _joblib_has_a_backend():
        return JoblibWorkers(jobs)
    return make_executor(execution.model_copy(update={"workers": joblib.effective_n_jobs(jobs)}))


def _joblib_has_a_backend() -> bool:
    """Return whether `parallel_config` names one: then a preference of ours does not change it."""
    threads, processes = (get_active_backend(prefer=kind)[0] for kind in ("threads", "processes"))
    return threads is processes


class JoblibWorkers(Workers):
    """Compute tasks on the backend that `joblib.parallel_config` names, whichever it is.

    joblib hands out the next tasks before the block that has come is taken in. That loses nothing
    in memory; a journal would lose more in a kill than what is in flight.
    """

    def __init__(self, jobs: int) -> None:
        super().__init__(slots=joblib.effective_n_jobs(jobs))
        self._jobs = jobs

    def __exit__(self, *exception: object) -> None:
        pass  # joblib ends its workers, or keeps them for the next call

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:  # noqa: ARG002 - its shape
        """Yield the finished blocks of the tasks; raises WorkersLostError."""
        # Blocks are small and read once, so that mapping them into memory as files gains nothing.
        parallel = joblib.Parallel(
            self._jobs, return_as="generator_unordered", batch_size=1, max_nbytes=None
        )
        try:
            with children_started():
                blocks = parallel(joblib.delayed(compute_block)(task) for task in tasks)
            yield from blocks
        except BrokenProcessPool as error:
            raise WorkersLostError(first_line(error)) from error
