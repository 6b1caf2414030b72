"""The command line: `stickslip VERB`.

Heavy imports live inside the commands, so that `--help` answers at once. Exit codes: 0 done,
1 unexpected error, 2 bad usage or config, 3 finished with failed points, 5 input or output,
130 Ctrl-C.
"""

from __future__ import annotations

import logging
import sys
import time
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config import Config


class Exit(IntEnum):
    """Exit codes of the command line."""

    DONE = 0
    UNEXPECTED = 1
    USAGE = 2
    SOME_FAILED = 3
    STORAGE = 5
    INTERRUPTED = 130


app = typer.Typer(
    name="stickslip",
    help="Boundary friction with a first-order phase transition: orbits, sweeps, figures.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

ConfigArgument = Annotated[Path, typer.Argument(help="YAML config; `configs/` has examples.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change the config: a parameter by name or symbol, or a path like integrator.rtol.",
    ),
]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Replace an existing output.")]


def main() -> None:
    """Run the command line; every failure ends in one message and an exit code."""
    logging.basicConfig(format="%(levelname)s: %(message)s", stream=sys.stderr)
    try:
        app(prog_name="stickslip")
    except SystemExit as end:
        if end.code == Exit.INTERRUPTED:  # typer's silent answer to Ctrl-C
            print("Interrupted; only files named above were kept.", file=sys.stderr)
        raise
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has gone: no further words
        sys.exit(Exit.DONE)
    except OSError as error:  # such as a full disk behind the standard output
        _stop(f"Input/output error: {error}", Exit.STORAGE)
    except MemoryError:
        _stop("Out of memory; a smaller grid or fewer samples may fit.", Exit.UNEXPECTED)
    except Exception as error:  # the last resort: one line, the trace for a report
        logging.getLogger(__name__).debug("unexpected", exc_info=True)
        _stop(f"Unexpected {type(error).__name__}: {error}", Exit.UNEXPECTED)


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help="Log details and tracebacks.")] = False,
) -> None:
    if verbose:
        logging.getLogger().setLevel(logging.DEBUG)
        for noisy in ("numba", "matplotlib"):
            logging.getLogger(noisy).setLevel(logging.WARNING)
    if version:
        from importlib import metadata

        print(f"stickslip {metadata.version('stickslip')}")
        raise typer.Exit


@app.command()
def sweep(
    config: ConfigArgument,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Result file.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Number of threads.")] = None,
    backend: Annotated[
        str | None, typer.Option(help="How the points are spread; only threads for now.")
    ] = None,
    set_: SetOption = None,
    no_progress: Annotated[bool, typer.Option("--no-progress", help="Say nothing on the way.")] = (
        False
    ),
    overwrite: OverwriteOption = False,
) -> None:
    """Compute the stationary amplitudes of all points of a config and write them to NetCDF."""
    from sweeps.summary import print_summary, write_timing

    changes = [*(set_ or []), *([f"execution.backend={backend}"] if backend else [])]
    settings = _read(config, changes)
    path = output or Path(settings.output)
    _refuse_existing(path, overwrite=overwrite)
    ds, seconds = _swept(settings, path, workers, progress=not no_progress)
    _write(ds, path)
    write_timing(path, ds, seconds, workers or settings.execution.workers)
    failures = print_summary(ds, path, seconds)
    if failures:
        raise typer.Exit(Exit.SOME_FAILED)


@app.command()
def check(config: ConfigArgument, set_: SetOption = None) -> None:
    """Validate a config and say what it would compute."""
    settings = _read(config, set_)
    axes = [f"{name} {len(values)}" for name, values in settings.sweep.items()]
    if settings.cases:
        axes.append(f"case {len(next(iter(settings.cases.values())))}")
    method = ", ".join(f"{key} {value}" for key, value in settings.integrator.settings().items())
    points = 1
    for axis in axes:
        points *= int(axis.rsplit(" ", 1)[1])
    print(f"{config}: valid")
    print(f"points: {points}" + (f" ({' x '.join(axes)})" if axes else ""))
    print(f"integrator: {method}")
    print(f"output: {settings.output}")


