"""The command line: `stickslip VERB`.

Heavy imports live inside the commands, so that `--help` answers at once. Exit codes: 0 done,
1 unexpected error, 2 bad usage or config, 3 finished with failed points, 4 stopped early or output
in use, 5 input or output, 130 Ctrl-C.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    Exit,
    endings,
    execution_changes,
    read_settings,
    stop_of,
    stop_with,
    sweep_and_report,
)

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config.load import Config


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
OutputOption = Annotated[Path | None, typer.Option("-o", "--output", help="Result file.")]
WorkersOption = Annotated[int | None, typer.Option(min=1, help="Number of threads or processes.")]
BackendOption = Annotated[
    str | None, typer.Option(metavar="threads|loky|dask", help="Where the points are computed.")
]
SchedulerOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler, such as tcp://host:8786.")
]
NoProgressOption = Annotated[bool, typer.Option("--no-progress", help="Say nothing on the way.")]
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
        stop_with(f"Input/output error: {error}", Exit.STORAGE)
    except MemoryError:
        stop_with("Out of memory; a smaller grid or fewer samples may fit.", Exit.UNEXPECTED)
    except Exception as error:  # the last resort: one line, the trace for a report
        logging.getLogger(__name__).debug("unexpected", exc_info=True)
        stop_with(f"Unexpected {type(error).__name__}: {error}", Exit.UNEXPECTED)


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
    output: OutputOption = None,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    max_runtime: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help="Stop in time, such as 2h or 90min; resumable."),
    ] = None,
    set_: SetOption = None,
    no_progress: NoProgressOption = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Start afresh, whatever the output holds.")
    ] = False,
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Compute all points anew, not only missing ones.")
    ] = False,
    accept_mixed: Annotated[
        bool,
        typer.Option("--accept-mixed", help="Keep points that other settings computed."),
    ] = False,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Compute failed points once more.")
    ] = False,
    partial: Annotated[
        bool, typer.Option("--partial", help="Compute nothing; write what is there so far.")
    ] = False,
    keep_journal: Annotated[
        bool, typer.Option("--keep-journal", help="Leave the journal beside the result.")
    ] = False,
) -> None:
    """Compute what a config asks for and is not there yet, and write it to NetCDF.

    The same command runs, resumes and grows a sweep: after an interruption, with more values on an
    axis or a finer grid, exactly the missing points are computed.
    """
    from sweeps.engine.resume import ExistingPolicy

    changes = [*(set_ or []), *execution_changes(workers, backend, scheduler)]
    stop = stop_of(max_runtime)
    settings = read_settings(config, changes)
    policy = ExistingPolicy(overwrite, recompute, accept_mixed, retry_failed)
    path = output or Path(settings.output)
    failures = sweep_and_report(
        settings,
        path,
        policy,
        stop,
        progress=not no_progress,
        partial=partial,
        keep_journal=keep_journal,
    )
    if failures:
        raise typer.Exit(Exit.SOME_FAILED)


@app.command()
def plan(
    config: ConfigArgument,
    output: OutputOption = None,
    workers: WorkersOption = None,
    backend: BackendOption = None,
    scheduler: SchedulerOption = None,
    set_: SetOption = None,
) -> None:
    """Say what a sweep would take: points, blocks, bytes, and the time, from a pilot sample."""
    from sweeps.cli.output import print_plan

    settings = read_settings(
        config, [*(set_ or []), *execution_changes(workers, backend, scheduler)]
    )
    with endings():
        from sweeps.engine.interrupt import interruptible
        from sweeps.engine.plan import plan as make_plan

        path = output or Path(settings.output)
        made = interruptible(lambda: make_plan(settings, path), "Interrupted; nothing was kept.")
    execution = settings.execution
    print_plan(made, f"{execution.workers} workers ({execution.backend})")


@app.command()
def status(
    target: Annotated[
        Path, typer.Argument(metavar="FILE_OR_CONFIG", help="Result file, or config of the sweep.")
    ],
    json_: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """Say how a sweep stands, while it runs or after; it is not disturbed."""
    from sweeps.cli.output import print_state
    from sweeps.engine.state import state_of

    is_config = target.suffix.lower() in (".yaml", ".yml")
    path = Path(read_settings(target, None).output) if is_config else target
    with endings():
        state = state_of(path)
    if json_:
        import json

        print(json.dumps(state))
    elif state["state"] == "absent":
        stop_with(f"{path} does not exist, and no sweep to it has been begun", Exit.STORAGE)
    else:
        print_state(state)


@app.command()
def check(config: ConfigArgument, set_: SetOption = None) -> None:
    """Validate a config and say what it would compute."""
    settings = read_settings(config, set_)
    axes = [f"{name} {len(values)}" for name, values in settings.sweep.items()]
    if settings.cases:
        axes.append(f"case {len(next(iter(settings.cases.values())))}")
    method = ", ".join(f"{key} {value}" for key, value in settings.integrator.used().items())
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
    settings = read_settings(config, changes)
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
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute and draw figures of the paper from scratch; older files of theirs are replaced."""
    from sweeps.config.paper import PAPER

    unknown = [str(number) for number in numbers if number not in PAPER]
    if unknown:
        known = ", ".join(map(str, PAPER))
        stop_with(f"no figure {', '.join(unknown)}; there are {known}", Exit.USAGE)
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
    from sweeps.config.json_schema import json_schema_text

    print(json_schema_text(), end="")


