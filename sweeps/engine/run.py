"""A sweep from Python: in memory, or into a file that is resumed and grown."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import joblib

from stickslip.accessors import register_accessors
from stickslip.status import Status
from sweeps.config.load import Config, from_mapping
from sweeps.config.schema import Execution
from sweeps.engine.executors.worker import Block
from sweeps.engine.in_memory import run_in_memory
from sweeps.engine.outcome import Console, Outcome
from sweeps.engine.resume import ExistingPolicy
from sweeps.engine.settings import read_config
from sweeps.engine.signals import Stop
from sweeps.engine.sweep import sweep
from sweeps.exits import Exit, ExpectedError
from sweeps.files.datasets import open_result
from sweeps.human import did_you_mean, printable

if TYPE_CHECKING:
    import xarray as xr

_DECISIONS = tuple(ExistingPolicy.__dataclass_fields__)


class StoppedError(ExpectedError, RuntimeError):
    """A sweep into a file that ended early; the same call goes on from there."""

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
    **existing: bool,
) -> xr.Dataset:
    """The result of a sweep, the same as on the command line.

    Without `output` nothing is written and nothing outlives an interruption. With it the call does
    what `stickslip sweep -o` does: it computes what the file, or the journal of an interrupted run,
    does not have yet.

    In memory, `joblib.parallel_config(backend=..., n_jobs=...)` decides where it is computed, as
    for other packages that use joblib, then `execution` in the config, by default threads.

    Parameters
    ----------
    source
        A YAML file, a dict of the same shape, or a Config.
    output
        The NetCDF file to write, resume or grow. `output` in the config is left to the command
        line.
    workers
        Threads or processes, counted as joblib's `n_jobs` (-1: all cores); by default what
        `parallel_config` says, then what the config says.
    backend, scheduler
        Where to compute, 'threads' or another name that `execution.backend` of a config may have,
        and the address of a dask scheduler, instead of those of the config.
    progress
        Show how far it is: a bar on a terminal and in a notebook, lines elsewhere.
    on_block
        Called, in the calling thread, with each block of points as it is finished, in any order;
        in memory only.
    existing
        What to do with existing results of `output`: `overwrite` or `retry_failed`, as the options
        of `stickslip sweep`.

    Raises
    ------
    ConfigError
        The config has problems; all of them are named.
    ExecutorError
        The workers that are asked for cannot be had.
    RuntimeError
        Points were lost on the way.
    RefusalError, StorageError, StoppedError, KeyboardInterrupt
        With `output`: existing results do not fit; it cannot be read or written; the sweep ended
        early and can be resumed, by Ctrl-C the last.
    TypeError, ValueError
        An argument that is none, or has no such value.
    """
    _refuse_unknown(existing)
    config = source if isinstance(source, Config) else read_config(source)
    execution = _execution(config.execution, workers, backend, scheduler)
    config = config.model_copy(update={"execution": execution})
    if output is None:
        if existing:
            raise TypeError(f"{', '.join(existing)}: there are existing results with output= only")
        result = run_in_memory(config, workers=workers, progress=progress, on_block=on_block)
    else:
        if on_block is not None:
            raise TypeError("on_block is called in memory only: leave out output=")
        result = _run_into(config, Path(output), ExistingPolicy(**existing), progress)
    register_accessors()
    return result


def _refuse_unknown(existing: Mapping[str, bool]) -> None:
    for name in existing:
        if name not in _DECISIONS:
            hint = did_you_mean(name, [*_DECISIONS, "output", "workers", "backend", "progress"])
            raise TypeError(f"run() has no argument {name!r}{hint}")


def _execution(
    configured: Execution, workers: int | None, backend: str | None, scheduler: str | None
) -> Execution:
    """Where to compute, with what is given instead of what is configured; raises ConfigError."""
    backend = backend or ("dask" if scheduler else None)
    asked = {"workers": workers, "backend": backend, "scheduler": scheduler}
    given = {name: value for name, value in asked.items() if value is not None}
    if workers is not None and workers < 0:
        given["workers"] = joblib.effective_n_jobs(workers)
    kept = configured.model_dump(exclude_none=True)
    if backend not in (None, "dask"):
        kept.pop("scheduler", None)  # it belongs to dask
    return from_mapping({"execution": kept | given}, "run()").execution


def _run_into(config: Config, output: Path, policy: ExistingPolicy, progress: bool) -> xr.Dataset:
    def tell(line: str) -> None:
        if progress or line.startswith("warning"):
            sys.stderr.write(f"{printable(line)}\n")

    stop = Stop(ends_process=False)
    console = Console(tell, progress=progress)
    outcome = sweep(config, output, console=console, policy=policy, stop=stop)
    if outcome.stopped is not None:
        _raise_stopped(outcome)
    return open_result(output)


def _raise_stopped(outcome: Outcome) -> NoReturn:
    kept = outcome.points - int(outcome.statuses[Status.PENDING])
    told = (
        f"stopped: {outcome.reason}. {kept} of {outcome.points} points are kept in "
        f"{outcome.output}.run; the same call goes on from there"
    )
    raise KeyboardInterrupt(told) if outcome.stopped is Exit.INTERRUPTED else StoppedError(told)
