"""The verb that turns measurements into parameters: fit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    NoProgressOption,
    SetOption,
    WorkersOption,
    checked_config,
    say,
    stop_with,
)
from sweeps.exits import Exit

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.fitting.parameters import Range


def fit(
    data: Annotated[
        Path,
        typer.Argument(
            metavar="DATA.csv",
            help="Columns are parameters, measured variables and their errors, NAME_error; SI.",
        ),
    ],
    free: Annotated[
        str,
        typer.Option(metavar="NAME[=LOW:HIGH],...", help="What is fitted, such as k,gamma=-0.9:0."),
    ],
    config: Annotated[
        Path | None,
        typer.Argument(
            metavar="[CONFIG]",
            help="All other parameters, and the start. [default: the paper's Fig. 3]",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="NetCDF file. [default: results/DATA-fit.nc]"),
    ] = None,
    set_: SetOption = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="Also intervals by the profile likelihood; slower.")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")] = False,
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Fit parameters to measurements, and draw data, fitted curve and residuals.

    Without errors of the data residuals are relative, with a common unknown factor. Beside the
    NetCDF file the picture is written, and the config that computes the fitted curve.
    """
    from sweeps.engine.signals import interruptible
    from sweeps.files.datasets import require_writable
    from sweeps.fitting.fitting import fit as fitted
    from sweeps.fitting.fitting import summary_of

    target = output or Path("results") / f"{data.stem}-fit.nc"
    _refuse_files(target, [data, config], overwrite=overwrite)
    settled = checked_config(config, set_)
    require_writable(target)
    ranges, show = _ranges(free), not no_progress
    ds = interruptible(
        lambda: fitted(data, ranges, settled, profile=profile, workers=workers, progress=show),
        "Interrupted; nothing was kept.",
    )
    print(summary_of(ds))
    _write(ds, target)


def _refuse_files(target: Path, sources: list[Path | None], *, overwrite: bool) -> None:
    """End the command if the output is no NetCDF file, or one that must not be replaced."""
    from sweeps.files.atomic import refuse_odd_output

    if target.suffix != ".nc":
        stop_with(f"{target}: -o names a NetCDF file, which ends in .nc", Exit.USAGE)
    for path in (target, target.with_suffix(".yaml")):
        refuse_odd_output(path)
        if any(source and path.exists() and path.samefile(source) for source in sources):
            stop_with(f"{path} is an input itself; -o names another file", Exit.USAGE)
        if path.exists() and not overwrite:
            stop_with(
                f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE
            )


def _ranges(free: str) -> dict[str, Range]:
    """Return the free parameters of an option, with their ranges."""
    ranges: dict[str, Range] = {}
    for word in free.split(","):
        name, equals, limits = (part.strip() for part in word.partition("="))
        if name in ranges:
            stop_with(f"--free: {name} is there twice", Exit.USAGE)
        low, _, high = limits.partition(":")
        try:
            ranges[name] = (float(low), float(high)) if equals else None
        except ValueError:
            stop_with(f"--free: a range is {name}=LOW:HIGH, not {word}", Exit.USAGE)
    return ranges


def _write(ds: xr.Dataset, target: Path) -> None:
    """Write the file, the config of the fitted curve, and the picture; print their names."""
    from sweeps.config.yaml_writer import block_yaml
    from sweeps.figures import draw, save
    from sweeps.files.atomic import replacing, storage_errors
    from sweeps.files.datasets import write_dataset

    write_dataset(ds, target)
    print(target)
    written = target.with_suffix(".yaml")
    with storage_errors(f"cannot write {written}", target.parent):
        with replacing(written) as temporary:
            curve = block_yaml({"output": f"results/{target.stem}-curve.nc"})
            temporary.write_text(f"{ds.attrs['config']}{curve}", encoding="utf-8")
        print(written)
        for picture in save(draw(ds), target.with_suffix("")):
            print(picture)
    if int((ds.parameter_determination != 0).sum()):
        say("warning: not all parameters are determined by these data")
    if lost := int(ds.fitted_value.isnull().sum()):
        say(f"warning: {lost} of {ds.sizes['datum']} data have no fitted value: no orbit was found")
        raise typer.Exit(Exit.FAILED_POINTS)
