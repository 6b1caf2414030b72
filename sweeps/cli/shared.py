"""What several verbs of the command line share: reading configs, sweeping, and how they end."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import typer

if TYPE_CHECKING:
    from sweeps.config.load import Config
    from sweeps.engine.outcome import Outcome
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop


class Exit(IntEnum):
    """Exit codes of the command line."""

    DONE = 0
    UNEXPECTED = 1
    USAGE = 2
    SOME_FAILED = 3
    STOPPED = 4
    STORAGE = 5
    INTERRUPTED = 130


def stop_with(message: str, code: Exit) -> NoReturn:
    """End the command with a message and an exit code."""
    print(message, file=sys.stderr)
    sys.exit(code)


def read_settings(config: Path | None, changes: list[str] | None) -> Config:
    """The checked config, its warnings printed; ends with exit code 2 where it has problems."""
    from sweeps.config.load import ConfigError
    from sweeps.engine.in_memory import read_config
    from sweeps.engine.options import coarse_step

    try:
        settings = read_config(config if config is not None else {}, changes or [])
    except ConfigError as error:
        stop_with(str(error), Exit.USAGE)
    for warning in (*settings.warnings, *coarse_step(settings)):
        print(f"warning: {warning}", file=sys.stderr)
    return settings


def execution_changes(workers: int | None, backend: str | None, scheduler: str | None) -> list[str]:
    """The options that say where to compute, as changes of the config."""
    backend = backend or ("dask" if scheduler else None)
    if backend and backend != "dask" and scheduler is None:
        scheduler = "null"  # one in the config belongs to dask
    given = {"workers": workers, "backend": backend, "scheduler": scheduler}
    return [f"execution.{key}={value}" for key, value in given.items() if value is not None]


def stop_of(max_runtime: str | None) -> Stop:
    """When a sweep is to end; ends with exit code 2 where the duration is none."""
    from sweeps.engine.signals import Stop, parse_duration

    try:
        return Stop(parse_duration(max_runtime) if max_runtime is not None else None)
    except ValueError as error:
        stop_with(f"--max-runtime: {error}", Exit.USAGE)


@contextlib.contextmanager
def endings() -> Iterator[None]:
    """Failures of a sweep that have an exit code and need no trace."""
    from sweeps.engine.executors.base import ExecutorError
    from sweeps.engine.existing import RefusalError
    from sweeps.engine.worker import WorkerMismatchError
    from sweeps.files.atomic import StorageError
    from sweeps.files.run_folder import InUseError

    try:
        yield
    except RefusalError as error:
        stop_with(str(error), Exit.USAGE)
    except (InUseError, ExecutorError, WorkerMismatchError) as error:
        stop_with(str(error), Exit.STOPPED)
    except StorageError as error:
        stop_with(str(error), Exit.STORAGE)


def sweep_and_report(
    settings: Config,
    path: Path,
    policy: ExistingPolicy,
    stop: Stop,
    *,
    progress: bool = True,
    partial: bool = False,
    keep_journal: bool = False,
    timing: bool = True,
) -> int:
    """Sweep, and say how it went; returns the number of failed points."""
    from sweeps.cli.output import print_summary, write_timing
    from sweeps.engine.outcome import Console
    from sweeps.engine.sweep import sweep as run_sweep

    def say(line: str) -> None:
        if progress or line.startswith("warning"):
            print(line, file=sys.stderr)

    on_terminal = progress and sys.stdin.isatty() and sys.stderr.isatty()
    confirm = functools.partial(typer.confirm, default=True, err=True) if on_terminal else None
    with endings():
        outcome = run_sweep(
            settings,
            path,
            console=Console(say, confirm, progress),
            policy=policy,
            stop=stop,
            partial=partial,
            keep_journal=keep_journal,
        )
    if outcome.stopped is not None:
        _leave(outcome)
    if outcome.computed and timing:
        write_timing(outcome, settings.execution.workers, settings.execution.backend)
    print_summary(outcome)
    return outcome.failures


# Options that decide about what is there once, and not again when the sweep goes on.
_ONCE = ("--overwrite", "--recompute", "--accept-mixed", "--retry-failed")


def _leave(outcome: Outcome) -> NoReturn:
    """Say how to go on, and end: a compiler at work in a thread would keep the process alive."""
    import os
    import shlex

    from stickslip.status import Status
    from sweeps.cli.output import print_reasons

    again = shlex.join(["stickslip", *(a for a in sys.argv[1:] if a not in _ONCE)])
    kept = outcome.points - int(outcome.statuses[Status.PENDING])
    print(
        f"Stopped ({outcome.reason}). {kept} of {outcome.points} points are kept in "
        f"{outcome.output}.run. To go on:\n  {again}",
        file=sys.stderr,
    )
    failed = outcome.statuses.copy()
    failed[Status.PENDING] = 0
    print_reasons(failed)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(outcome.stopped or Exit.STOPPED)
