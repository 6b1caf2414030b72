"""The verbs that make trajectories and figures: simulate, figure, plot."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sweeps.cli.shared import (
    BoundariesOption,
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
    from sweeps.figures.look import Look


_LONGEST_STEM = 120  # bytes or so: names may have 255, and pictures beside it are called alike


def simulate(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[CONFIG]", help="YAML config. [default: the paper's Fig. 3]"),
    ] = None,
    set_: SetOption = None,
    periods: Annotated[int | None, typer.Option(min=1, help="Drive periods.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="NetCDF file.")] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing output.")
    ] = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute a trajectory; by default into results/<name of the config>-trajectory.nc.

    What is set is part of that name: results/paper-T=250-trajectory.nc.
    """
    from sweeps.config.overrides import Option
    from sweeps.engine.trajectories import AxisLeftError
    from sweeps.files.atomic import refuse_odd_output
    from sweeps.files.datasets import require_writable

    own = [Option(f"simulation.periods={periods}", f"--periods {periods}")] if periods else []
    changes = [*(set_ or []), *own]
    config = checked_config(file, changes)
    path = output or trajectory_path(file, changes)
    if config.sweep or config.cases:
        raise AxisLeftError(config)
    refuse_odd_output(path)
    if path.exists() and not overwrite:
        stop_with(
            f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE
        )
    require_writable(path)
    _write_trajectories(config, path, progress=not no_progress)


def trajectory_path(file: Path | None, changes: list[str]) -> Path:
    """Return the default name of a trajectory, which differs where something else is set."""
    words = [re.sub(r"[^\w.+=-]+", "_", change) for change in changes]
    name = "-".join([file.stem if file else "paper", *words])[:_LONGEST_STEM]
    return Path("results") / f"{name}-trajectory.nc"


