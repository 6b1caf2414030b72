"""What several verbs of the command line share: their options, configs, files, and how they end."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sweeps.exits import Exit

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config.load import Config

ConfigArgument = Annotated[
    Path, typer.Argument(metavar="CONFIG", help="YAML config; `configs/` has examples.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change the config: a parameter by name or symbol, or a path like integrator.rtol.",
    ),
]
OutputOption = Annotated[Path | None, typer.Option("-o", "--output", help="Result file.")]
WorkersOption = Annotated[int | None, typer.Option(min=1, help="Number of threads or processes.")]
BackendOption = Annotated[
    str | None, typer.Option(metavar="threads|loky|dask", help="Where the points are computed.")
]
SchedulerOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler, such as tcp://host:8786.")
]
NoProgressOption = Annotated[bool, typer.Option("--no-progress", help="Say nothing on the way.")]


def stop_with(message: str, code: Exit) -> NoReturn:
    """End the command with a message and an exit code."""
    print(message, file=sys.stderr)
    sys.exit(code)


def checked_config(file: Path | None, changes: list[str] | None) -> Config:
    """The checked config, its warnings printed; ends with exit code 2 where it has problems."""
    from sweeps.config.load import ConfigError
    from sweeps.engine.in_memory import read_config
    from sweeps.engine.options import coarse_step

    try:
        config = read_config(file if file is not None else {}, changes or [])
    except ConfigError as error:
        stop_with(str(error), Exit.USAGE)
    for warning in (*config.warnings, *coarse_step(config)):
        print(f"warning: {warning}", file=sys.stderr)
    return config


def execution_changes(workers: int | None, backend: str | None, scheduler: str | None) -> list[str]:
    """The options that say where to compute, as changes of the config."""
    backend = backend or ("dask" if scheduler else None)
    if backend and backend != "dask" and scheduler is None:
        scheduler = "null"  # one in the config belongs to dask
    given = {"workers": workers, "backend": backend, "scheduler": scheduler}
    return [f"execution.{key}={value}" for key, value in given.items() if value is not None]


def open_file(file: Path, *, whole: bool = True) -> xr.Dataset:
    """The Dataset in a file; ends with exit code 5 where it cannot be read."""
    from sweeps.files.datasets import open_result

    with storage_endings():
        return open_result(file, whole=whole)


@contextlib.contextmanager
def storage_endings() -> Iterator[None]:
    """Failures of reading and writing end with exit code 5 and need no trace."""
    from sweeps.files.atomic import StorageError

    try:
        yield
    except StorageError as error:
        stop_with(str(error), Exit.STORAGE)


@contextlib.contextmanager
def endings() -> Iterator[None]:
    """Failures of a sweep that have an exit code and need no trace."""
    from sweeps.engine.executors.base import ExecutorError
    from sweeps.engine.existing import RefusalError
    from sweeps.engine.worker import WorkerMismatchError
    from sweeps.files.run_folder import InUseError

    try:
        with storage_endings():
            yield
    except RefusalError as error:
        stop_with(str(error), Exit.USAGE)
    except (InUseError, ExecutorError, WorkerMismatchError) as error:
        stop_with(str(error), Exit.STOPPED)
