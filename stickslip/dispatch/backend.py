"""The workers that `joblib.parallel_config` names."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool

import joblib
from joblib.parallel import get_active_backend

from stickslip.dispatch.children import children_started
from stickslip.dispatch.errors import ExecutorError, WorkersLostError
from stickslip.dispatch.stop import Stop
from stickslip.dispatch.task import Block, compute_block
from stickslip.dispatch.thread_pool import ThreadExecutor
from stickslip.dispatch.workers import Tasks, Workers, first_line


def own_workers(jobs: int | None = None) -> Workers:
    """Return the workers that `joblib.parallel_config` names, or threads of this process.

    `jobs` has the meaning of joblib's `n_jobs`. By default `parallel_config` sets it, or there is
    one worker for each core.
    """
    jobs = jobs or named_jobs() or -1
    if named := named_workers(jobs):
        return named
    with joblib.parallel_config("threading"):  # loky would warn inside a multiprocessing process
        return ThreadExecutor(joblib.effective_n_jobs(jobs))


def named_jobs() -> int | None:
    """Return the `n_jobs` set by `joblib.parallel_config`, if any."""
    jobs: int | None = get_active_backend()[1]
    return jobs


def named_workers(jobs: int) -> Workers | None:
    """Return the workers of the backend that `joblib.parallel_config` names, if any."""
    # Our preference does not override a named backend.
    threads, processes = (get_active_backend(prefer=kind)[0] for kind in ("threads", "processes"))
    return JoblibWorkers(jobs) if threads is processes else None


class JoblibWorkers(Workers):
    """Compute tasks on the backend that `joblib.parallel_config` names, whichever it is.

    joblib hands out the next tasks before we take a block that has arrived. That does no harm to
    results in memory, but a kill would cost a journal more than the blocks in flight.
    """

    def __init__(self, jobs: int) -> None:
        super().__init__(slots=joblib.effective_n_jobs(jobs))
        self._jobs = jobs
        # Process backends lack the attribute.
        self.in_this_process = getattr(get_active_backend()[0], "supports_sharedmem", False)

    def __exit__(self, *exception: object) -> None:
        pass  # joblib ends its workers, or keeps them for the next call

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:  # noqa: ARG002 - of Workers
        """Yield the finished blocks of the tasks; raises WorkersLostError and ExecutorError."""
        try:
            # Blocks are small and read once, so mapping them into memory as files gains nothing.
            parallel = joblib.Parallel(
                self._jobs, return_as="generator_unordered", batch_size=1, max_nbytes=None
            )
        except ValueError as error:
            raise ExecutorError(
                f"joblib's {type(get_active_backend()[0]).__name__} cannot return blocks as they "
                "finish; name another backend in joblib.parallel_config, such as loky or threading"
            ) from error
        try:
            with children_started():
                blocks = parallel(joblib.delayed(compute_block)(task) for task in tasks)
            yield from blocks
        except BrokenProcessPool as error:
            raise WorkersLostError(first_line(error)) from error
