"""Code shared by the verbs of the command line: options, configs, and ending with a message."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TextIO

import typer

from sweeps.executor_table import EXECUTORS
from sweeps.exits import Exit
from sweeps.human import printable, size_text

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config.load import Config
    from sweeps.engine.existing import Part
    from sweeps.files.outputs import Outputs


def flag(name: str, help_text: str) -> Any:
    """Return an option that takes no value; giving its name turns it on."""
    return typer.Option(name, help=help_text)


def option(metavar: str, help_text: str, *names: str) -> Any:
    """Return an option whose value the help calls `metavar`; default name: `--<parameter>`."""
    return typer.Option(*names, metavar=metavar, help=help_text)


def output_option(help_text: str) -> Any:
    """Return the option `-o`, which names the output."""
    return typer.Option("-o", "--output", help=help_text)


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
    list[str] | None, option("KEY=VALUE", "Only the nearest value on an axis; SI units.")
]
BoundariesOption = Annotated[
    Path | None, option("FILE", "Borders from `stickslip boundary`, to be drawn on the map.")
]
OverwriteOption = Annotated[bool, flag("--overwrite", "Replace existing files.")]
NoProgressOption = Annotated[bool, flag("--no-progress", "Show no progress.")]

_LARGE = 1 << 18  # bytes; reading a larger config takes seconds


def stop_with(message: str, code: Exit) -> NoReturn:
    """End the command with a message and an exit code."""
    say(message)
    sys.exit(code)


def say(message: str) -> None:
    """Print a message; control characters in names and texts from files are escaped."""
    print(printable(message), file=sys.stderr)


@contextlib.contextmanager
def usage_errors(option: str = "") -> Iterator[None]:
    """End the command at a ValueError with its message, after the name of an option if given."""
    try:
        yield
    except ValueError as error:
        stop_with(f"{option}{error}", Exit.USAGE)


def warn_of_seal(file: Path) -> str:
    """Warn if a result is not as its sweep wrote it; return the warning, empty if there is none."""
    from sweeps.engine.existing import seal_note

    if note := seal_note(file):
        say(f"warning: {note}")
    return note


def is_config(path: Path) -> bool:
    """Return whether the name of a file is that of a config, not of a result."""
    return path.suffix.lower() in (".yaml", ".yml")


def beside(file: Path, ending: str) -> Path:
    """Return a name beside a file, with another ending; a name like T=1.5 has no ending itself."""
    has_none = file.suffix[1:2].isdigit()
    if not file.name:  # . and /
        stop_with(f"{file} is a folder, not a file", Exit.STORAGE)
    return file.with_name(f"{file.name if has_none else file.stem}{ending}")


def print_names(outputs: Outputs) -> None:
    """Print the names of a command's files, and say so if there was nothing to do."""
    for path in outputs.paths:
        print(path)
    if outputs.complete:
        say(f"{outputs.main} is complete, nothing to do")
    elif outputs.finished:
        say(f"{outputs.main} is complete now: an earlier, interrupted run had computed it")


def recalled_or_computed(
    outputs: Outputs, compute: Callable[[], xr.Dataset], *at_once: Callable[[], None]
) -> xr.Dataset:
    """Return what the same command wrote before, else what `compute` returns.

    Ctrl-C ends the process after the calls in `at_once`; nothing is kept.
    """
    from sweeps.engine.signals import interruptible

    ds = outputs.recalled()
    return interruptible(compute, *at_once, outputs.release) if ds is None else ds


def checked_config(file: Path | None, changes: list[str] | None) -> Config:
    """Return a config after checks that need the physics, and print its warnings.

    Raises ConfigError.
    """
    from sweeps.engine.settings import coarse_step, read_config

    if file is not None and file.is_file() and file.stat().st_size > _LARGE:
        say(f"reading {file} ({size_text(file.stat().st_size)})")
    config = read_config(file if file is not None else {}, changes or [])
    for warning in (*config.warnings, *coarse_step(config)):
        say(f"warning: {warning}")
    return config


# Endings of files that other commands write.
_OTHER_COMMANDS = {
    **dict.fromkeys((".csv", ".parquet"), "`stickslip export` makes a table of it"),
    **dict.fromkeys((".png", ".pdf", ".svg"), "`stickslip plot` draws it"),
    ".html": "`stickslip report` makes a page of it",
    **dict.fromkeys((".yaml", ".yml"), "`stickslip new` writes a config"),
}


def require_netcdf(path: Path, *, strict: bool = False) -> None:
    """End the command if the name of its NetCDF file has the ending of another kind of file.

    If `strict`, only .nc will do: other files are named after it.
    """
    other = _OTHER_COMMANDS.get(path.suffix.lower())
    if other or (strict and path.suffix != ".nc"):
        further = f"; {other}" if other else ""
        stop_with(f"{path}: -o names a NetCDF file, which ends in .nc{further}", Exit.USAGE)


def output_of(
    config: Config, file: Path, named: Path | None = None, part: Part | None = None
) -> Path:
    """Return the result file of a sweep: `named`, else the `output` of its config.

    The default differs for each part. Ends the command if the result would replace the config.
    """
    path = named or Path(config.output)
    if part and named is None:
        path = path.with_name(f"{path.stem}.{part.suffix}{path.suffix}")
    if path.exists() and path.samefile(file):
        stop_with(f"{path} is the config itself; -o names the result", Exit.USAGE)
    require_netcdf(path)
    return path


def execution_changes(
    workers: int | None, backend: str | None = None, scheduler: str | None = None
) -> list[str]:
    """Return the options that say where to compute, as changes to the config."""
    from sweeps.config.overrides import Option
    from sweeps.human import shortened

    if scheduler is not None and workers is not None:
        stop_with(
            "--workers: a scheduler has its own workers; give only one of the two", Exit.USAGE
        )
    backend = backend or (None if scheduler is None else "dask")
    given = {"workers": workers, "backend": backend, "scheduler": scheduler}
    changes: list[str] = [
        # As JSON, a text remains a text, even an empty one.
        Option(f"execution.{key}={json.dumps(value)}", f"--{key} {quote(shortened(str(value)))}")
        for key, value in given.items()
        if value is not None
    ]
    if backend not in (None, "dask") and scheduler is None:  # one in the config is for dask
        changes.append(Option("execution.scheduler=null", f"--backend {quote(backend)}"))
    return changes


def discard(stream: TextIO) -> None:
    """Redirect a broken stream to the null device: the interpreter flushes it at exit."""
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, stream.fileno())
    os.close(null)
