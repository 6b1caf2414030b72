"""The verbs that compute motions and draw pictures: simulate, replay, figure, plot."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    AtOption,
    BoundariesOption,
    NoProgressOption,
    OverwriteOption,
    SetOption,
    WorkersOption,
    beside,
    checked_config,
    execution_changes,
    flag,
    is_config,
    option,
    output_option,
    print_names,
    recalled_or_computed,
    require_netcdf,
    say,
    stop_with,
    usage_errors,
    warn_of_seal,
)
from sweeps.cli.sweeps import sweep_and_report
from sweeps.exits import Exit

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.config.load import Config
    from sweeps.figures import PlotOptions
    from sweeps.files.outputs import Outputs


_DRAWN_BY = {"fit": "fit", "indices": "sensitivity"}  # the verbs that compute other data
_LONGEST_STEM = 120  # characters; a name may have 255 bytes, and pictures have longer names


def simulate(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[CONFIG]", help="YAML config. [default: the paper's Fig. 3]"),
    ] = None,
    set_: SetOption = None,
    periods: Annotated[int | None, typer.Option(min=1, help="Drive periods.")] = None,
    output: Annotated[Path | None, output_option("NetCDF file.")] = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute a trajectory, by default into results/<name of the config>-trajectory.nc.

    That name contains the changes by --set: results/paper-T=250-trajectory.nc.
    """
    from sweeps.config.overrides import Option
    from sweeps.engine.trajectories import AxisLeftError, pull_summary
    from sweeps.files.outputs import Outputs

    own = [Option(f"simulation.periods={periods}", f"--periods {periods}")] if periods else []
    changes = [*(set_ or []), *own]
    config = checked_config(file, changes)
    if periods and config.simulation.drive:
        stop_with(
            "--periods: simulation.drive pulls the upper block, and a pull has no drive periods; "
            "leave out --periods, and give the time in s with --set simulation.duration=...",
            Exit.USAGE,
        )
    path = output or trajectory_path(file, changes)
    require_netcdf(path)
    if config.sweep or config.cases:
        raise AxisLeftError(config)
    request = {"config": config.resolved_yaml()}
    with Outputs([path], request, overwrite=overwrite, inputs=[file]).held() as outputs:
        ds = _trajectories(config, outputs, progress=not no_progress)
        outputs.write({path: outputs.dataset(ds)})
    for line in pull_summary(ds):
        say(line)
    print_names(outputs)


