"""A sweep from Python: in memory, or into a file that is resumed and grown."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import joblib
import numpy as np

from stickslip.accessors import register_accessors
from stickslip.dispatch.task import Block
from stickslip.dispatch.workers import Workers
from stickslip.status import Status
from sweeps.config.load import Config, from_mapping
from sweeps.config.pull import refuse_pull
from sweeps.config.schema import Execution
from sweeps.engine.computing import compile_first, missing_blocks
from sweeps.engine.executors import workers_of
from sweeps.engine.progress import Counts, display_of, is_in_notebook
from sweeps.engine.resume import ExistingPolicy
from sweeps.engine.settings import missing_scheduler, read_config
from sweeps.engine.signals import Stop
from sweeps.engine.sweep import sweep
from sweeps.exits import Exit, ExpectedError
from sweeps.files.attributes import result_dataset
from sweeps.files.netcdf import open_result
from sweeps.files.result_rows import Memory, Rows
from sweeps.grid import Grid
from sweeps.human import Messages, printable
from sweeps.paths import path_of

if TYPE_CHECKING:
    import xarray as xr

log = logging.getLogger(__name__)


class StoppedError(ExpectedError, RuntimeError):
    """A sweep into a file has ended early; the same call resumes it."""

    code = Exit.STOPPED


def run(
    source: str | Path | Mapping[str, Any] | Config,
    *,
    output: str | Path | None = None,
    workers: int | None = None,
    backend: str | None = None,
    scheduler: str | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
    overwrite: bool = False,
    retry_failed: bool = False,
) -> xr.Dataset:
    """Return the result of a sweep, the same as on the command line.

    Without `output` nothing is written, and an interruption loses everything. With `output` the
    call works like `stickslip sweep -o`: it computes the points that the file, or the journal of an
    interrupted run, lacks. The NetCDF library is not safe for threads, so no other thread may read
    or write NetCDF files meanwhile.

    In memory, `joblib.parallel_config(backend=..., n_jobs=...)` decides where points are computed,
    as for other packages that use joblib; otherwise `execution` in the config does, by default
    threads.

    >>> ds = run({"sweep": {"T": [200, 250], "omega": [10, 12]}})
    >>> ds.friction_force_amplitude.dims
    ('temperature', 'angular_frequency')

    Parameters
    ----------
    source
        A YAML file, a dict of the same shape, or a Config.
    output
        The NetCDF file to write, resume or grow. `output` in the config serves the command line
        only.
    workers
        Threads or processes, counted like joblib's `n_jobs` (-1: all cores); the default is that
        of `parallel_config`, then that of the config.
    backend, scheduler
        Where to compute, 'threads' or another value of `execution.backend` in a config, and the
        address of a dask scheduler; they take precedence over the config, and `parallel_config`
        over them.
    progress
        Show the progress: a bar on a terminal and in a notebook, lines elsewhere.
    on_block
        Called in the calling thread with each finished block of points, in any order; in memory
        only.
    overwrite, retry_failed
        How to treat existing results in `output`, as the options of `stickslip sweep` do.

    Raises
    ------
    ConfigError
        The config has problems; the message names all of them.
    ExecutorError
        The requested workers are not available.
    RuntimeError
        Points did not come back from the workers.
    RefusalError, StorageError, StoppedError, KeyboardInterrupt
        With `output`, in this order: existing results do not fit; the file cannot be read or
        written; the sweep ended early and can be resumed; and the same after Ctrl-C.
    TypeError, ValueError
        An unknown argument, or an invalid value.
    """
    config = source if isinstance(source, Config) else read_config(source)
    execution = _execution(config.execution, workers, backend, scheduler)
    config = config.model_copy(update={"execution": execution})
    if output is None:
        if overwrite or retry_failed:
            raise TypeError("overwrite, retry_failed: without output= no results exist")
        result = run_in_memory(config, workers=workers, progress=progress, on_block=on_block)
    else:
        if on_block is not None:
            raise TypeError("on_block works only without output=; leave one of the two out")
        result = _run_into(
            config, path_of(output), ExistingPolicy(overwrite, retry_failed), progress
        )
    register_accessors()
    return result


def _execution(
    configured: Execution, workers: int | None, backend: str | None, scheduler: str | None
) -> Execution:
    """Return the section `execution` with the arguments in place of its values.

    Raises ConfigError.
    """
    backend = backend or (None if scheduler is None else "dask")
    if workers is not None and workers < 0:
        workers = joblib.effective_n_jobs(workers)
    arguments = {"workers": workers, "backend": backend, "scheduler": scheduler}
    changes = {name: value for name, value in arguments.items() if value is not None}
    kept = configured.model_dump(exclude_none=True)
    if backend not in (None, "dask"):
        kept.pop("scheduler", None)  # it belongs to dask
    checks = [missing_scheduler]
    return from_mapping({"execution": kept | changes}, "run()", checks=checks).execution


def _run_into(config: Config, output: Path, policy: ExistingPolicy, progress: bool) -> xr.Dataset:
    def say(line: str) -> None:
        warns = line.startswith("warning")
        if progress or warns:
            # A notebook shows standard error as if something had gone wrong.
            stream = sys.stderr if warns or not is_in_notebook() else sys.stdout
            Messages(stream).write(f"{printable(line)}\n")

    stop = Stop(ends_process=False)
    outcome = sweep(config, output, say=say, progress=progress, policy=policy, stop=stop)
    if outcome.stopped is None:
        return open_result(output)
    kept = outcome.points - int(outcome.statuses[Status.PENDING])
    message = (
        f"stopped: {outcome.reason}. {kept} of {outcome.points} points are kept in "
        f"{outcome.output}.run; the same call continues from there"
    )
    interrupted = outcome.stopped is Exit.INTERRUPTED
    raise KeyboardInterrupt(message) if interrupted else StoppedError(message)


def run_in_memory(
    config: Config,
    *,
    workers: int | Workers | None = None,
    progress: bool = False,
    on_block: Callable[[Block], None] | None = None,
) -> xr.Dataset:
    """Return the result of a sweep as the command line would write it; nothing is written.

    Arguments and errors are those of `sweeps.run`.
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
    """Return the result rows (size, columns) of a sweep's points.

    `workers` is counted like joblib's `n_jobs`, or is an executor ready for use. Raises
    RuntimeError if points do not come back from the workers.
    """
    refuse_pull(config.simulation.drive)
    grid = Grid.from_config(config)
    memory, stop = Memory(grid.size), Stop()
    counts = Counts(grid.size, memory)
    compile_first(config, grid, stop, wanted=True)
    if isinstance(workers, Workers):
        ready: AbstractContextManager[Workers] = nullcontext(workers)
    else:
        ready = workers_of(config.execution, workers)
    with ready as executor, display_of(counts, wanted=progress):
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