@app.command()
def simulate(
    config: Annotated[
        Path | None, typer.Argument(help="YAML config; left out, the paper's Fig. 3.")
    ] = None,
    set_: SetOption = None,
    periods: Annotated[int | None, typer.Option(min=1, help="Drive periods.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="NetCDF file.")] = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Compute one trajectory; the default file is results/<name of the config>-trajectory.nc."""
    import xarray as xr

    changes = [*(set_ or []), *([f"simulation.periods={periods}"] if periods else [])]
    settings = _read(config, changes)
    path = output or Path("results") / f"{config.stem if config else 'paper'}-trajectory.nc"
    _refuse_axes(settings)
    _refuse_existing(path, overwrite=overwrite)
    _require_writable(xr.Dataset(), path)
    _write(_trajectory(settings), path)
    print(path)


@app.command()
def figure(
    numbers: Annotated[list[int], typer.Argument(help="Figures of the paper: 3 4 5 7 8 9.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for figN.nc, figN.png, figN.pdf.")
    ] = Path("results"),
    workers: Annotated[int | None, typer.Option(min=1, help="Number of threads.")] = None,
    no_progress: Annotated[bool, typer.Option("--no-progress", help="Say nothing on the way.")] = (
        False
    ),
) -> None:
    """Compute and draw figures of the paper from scratch; older files of theirs are replaced."""
    from sweeps.paper import PAPER

    unknown = [str(number) for number in numbers if number not in PAPER]
    if unknown:
        known = ", ".join(map(str, PAPER))
        _stop(f"no figure {', '.join(unknown)}; there are {known}", Exit.USAGE)
    failures = [
        _paper_figure(number, output, workers, progress=not no_progress)
        for number in dict.fromkeys(numbers)
    ]
    if any(failures):
        raise typer.Exit(Exit.SOME_FAILED)


@app.command()
def plot(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep or a trajectory.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Picture, .png or .pdf; left out, both."),
    ] = None,
) -> None:
    """Draw the standard picture of a result file."""
    ds = _open(file)
    target = output or (file.with_suffix("") if file.suffix == ".nc" else file)
    _refuse_picture_name(target)
    for path in _draw(ds, target):
        print(path)


@app.command()
def schema() -> None:
    """Print the JSON Schema of a config, for editors."""
    from sweeps.config_schema import json_schema_text

    print(json_schema_text(), end="")


@app.command()
def info(
    file: Annotated[Path | None, typer.Argument(help="Result file to describe.")] = None,
    hash_: Annotated[
        bool, typer.Option("--hash", help="Print only the SHA-256 of the file's content.")
    ] = False,
) -> None:
    """Describe the installation, or a result file."""
    from sweeps.summary import describe_file, describe_installation

    if file is None:
        if hash_:
            _stop("--hash needs a FILE", Exit.USAGE)
        describe_installation()
        return
    ds = _open(file)
    if hash_:
        from sweeps.storage import content_hash

        print(content_hash(ds))
        return
    describe_file(ds)


# --- what the commands share ----------------------------------------------------------------------


def _stop(message: str, code: Exit) -> NoReturn:
    print(message, file=sys.stderr)
    sys.exit(code)


def _read(config: Path | None, changes: list[str] | None) -> Config:
    """The checked config, its warnings printed; ends with exit code 2 where it has problems."""
    from sweeps.config import ConfigError
    from sweeps.options import coarse_step
    from sweeps.pipeline import read_config

    try:
        settings = read_config(config if config is not None else {}, changes or [])
    except ConfigError as error:
        _stop(str(error), Exit.USAGE)
    for warning in (*settings.warnings, *coarse_step(settings)):
        print(f"warning: {warning}", file=sys.stderr)
    return settings


def _refuse_axes(settings: Config) -> None:
    from sweeps.trajectories import AxisLeftError

    if settings.sweep or settings.cases:
        _stop(str(AxisLeftError(settings)), Exit.USAGE)


def _refuse_existing(path: Path, *, overwrite: bool) -> None:
    if path.is_dir():
        _stop(f"{path} is a folder; -o names a file", Exit.STORAGE)
    if path.exists() and not path.is_file():  # a device or a pipe would be replaced
        _stop(f"{path} is no ordinary file; -o names one", Exit.STORAGE)
    if path.exists() and not overwrite:
        _stop(f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE)


def _refuse_picture_name(path: Path) -> None:
    if path.is_dir():
        _stop(f"{path} is a folder; -o names a picture", Exit.STORAGE)
    ending = path.suffix.lower()
    if ending[1:].isalpha() and ending not in (".png", ".pdf"):
        _stop(f"{path}: a picture ends in .png or .pdf, or in neither for both", Exit.USAGE)


def _swept(
    settings: Config, path: Path, workers: int | None, *, progress: bool
) -> tuple[xr.Dataset, float]:
    """The Dataset of a sweep and the seconds that it took, compiled code ready."""
    from sweeps.execute import compile_kernels
    from sweeps.grid import Grid
    from sweeps.interrupt import interruptible
    from sweeps.options import doubts, options_of
    from sweeps.pipeline import pending_dataset, run
    from sweeps.progress import make_progress

    empty = pending_dataset(settings)
    _require_writable(empty, path)
    stopped = "Interrupted; nothing was kept (a sweep cannot be resumed yet)."
    if progress:
        print(f"{empty.status.size} points to compute", file=sys.stderr)
    grid = Grid.from_config(settings)
    interruptible(lambda: compile_kernels(options_of(settings), grid), stopped)
    begun = time.monotonic()
    with make_progress(empty.status.size, wanted=progress) as shown:
        ds = interruptible(
            lambda: run(
                settings,
                workers=workers,
                on_block=lambda block: shown.advance(len(block.results), block.failures),
            ),
            stopped,
            tidy=shown.stop,
        )
    seconds = time.monotonic() - begun
    for warning in doubts(settings, ds):
        print(f"warning: {warning}", file=sys.stderr)
    return ds, seconds


def _require_writable(ds: xr.Dataset, path: Path) -> None:
    from sweeps.storage import StorageError, require_writable

    try:
        require_writable(ds, path)
    except StorageError as error:
        _stop(str(error), Exit.STORAGE)


def _write(ds: xr.Dataset, path: Path) -> None:
    from sweeps.storage import StorageError, write_dataset

    try:
        write_dataset(ds, path)
    except StorageError as error:
        _stop(str(error), Exit.STORAGE)


def _trajectory(settings: Config) -> xr.Dataset:
    """The trajectory or, of a figure with one axis, the trajectories of a config."""
    from stickslip import IntegrationError, NoiseError
    from sweeps.interrupt import interruptible
    from sweeps.trajectories import trajectory

    try:
        return interruptible(lambda: trajectory(settings), "Interrupted; nothing was kept.")
    except NoiseError as error:
        _stop(str(error), Exit.USAGE)
    except IntegrationError as error:
        _stop(str(error), Exit.SOME_FAILED)


def _paper_figure(number: int, folder: Path, workers: int | None, *, progress: bool) -> int:
    """Compute, write and draw one figure; returns the number of failed points."""
    from sweeps.interrupt import interruptible
    from sweeps.paper import PAPER
    from sweeps.shipped import shipped_config
    from sweeps.summary import print_summary
    from sweeps.trajectories import trajectories

    plan = PAPER[number]
    settings = _read(shipped_config(plan.config), plan.changes)
    path = folder / f"fig{number}.nc"
    seconds = None
    if plan.figure == "amplitudes":
        ds, seconds = _swept(settings, path, workers, progress=progress)
    elif settings.sweep:
        ds = interruptible(lambda: trajectories(settings), "Interrupted; nothing was kept.")
    else:
        ds = _trajectory(settings)
    _write(ds, path)
    failures = 0
    if seconds is None:
        print(path)
    else:
        failures = print_summary(ds, path, seconds)
    for picture in _draw(ds, folder / f"fig{number}", plan.figure):
        print(picture)
    return failures


def _open(file: Path) -> xr.Dataset:
    from sweeps.storage import StorageError, open_result

    try:
        return open_result(file)
    except StorageError as error:
        _stop(str(error), Exit.STORAGE)


def _draw(ds: xr.Dataset, target: Path, name: str | None = None) -> list[Path]:
    """Draw the named figure, or the one that the file asks for, into one or two pictures."""
    from sweeps.figures import draw, save

    try:
        return save(draw(ds, name or _asked_figure(ds)), target)
    except ValueError as error:
        _stop(str(error), Exit.USAGE)
    except OSError as error:
        _stop(f"cannot write {target}: {error.strerror or error}", Exit.STORAGE)


def _asked_figure(ds: xr.Dataset) -> str | None:
    """The figure named in the config that a file carries, where the file holds data for it."""
    from sweeps.config import ConfigError, from_yaml

    try:
        asked = from_yaml(str(ds.attrs.get("config", "{}"))).plot.figure
    except ConfigError:  # a file of another version
        return None
    is_sweep = "elastic_stress_amplitude" in ds
    return asked if (asked == "amplitudes") == is_sweep else None


if __name__ == "__main__":
    main()