def replay(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep.")],
    at: Annotated[
        list[str] | None, option("KEY=VALUE", "Point nearest to this value on an axis; SI units.")
    ] = None,
    output: Annotated[Path | None, output_option("NetCDF file. [default: FILE-replay.nc]")] = None,
    periods: Annotated[
        int | None, typer.Option(min=1, help="Drive periods. [default: until the orbit closes]")
    ] = None,
    start: Annotated[
        str | None, option("initial|stationary", "Where to begin. [default: on the orbit]")
    ] = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute one point of a result again, and draw its motion.

    The command compares the values with those in the file; with the same version on the same type
    of processor they agree bit for bit. It replaces an older replay of the file.
    """
    from stickslip import IntegrationError
    from sweeps.cli.summaries import print_comparison
    from sweeps.engine.progress import Compiling
    from sweeps.figures import draw
    from sweeps.figures.save import pictures_of, rendered
    from sweeps.files.netcdf import open_result, readable
    from sweeps.files.outputs import Outputs
    from sweeps.points import point_of

    if start not in (None, "initial", "stationary"):
        stop_with(f"--start must be initial or stationary, not {start}", Exit.USAGE)
    target = output or beside(file, "-replay.nc")
    require_netcdf(target, strict=True)
    with readable(file), open_result(file, whole=False) as ds:
        point = point_of(ds, at or ())
    stem = target.with_suffix("")
    outputs = Outputs(
        [target, *pictures_of(stem)], overwrite=overwrite, inputs=[file], replaces=_is_of_replay
    )
    with outputs.held():
        with Compiling(wanted=not no_progress):
            point.orbit()
        same = print_comparison(point)
        try:
            motion = point.replay(periods, start)  # type: ignore[arg-type] # checked above
        except IntegrationError as error:
            stop_with(f"the motion cannot be computed: {error}", Exit.FAILED_POINTS)
        pictures = rendered(draw(motion, "orbit"), stem)
        outputs.write({target: outputs.dataset(motion), **pictures})
    print_names(outputs)
    if not same and not point.versions:
        raise typer.Exit(Exit.FAILED_POINTS)


def _is_of_replay(path: Path) -> bool:
    """Return whether a file is a replay or its picture, which a later replay replaces."""
    from sweeps.exits import ExpectedError
    from sweeps.figures.save import is_picture_of_ours
    from sweeps.files.netcdf import open_result

    if path.suffix != ".nc":
        return is_picture_of_ours(path)
    try:
        with open_result(path, whole=False) as ds:
            # No other file has both a time course and a stroboscopic map.
            return {"elapsed_time", "period"} <= ds.sizes.keys() and "config" in ds.attrs
    except ExpectedError:  # no NetCDF file
        return False


def trajectory_path(file: Path | None, changes: list[str]) -> Path:
    """Return the default name of a trajectory, which contains the changes to the config."""
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
        Path, output_option("Folder for figN.nc, figN.png, figN.pdf and so on.")
    ] = Path("results"),
    workers: WorkersOption = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute and draw figures of the paper or of configs.

    `plot: {figure: NAME}` in a config selects its figure. Existing results are drawn again, not
    computed again.
    """
    from sweeps.config.paper import PAPER

    known = [str(number) for number in PAPER]
    others = [name for name in dict.fromkeys(numbers) if name not in {*known, "all"}]
    if unknown := [name for name in others if not is_config(Path(name))]:
        listed = f"{', '.join(known)}, all, or a config FILE.yaml"
        stop_with(f"no figure {', '.join(unknown)}; choose from {listed}", Exit.USAGE)
    names = [*known, *others] if "all" in numbers else dict.fromkeys(numbers)
    stems: dict[str, str] = {}
    for name in names:
        stem = _stem_of(name)
        if (other := stems.setdefault(stem, name)) != name:
            stop_with(
                f"{other} and {name} would both be drawn as {stem}; use a folder for each",
                Exit.USAGE,
            )
    failures = [
        _computed_figure(name, output, workers, overwrite=overwrite, progress=not no_progress)
        for name in names
    ]
    if any(failures):
        raise typer.Exit(Exit.FAILED_POINTS)


def plot(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep or a trajectory.")],
    output: Annotated[
        Path | None, output_option("Picture, .png, .pdf or .svg. [default: PNG and PDF]")
    ] = None,
    figure: Annotated[
        str | None, option("NAME", "A figure by name. [default: the one that the config names]")
    ] = None,
    variable: Annotated[
        list[str] | None, option("NAME", "A variable; may be repeated. [default: both amplitudes]")
    ] = None,
    x: Annotated[str | None, option("AXIS", "Horizontal axis, by name or symbol.", "-x")] = None,
    y: Annotated[str | None, option("AXIS", "Vertical axis, for a map.", "-y")] = None,
    hue: Annotated[str | None, option("AXIS", "Axis with a curve per value.")] = None,
    row: Annotated[str | None, option("AXIS", "Axis with a row per value.")] = None,
    col: Annotated[str | None, option("AXIS", "Axis with a column per value.")] = None,
    at: AtOption = None,
    log: Annotated[str, option("x,y,z", "Logarithmic scales; z is the variable.")] = "",
    boundaries: BoundariesOption = None,
    data: Annotated[
        Path | None, option("FILE.csv", "Measurements to draw over the curves, as for `fit`.")
    ] = None,
    size: Annotated[str, option("WxH", "Size in inches, such as 3.37x2.5.")] = "",
    xlim: Annotated[
        str, option("LOW:HIGH", "Limits of the horizontal axis, in the unit shown.")
    ] = "",
    ylim: Annotated[
        str, option("LOW:HIGH", "Limits of the vertical axis, in the unit shown.")
    ] = "",
    clim: Annotated[
        str, option("LOW:HIGH", "Limits of a map's colour scale, in the unit shown.")
    ] = "",
    letters: Annotated[bool, flag("--letters", "Label the panels (a), (b), ...")] = False,
    title: Annotated[str | None, option("TEXT", "A title above the picture.")] = None,
    no_note: Annotated[bool, flag("--no-note", "Leave out the note below the picture.")] = False,
    style: Annotated[
        Path | None, option("FILE|NAME", "A matplotlib style: a file or a name such as ggplot.")
    ] = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Draw a picture of a result file (examples: docs/plot.md).

    The picture replaces an older one that stickslip drew.
    """
    from sweeps.figures import PlotOptions
    from sweeps.figures.look import Look, range_of, size_of
    from sweeps.files.netcdf import open_result
    from sweeps.measurements import read_data

    borders = None if boundaries is None else open_result(boundaries)
    with usage_errors():
        along, up, coloured = (range_of(text or ":") for text in (xlim, ylim, clim))
        inches = size_of(size) if size else None
        look = Look(inches, along, up, coloured, letters, not no_note, title, style)
    options = PlotOptions(
        *(tuple(variable or ()) or None, x, y, hue, row, col, tuple(at or ()), log),
        boundaries=borders,
        data=read_data(data) if data else None,
        look=look,
    )
    if options.asks and figure is not None:
        stop_with(
            "--figure draws a whole picture: leave out options for variables and axes", Exit.USAGE
        )
    ds = open_result(file)
    warn_of_seal(file)
    if output:
        _refuse_picture_name(output)
    target = output or beside(file, "")
    if figure is None and not variable:
        named, variables = _plot_of_config(ds)
        figure = None if options.asks else named
        if figure is None:
            options = replace(options, variable=variables)
    inputs = [file, *(each for each in (boundaries, data, style) if each)]
    with _pictures(target, overwrite=overwrite, inputs=inputs).held() as outputs:
        outputs.write(_drawn(ds, target, figure, options))
    print_names(outputs)


def _stem_of(name: str) -> str:
    """Return the name of the files of a figure of the paper, or of a config."""
    return Path(name).stem if is_config(Path(name)) else f"fig{name}"


def _computed_figure(
    name: str, folder: Path, workers: int | None, *, overwrite: bool, progress: bool
) -> int:
    """Compute, write and draw a figure of the paper or a config; return how many points failed."""
    from sweeps.config.paper import PAPER, shipped_config
    from sweeps.figure_table import FIGURES
    from sweeps.figures import PlotOptions

    source, stem, changes, of_paper = Path(name), _stem_of(name), execution_changes(workers), None
    if not is_config(source):
        paper = PAPER[int(name)]
        source, of_paper = shipped_config(paper.config), paper.figure
        changes = [*paper.changes, *changes]
    config = checked_config(source, changes)
    target, figure = folder / stem, of_paper or config.plot.figure
    if verb := _DRAWN_BY.get(FIGURES[figure].data):
        stop_with(
            f"the figure {figure} shows {FIGURES[figure].drawn}: `stickslip {verb}` computes and "
            "draws it",
            Exit.USAGE,
        )

    def pictures(ds: xr.Dataset) -> dict[Path, bytes]:
        named, variables = (of_paper, None) if of_paper else _plot_of_config(ds)
        return _drawn(ds, target, named, PlotOptions(None if named else variables))

    path, data = folder / f"{stem}.nc", FIGURES[figure].data
    if data == "sweep":
        return _swept_figure(config, path, target, pictures, overwrite=overwrite, progress=progress)
    request = {"config": config.resolved_yaml()}
    outputs = _pictures(target, path, request, overwrite=overwrite)
    with outputs.held():
        is_phases = data == "phases"
        ds = _phases(config) if is_phases else _trajectories(config, outputs, progress=progress)
        outputs.write({path: outputs.dataset(ds), **pictures(ds)})
    print_names(outputs)
    return 0


def _swept_figure(
    config: Config,
    path: Path,
    target: Path,
    pictures: Callable[[xr.Dataset], dict[Path, bytes]],
    *,
    overwrite: bool,
    progress: bool,
) -> int:
    """Run the sweep of a figure, which writes its own files, and draw the figure."""
    from sweeps.engine.resume import ExistingPolicy
    from sweeps.engine.signals import Stop
    from sweeps.files.netcdf import open_result

    outputs = _pictures(target, overwrite=overwrite)
    with outputs.held():
        pass  # pictures that must not be replaced are refused before the sweep
    policy = ExistingPolicy(overwrite=overwrite)
    failures = sweep_and_report(config, path, policy, Stop(), progress=progress, timing=False)
    with outputs.held():
        outputs.write(pictures(open_result(path)))
    print_names(outputs)
    return failures


def _phases(config: Config) -> xr.Dataset:
    """Return the free energy and the phases at the temperatures of a config's only axis."""
    from stickslip.phases import PAPER_STRAIN, phase_diagram
    from sweeps.files.attributes import add_provenance

    if [*config.sweep, *config.cases] != ["temperature"]:
        stop_with(
            f"the figure {config.plot.figure} needs `sweep: {{temperature: [...]}}`, and no other "
            "axis",
            Exit.USAGE,
        )
    strain = config.plot.elastic_strain
    diagram = phase_diagram(
        config.parameters(),
        temperatures=config.sweep["temperature"],
        strain=PAPER_STRAIN if strain is None else strain,
    )
    summary = "Free energy of a boundary lubricant film, and where it melts and solidifies"
    return add_provenance(diagram, config, config.title or "Phases of a film", summary)


def _trajectories(config: Config, outputs: Outputs, *, progress: bool) -> xr.Dataset:
    """Return the trajectory of a config or, if it has an axis, one for each of its values.

    It is read if its file holds it already.
    """
    from stickslip import IntegrationError, NoiseError
    from sweeps.engine.progress import Compiling
    from sweeps.engine.trajectories import trajectories, trajectory

    compute = trajectories if config.sweep or config.cases else trajectory
    compiling = Compiling(wanted=progress)
    try:
        return recalled_or_computed(outputs, lambda: compute(config, compiling), compiling.stop)
    except NoiseError as error:
        stop_with(str(error), Exit.USAGE)
    except IntegrationError as error:
        stop_with(str(error), Exit.FAILED_POINTS)


def _pictures(
    target: Path,
    data: Path | None = None,
    request: dict[str, str] | None = None,
    *,
    overwrite: bool,
    inputs: Sequence[Path] = (),
) -> Outputs:
    """Return the files of a picture and, if they are written too, of the data that it shows."""
    from sweeps.figures.save import is_picture_of_ours, pictures_of
    from sweeps.files.outputs import Outputs

    paths = [*([data] if data else []), *pictures_of(target)]
    return Outputs(paths, request, overwrite=overwrite, inputs=inputs, replaces=is_picture_of_ours)


def _drawn(
    ds: xr.Dataset, target: Path, name: str | None, options: PlotOptions | None = None
) -> dict[Path, bytes]:
    """Return the pictures of the named figure, else of one that suits the file and the options."""
    from sweeps.figures import draw
    from sweeps.figures.save import rendered

    with usage_errors():
        return rendered(draw(ds, name, options), target, options.look if options else None)


def _plot_of_config(ds: xr.Dataset) -> tuple[str | None, tuple[str, ...] | None]:
    """Return the figure and the variables that a file's config names, if the file has the data.

    Only a sweep has variables. If named, they replace the default figure, which is then None.
    """
    from sweeps.charts.choice import data_of, default_figure, obstacle
    from sweeps.config.load import ConfigError, from_yaml

    try:
        plot = from_yaml(str(ds.attrs.get("config", "{}"))).plot
    except ConfigError:  # a file of another version
        return None, None
    is_sweep = data_of(ds) == "sweep"
    variables = tuple(name for name in plot.variables or () if is_sweep and name in ds.variables)
    replaced = variables and plot.figure == default_figure(ds)
    return None if replaced or obstacle(ds, plot.figure) else plot.figure, variables or None


def _refuse_picture_name(path: Path) -> None:
    from sweeps.figures import ENDINGS

    if path.is_dir():
        stop_with(f"{path} is a folder; -o names a picture", Exit.STORAGE)
    ending = path.suffix.lower()
    if ending[1:].isalpha() and ending not in ENDINGS:
        known = "a picture's name must end in .png, .pdf or .svg, or have no ending for PNG and PDF"
        stop_with(f"{path}: {known}", Exit.USAGE)