def figure(
    numbers: Annotated[
        list[str],
        typer.Argument(
            metavar="FIGURE...", help="Figures of the paper, 2 to 9, or all; or configs, FILE.yaml."
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder for figN.nc, figN.png, figN.pdf and so on."),
    ] = Path("results"),
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute and draw figures of the paper or of configs, replacing older files.

    The figure of a config is that of its `plot: {figure: NAME}`.
    """
    from sweeps.config.paper import PAPER

    known = {str(number): number for number in PAPER}
    unknown = [name for name in numbers if name not in {*known, "all"} and not _is_config(name)]
    if unknown:
        listed = f"{', '.join(known)}, all, or a config FILE.yaml"
        stop_with(f"no figure {', '.join(unknown)}; there are {listed}", Exit.USAGE)
    names = list(known) if "all" in numbers else []
    names += [name for name in dict.fromkeys(numbers) if name not in {*names, "all"}]
    failures = [
        _computed_figure(_planned(name), output, workers, progress=not no_progress)
        for name in names
    ]
    if any(failures):
        raise typer.Exit(Exit.FAILED_POINTS)


def _axis_option(*flags: str, does: str) -> Any:
    return typer.Option(*flags, metavar="AXIS", help=does)


def _limits_option(does: str) -> Any:
    return typer.Option(metavar="LOW:HIGH", help=f"{does}, in the unit shown.")


def plot(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep or a trajectory.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Picture, .png, .pdf or .svg. [default: PNG and PDF]"),
    ] = None,
    figure: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A figure by name. [default: that of the config]"),
    ] = None,
    variable: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="A variable; may be repeated. [default: both amplitudes]"
        ),
    ] = None,
    x: Annotated[str | None, _axis_option("-x", does="Horizontal axis, by name or symbol.")] = None,
    y: Annotated[str | None, _axis_option("-y", does="Vertical axis, for a map.")] = None,
    hue: Annotated[str | None, _axis_option("--hue", does="Axis with a curve per value.")] = None,
    row: Annotated[str | None, _axis_option("--row", does="Axis with a row per value.")] = None,
    col: Annotated[str | None, _axis_option("--col", does="Axis with a column per value.")] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="Only the nearest point of an axis; SI units."),
    ] = None,
    log: Annotated[
        str, typer.Option(metavar="x,y,z", help="Logarithmic scales; z is the variable.")
    ] = "",
    boundaries: BoundariesOption = None,
    data: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Measured points over the curves, as of `fit`."),
    ] = None,
    size: Annotated[
        str, typer.Option(metavar="WxH", help="Inches of the picture, as in 3.37x2.5.")
    ] = "",
    xlim: Annotated[str, _limits_option("Ends of the horizontal axis")] = "",
    ylim: Annotated[str, _limits_option("Ends of the vertical axis")] = "",
    clim: Annotated[str, _limits_option("Ends of the colours of a map")] = "",
    letters: Annotated[bool, typer.Option("--letters", help="Name panels (a), (b), ...")] = False,
    title: Annotated[str | None, typer.Option(metavar="TEXT", help="A title above.")] = None,
    no_note: Annotated[bool, typer.Option("--no-note", help="No small print below.")] = False,
    style: Annotated[
        Path | None,
        typer.Option(metavar="FILE|NAME", help="A style of matplotlib: a file, or ggplot, ..."),
    ] = None,
) -> None:
    """Draw a picture of a result file (examples: docs/plot.md)."""
    from sweeps.engine.existing import seal_note
    from sweeps.figures import PlotOptions
    from sweeps.files.datasets import open_result
    from sweeps.measurements import read_data

    borders = None if boundaries is None else open_result(boundaries)
    options = PlotOptions(
        *(tuple(variable or ()) or None, x, y, hue, row, col, tuple(at or ()), log),
        boundaries=borders,
        data=read_data(data) if data else None,
        look=_look(
            size, (xlim, ylim, clim), letters=letters, note=not no_note, title=title, style=style
        ),
    )
    if options.asks and figure is not None:
        stop_with(
            "--figure names a whole picture: leave out options for variables and axes", Exit.USAGE
        )
    ds = open_result(file)
    if note := seal_note(file):
        say(f"warning: {note}")
    target = output or (file.with_suffix("") if file.suffix == ".nc" else file)
    _refuse_picture_name(target)
    if figure is None and not variable:
        named, variables = _plot_of_config(ds)
        figure = None if options.asks else named
        options = replace(options, variable=variables)
    _draw(ds, target, figure, options)


def _look(size: str, limits: tuple[str, str, str], **others: Any) -> Look:
    """Return the look that options mean."""
    from sweeps.figures.look import Look, range_of, size_of

    try:
        xlim, ylim, clim = (range_of(text or ":") for text in limits)
        return Look(size_of(size) if size else None, xlim, ylim, clim, **others)
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)


def _is_config(name: str) -> bool:
    return Path(name).suffix in (".yaml", ".yml")


class _Planned(NamedTuple):
    """A figure: its config, the changes to that, and the stem of its files."""

    config: Path
    changes: list[str]
    stem: str
    figure: str | None
    """None for the figure of the config."""


def _planned(name: str) -> _Planned:
    """Return the plan of the figure with this name: a number in the paper, or a config."""
    from sweeps.config.paper import PAPER, shipped_config

    if _is_config(name):
        return _Planned(Path(name), [], Path(name).stem, None)
    paper = PAPER[int(name)]
    return _Planned(shipped_config(paper.config), paper.changes, f"fig{name}", paper.figure)


def _computed_figure(plan: _Planned, folder: Path, workers: int | None, *, progress: bool) -> int:
    """Compute, write and draw one figure; return the number of failed points."""
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop
    from sweeps.figure_table import FIGURES
    from sweeps.figures import PlotOptions
    from sweeps.files.datasets import open_result

    changes = [*plan.changes, *execution_changes(workers, None, None)]
    config, path = checked_config(plan.config, changes), folder / f"{plan.stem}.nc"
    figure = plan.figure or config.plot.figure
    failures, data = 0, FIGURES[figure].data
    if data == "sweep":
        policy = ExistingPolicy(overwrite=True)
        failures = sweep_and_report(config, path, policy, Stop(), progress=progress, timing=False)
    elif data == "phases":
        _write_phases(config, path)
    else:
        _write_trajectories(config, path, progress=progress)
    ds = open_result(path)
    options = PlotOptions(None if plan.figure else _plot_of_config(ds)[1])
    _draw(ds, folder / plan.stem, None if options.asks else figure, options)
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
    """Write the trajectory of a config or, if it has an axis, one for each of its values."""
    from stickslip import IntegrationError, NoiseError
    from sweeps.engine.progress import Compiling
    from sweeps.engine.signals import interruptible
    from sweeps.engine.trajectories import pull_summary, trajectories, trajectory
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
    for line in pull_summary(ds):
        say(line)
    print(path)


def _draw(
    ds: xr.Dataset, target: Path, name: str | None, options: PlotOptions | None = None
) -> None:
    """Draw the named figure, or the one that suits the file or the options, and save it."""
    from sweeps.figures import draw, save
    from sweeps.files.atomic import storage_errors

    try:
        with storage_errors(f"cannot write {target}"):
            look = options.look if options else None
            pictures = save(draw(ds, name, options), target, look)
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)
    for picture in pictures:
        print(picture)


def _plot_of_config(ds: xr.Dataset) -> tuple[str | None, tuple[str, ...] | None]:
    """Return the figure and the variables that a file's config names and it has data for."""
    from sweeps.config.load import ConfigError, from_yaml
    from sweeps.figures import obstacle

    try:
        plot = from_yaml(str(ds.attrs.get("config", "{}"))).plot
    except ConfigError:  # a file of another version
        return None, None
    if variables := tuple(name for name in plot.variables or () if name in ds.variables):
        return None, variables
    return None if obstacle(ds, plot.figure) else plot.figure, None


def _refuse_picture_name(path: Path) -> None:
    from sweeps.figures import ENDINGS

    if path.is_dir():
        stop_with(f"{path} is a folder; -o names a picture", Exit.STORAGE)
    ending = path.suffix.lower()
    if ending[1:].isalpha() and ending not in ENDINGS:
        known = "a picture ends in .png, .pdf or .svg, or has no ending for PNG and PDF"
        stop_with(f"{path}: {known}", Exit.USAGE)
