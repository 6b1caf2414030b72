"""Code shared by the verbs of the command line: options, configs, and ending with a message."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TextIO

import typer

from sweeps.executor_table import EXECUTORS
from sweeps.exits import Exit
from sweeps.human import printable, size_text

if TYPE_CHECKING:
    from sweeps.config.load import Config
    from sweeps.engine.existing import Part
    from sweeps.files.outputs import Outputs


def flag(name: str, does: str) -> Any:
    """Return the option that is on where its name is given."""
    return typer.Option(name, help=does)


def option(metavar: str, does: str, *names: str) -> Any:
    """Return an option whose value the help text calls `metavar`; by default `--<parameter>`."""
    return typer.Option(*names, metavar=metavar, help=does)


def output_option(does: str) -> Any:
    """Return the option `-o`, which names what is written."""
    return typer.Option("-o", "--output", help=does)


ConfigArgument = Annotated[
    Path, typer.Argument(metavar="CONFIG", help="YAML config; `configs/` has examples.")
]
OutputOption = Annotated[Path | None, output_option("Result file.")]
SetOption = Annotated[
    list[str] | None,
    option(
        "KEY=VALUE",
        "Change the config: a parameter by name or symbol, or a key like integrator.rtol.",
        "--set",
    ),
]
WorkersOption = Annotated[int | None, typer.Option(min=1, help="Number of threads or processes.")]
BackendOption = Annotated[str | None, option("|".join(EXECUTORS), "Where to compute the points.")]
SchedulerOption = Annotated[
    str | None, option("ADDRESS", "A dask scheduler, such as tcp://host:8786.")
]
AtOption = Annotated[
    list[str] | None, option("KEY=VALUE", "Only the nearest point of an axis; SI units.")
]
BoundariesOption = Annotated[
    Path | None, option("FILE", "Borders of `stickslip boundary`, drawn on the map.")
]
OverwriteOption = Annotated[bool, flag("--overwrite", "Replace existing files.")]
NoProgressOption = Annotated[bool, flag("--no-progress", "Show no progress.")]

_LARGE = 1 << 18  # bytes of a config that is read for seconds


def stop_with(message: str, code: Exit) -> NoReturn:
    """End the command with a message and an exit code."""
    say(message)
    sys.exit(code)


def say(message: str) -> None:
    """Print a message, without the control characters that names and texts of files may hold."""
    print(printable(message), file=sys.stderr)


@contextlib.contextmanager
def usage_errors(option: str = "") -> Iterator[None]:
    """End the command with the message of a ValueError, perhaps after the name of an option."""
    try:
        yield
    except ValueError as error:
        stop_with(f"{option}{error}", Exit.USAGE)


def warn_of_seal(file: Path) -> str:
    """Say where a result is not as its sweep wrote it, and return this sentence, else nothing."""
    from sweeps.engine.existing import seal_note

    if note := seal_note(file):
        say(f"warning: {note}")
    return note


def is_config(path: Path) -> bool:
    """Return whether a file is a config by its name, and not a result."""
    return path.suffix.lower() in (".yaml", ".yml")


def print_names(outputs: Outputs) -> None:
    """Print the names of the files of a command, and whether there was nothing to do."""
    for path in outputs.paths:
        print(path)
    if outputs.complete:
        say(f"{outputs.main} is complete, nothing to do")
    elif outputs.finished:
        say(f"{outputs.main} is complete now: an earlier run had computed it, and was stopped")


def checked_config(file: Path | None, changes: list[str] | None) -> Config:
    """Return the checked config and print its warnings; raises ConfigError."""
    from sweeps.engine.settings import coarse_step, read_config

    if file is not None and file.is_file() and file.stat().st_size > _LARGE:
        say(f"reading {file}, of {size_text(file.stat().st_size)}")
    config = read_config(file if file is not None else {}, changes or [])
    for warning in (*config.warnings, *coarse_step(config)):
        say(f"warning: {warning}")
    return config


def output_of(
    config: Config, file: Path, named: Path | None = None, part: Part | None = None
) -> Path:
    """Return the result file of a sweep: the one that is named, else that of its config.

    Each part has a file of its own. A result that would replace its config ends the command.
    """
    path = named or Path(config.output)
    if part and named is None:
        path = path.with_name(f"{path.stem}.{part.suffix}{path.suffix}")
    if path.exists() and path.samefile(file):
        stop_with(f"{path} is the config itself; -o names the result", Exit.USAGE)
    return path


def execution_changes(
    workers: int | None, backend: str | None = None, scheduler: str | None = None
) -> list[str]:
    """Return the options of where to compute as changes to the config."""
    from sweeps.config.overrides import Option
    from sweeps.human import shortened

    backend = backend or (None if scheduler is None else "dask")
    given = {"workers": workers, "backend": backend, "scheduler": scheduler}
    changes: list[str] = [
        # As JSON, a text is a text, even an empty one.
        Option(f"execution.{key}={json.dumps(value)}", f"--{key} {quote(shortened(str(value)))}")
        for key, value in given.items()
        if value is not None
    ]
    if backend not in (None, "dask") and scheduler is None:  # one in the config belongs to dask
        changes.append(Option("execution.scheduler=null", f"--backend {quote(backend)}"))
    return changes


def discard(stream: TextIO) -> None:
    """Redirect a broken stream to the null device: the interpreter flushes it at exit."""
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, stream.fileno())
    os.close(null)
