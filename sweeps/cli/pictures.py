"""The verbs that make trajectories and pictures: simulate, figure, plot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sweeps.cli.shared import (
    NoProgressOption,
    SetOption,
    WorkersOption,
    checked_config,
    execution_changes,
    say,
    stop_with,
)
from sweeps.cli.sweeps import sweep_and_report
from sweeps.exits import Exit

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config.load import Config
    from sweeps.figures import PlotOptions


def simulate(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[CONFIG]", help="YAML config; left out, the paper's Fig. 3."),
    ] = None,
    set_: SetOption = None,
    periods: Annotated[int | None, typer.Option(min=1, help="Drive periods.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="NetCDF file.")] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing output.")
    ] = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute one trajectory; the default file is results/<name of the config>-trajectory.nc."""
    from sweeps.engine.trajectories import AxisLeftError
    from sweeps.files.atomic import refuse_odd_output
    from sweeps.files.datasets import require_writable

    changes = [*(set_ or []), *([f"simulation.periods={periods}"] if periods else [])]
    config = checked_config(file, changes)
    path = output or Path("results") / f"{file.stem if file else 'paper'}-trajectory.nc"
    if config.sweep or config.cases:
        raise AxisLeftError(config)
    refuse_odd_output(path)
    if path.exists() and not overwrite:
        stop_with(
            f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE
        )
    require_writable(path)
    _write_trajectories(config, path, progress=not no_progress)