@app.command()
def info(
    file: Annotated[Path | None, typer.Argument(help="Result file to describe.")] = None,
    hash_: Annotated[
        bool, typer.Option("--hash", help="Print only the SHA-256 of the file's content.")
    ] = False,
) -> None:
    """Describe the installation, or a result file."""
    from sweeps.cli.output import describe_file, describe_installation

    if file is None:
        if hash_:
            stop_with("--hash needs a FILE", Exit.USAGE)
        describe_installation()
        return
    ds = _open(file, whole=False)
    if hash_:
        from sweeps.files.datasets import content_hash

        print(content_hash(ds))
        return
    describe_file(ds)


# --- what the commands share ----------------------------------------------------------------------


def _refuse_axes(settings: Config) -> None:
    from sweeps.engine.trajectories import AxisLeftError

    if settings.sweep or settings.cases:
        stop_with(str(AxisLeftError(settings)), Exit.USAGE)


def _refuse_existing(path: Path, *, overwrite: bool) -> None:
    if path.is_dir():
        stop_with(f"{path} is a folder; -o names a file", Exit.STORAGE)
    if path.exists() and not path.is_file():  # a device or a pipe would be replaced
        stop_with(f"{path} is not an ordinary file; -o names one", Exit.STORAGE)
    if path.exists() and not overwrite:
        stop_with(
            f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE
        )


def _refuse_picture_name(path: Path) -> None:
    if path.is_dir():
        stop_with(f"{path} is a folder; -o names a picture", Exit.STORAGE)
    ending = path.suffix.lower()
    if ending[1:].isalpha() and ending not in (".png", ".pdf"):
        stop_with(f"{path}: a picture ends in .png or .pdf, or in neither for both", Exit.USAGE)


def _require_writable(ds: xr.Dataset, path: Path) -> None:
    from sweeps.files.atomic import StorageError
    from sweeps.files.datasets import require_writable

    try:
        require_writable(ds, path)
    except StorageError as error:
        stop_with(str(error), Exit.STORAGE)


def _write(ds: xr.Dataset, path: Path) -> None:
    from sweeps.files.atomic import StorageError
    from sweeps.files.datasets import write_dataset

    try:
        write_dataset(ds, path)
    except StorageError as error:
        stop_with(str(error), Exit.STORAGE)


def _trajectory(settings: Config) -> xr.Dataset:
    """The trajectory or, of a figure with one axis, the trajectories of a config."""
    from stickslip import IntegrationError, NoiseError
    from sweeps.engine.interrupt import interruptible
    from sweeps.engine.trajectories import trajectory

    try:
        return interruptible(lambda: trajectory(settings), "Interrupted; nothing was kept.")
    except NoiseError as error:
        stop_with(str(error), Exit.USAGE)
    except IntegrationError as error:
        stop_with(str(error), Exit.SOME_FAILED)


def _paper_figure(number: int, folder: Path, workers: int | None, *, progress: bool) -> int:
    """Compute, write and draw one figure; returns the number of failed points."""
    from sweeps.config.paper import PAPER, shipped_config
    from sweeps.engine.interrupt import interruptible
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop
    from sweeps.engine.trajectories import trajectories

    plan = PAPER[number]
    changes = [*plan.changes, *execution_changes(workers, None, None)]
    settings = read_settings(shipped_config(plan.config), changes)
    path = folder / f"fig{number}.nc"
    failures = 0
    if plan.figure == "amplitudes":
        afresh = ExistingPolicy(overwrite=True)
        failures = sweep_and_report(settings, path, afresh, Stop(), progress=progress, timing=False)
        ds = _open(path)
    else:
        if settings.sweep:
            ds = interruptible(lambda: trajectories(settings), "Interrupted; nothing was kept.")
        else:
            ds = _trajectory(settings)
        _write(ds, path)
        print(path)
    for picture in _draw(ds, folder / f"fig{number}", plan.figure):
        print(picture)
    return failures


def _open(file: Path, *, whole: bool = True) -> xr.Dataset:
    from sweeps.files.atomic import StorageError
    from sweeps.files.datasets import open_result

    try:
        return open_result(file, whole=whole)
    except StorageError as error:
        stop_with(str(error), Exit.STORAGE)


def _draw(ds: xr.Dataset, target: Path, name: str | None = None) -> list[Path]:
    """Draw the named figure, or the one that the file asks for, into one or two pictures."""
    from sweeps.figures import draw, save

    try:
        return save(draw(ds, name or _asked_figure(ds)), target)
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)
    except OSError as error:
        stop_with(f"cannot write {target}: {error.strerror or error}", Exit.STORAGE)


def _asked_figure(ds: xr.Dataset) -> str | None:
    """The figure named in the config that a file carries, where the file holds data for it."""
    from sweeps.config.load import ConfigError, from_yaml

    try:
        asked = from_yaml(str(ds.attrs.get("config", "{}"))).plot.figure
    except ConfigError:  # a file of another version
        return None
    is_sweep = "elastic_stress_amplitude" in ds
    return asked if (asked == "amplitudes") == is_sweep else None