def figure(
    numbers: Annotated[
        list[str],
        typer.Argument(
            metavar="FIGURE...", help="Figures of the paper, 2 to 9 or all; or configs, FILE.yaml."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for figN.nc, figN.png, figN.pdf ....")
    ] = Path("results"),
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute and draw figures from scratch; older files of theirs are replaced.

    Those of the paper, or what a config asks for with `plot: {figure: NAME}`.
    """
    from sweeps.config.paper import PAPER

    known = {str(number): number for number in PAPER}
    unknown = [name for name in numbers if name not in {*known, "all"} and not _is_config(name)]
    if unknown:
        listed = f"{', '.join(known)}, all, or a config FILE.yaml"
        stop_with(f"no figure {', '.join(unknown)}; there are {listed}", Exit.USAGE)
    wanted = list(known) if "all" in numbers else []
    wanted += [name for name in dict.fromkeys(numbers) if name not in {*wanted, "all"}]
    failures = [
        _computed_figure(_planned(name), output, workers, progress=not no_progress)
        for name in wanted
    ]
    if any(failures):
        raise typer.Exit(Exit.FAILED_POINTS)


def _axis_option(*flags: str, does: str) -> Any:
    return typer.Option(*flags, metavar="AXIS", help=does)


def plot(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep or a trajectory.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Picture, .png, .pdf or .svg; left out, PNG and PDF."),
    ] = None,
    figure: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A figure by name; left out, the one of its config."),
    ] = None,
    variable: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A result variable; left out, both amplitudes."),
    ] = None,
    x: Annotated[str | None, _axis_option("-x", does="Axis across, by name or symbol.")] = None,
    y: Annotated[str | None, _axis_option("-y", does="Axis upward, which makes a map.")] = None,
    hue: Annotated[str | None, _axis_option("--hue", does="Axis with a curve a value.")] = None,
    row: Annotated[str | None, _axis_option("--row", does="Axis with a row a value.")] = None,
    col: Annotated[str | None, _axis_option("--col", does="Axis with a column a value.")] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="Only the nearest point of an axis; SI units."),
    ] = None,
    log: Annotated[
        str, typer.Option(metavar="x,y,z", help="Logarithmic scales; z: colours or values.")
    ] = "",
    style: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A matplotlib style file.")
    ] = None,
) -> None:
    """Draw a picture of a result file; docs/plot.md has examples."""
    from sweeps.engine.existing import seal_note
    from sweeps.figures import PlotOptions
    from sweeps.files.datasets import open_result

    options = PlotOptions(variable, x, y, hue, row, col, tuple(at or ()), log, style)
    if options.asks and figure is not None:
        stop_with(
            "--figure names a whole picture: leave out what chooses variables and axes", Exit.USAGE
        )
    ds = open_result(file)
    if note := seal_note(file):
        say(f"warning: {note}")
    target = output or (file.with_suffix("") if file.suffix == ".nc" else file)
    _refuse_picture_name(target)
    _draw(ds, target, figure or _asked_figure(ds), options)


def _is_config(name: str) -> bool:
    return Path(name).suffix in (".yaml", ".yml")


class _Planned(NamedTuple):
    """A figure: its config and what is changed in it, the stem of its files."""

    config: Path
    changes: list[str]
    stem: str
    figure: str | None
    """Left out, the one that the config asks for."""


def _planned(name: str) -> _Planned:
    """What a figure of this name is made of: a number of the paper, or a config."""
    from sweeps.config.paper import PAPER, shipped_config

    if _is_config(name):
        return _Planned(Path(name), [], Path(name).stem, None)
    paper = PAPER[int(name)]
    return _Planned(shipped_config(paper.config), paper.changes, f"fig{name}", paper.figure)


def _computed_figure(plan: _Planned, folder: Path, workers: int | None, *, progress: bool) -> int:
    """Compute, write and draw one figure; returns the number of failed points."""
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop
    from sweeps.figure_table import FIGURES
    from sweeps.files.datasets import open_result

    changes = [*plan.changes, *execution_changes(workers, None, None)]
    config, path = checked_config(plan.config, changes), folder / f"{plan.stem}.nc"
    figure = plan.figure or config.plot.figure
    failures, data = 0, FIGURES[figure].data
    if data == "sweep":
        afresh = ExistingPolicy(overwrite=True)
        failures = sweep_and_report(config, path, afresh, Stop(), progress=progress, timing=False)
    elif data == "phases":
        _write_phases(config, path)
    else:
        _write_trajectories(config, path, progress=progress)
    _draw(open_result(path), folder / plan.stem, figure)
    return failures


def _write_phases(config: Config, path: Path) -> None:
    """Write the free energy and the phases at the temperatures of a config's only axis."""
    from stickslip.phases import PAPER_STRAIN, phase_diagram
    from sweeps.files.attributes import add_provenance
    from sweeps.files.datasets import write_dataset

    strain = config.plot.elastic_strain
    diagram = phase_diagram(
        config.parameters(),
        temperatures=config.sweep["temperature"],
        strain=PAPER_STRAIN if strain is None else strain,
    )
    summary = "Free energy of a boundary lubricant film, and where it melts and solidifies"
    title = config.title or "Phases of a film"
    write_dataset(add_provenance(diagram, config, title, summary), path)
    print(path)


def _write_trajectories(config: Config, path: Path, *, progress: bool) -> None:
    """Write the trajectory of a config or, where it has an axis, one for each of its values."""
    from stickslip import IntegrationError, NoiseError
    from sweeps.engine.progress import Compiling
    from sweeps.engine.signals import interruptible
    from sweeps.engine.trajectories import trajectories, trajectory
    from sweeps.files.datasets import write_dataset

    compute, compiling = trajectories if config.sweep else trajectory, Compiling(wanted=progress)
    try:
        ds = interruptible(
            lambda: compute(config, compiling),
            "Interrupted; nothing was kept.",
            at_once=compiling.stop,
        )
    except NoiseError as error:
        stop_with(str(error), Exit.USAGE)
    except IntegrationError as error:
        stop_with(str(error), Exit.FAILED_POINTS)
    write_dataset(ds, path)
    print(path)


def _draw(
    ds: xr.Dataset, target: Path, name: str | None, options: PlotOptions | None = None
) -> None:
    """Draw the named figure, the one that suits the file or the options, into its pictures."""
    from sweeps.figures import draw, save
    from sweeps.files.atomic import storage_errors

    try:
        with storage_errors(f"cannot write {target}"):
            style = options.style if options else None
            pictures = save(draw(ds, name, options), target, style)
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)
    for picture in pictures:
        print(picture)


def _asked_figure(ds: xr.Dataset) -> str | None:
    """The figure named in the config that a file carries, where the file holds data for it."""
    from sweeps.config.load import ConfigError, from_yaml
    from sweeps.figures import obstacle

    try:
        asked = from_yaml(str(ds.attrs.get("config", "{}"))).plot.figure
    except ConfigError:  # a file of another version
        return None
    return None if obstacle(ds, asked) else asked


def _refuse_picture_name(path: Path) -> None:
    from sweeps.figures import ENDINGS

    if path.is_dir():
        stop_with(f"{path} is a folder; -o names a picture", Exit.STORAGE)
    ending = path.suffix.lower()
    if ending[1:].isalpha() and ending not in ENDINGS:
        known = "a picture ends in .png, .pdf or .svg, or in none of them for PNG and PDF"
        stop_with(f"{path}: {known}", Exit.USAGE)
