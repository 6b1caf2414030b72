"""The verb that computes the borders between kinds of motion: boundary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import NoProgressOption, WorkersOption, print_names, say, stop_with
from sweeps.exits import Exit
from sweeps.human import counted

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.files.outputs import Outputs


def boundary(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep over one axis or two.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File, .nc, .csv or .parquet. [default: FILE with -boundaries, .nc]",
        ),
    ] = None,
    accuracy: Annotated[
        float, typer.Option(help="Width of the last bracket, as a part of the axis.")
    ] = 1e-6,
    kind: Annotated[
        str,
        typer.Option(
            metavar="regime|orbit", help="What changes: the regime, or the counts as well."
        ),
    ] = "regime",
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="The nearest point of a further axis; SI units."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing output.")
    ] = False,
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute the borders between kinds of motion, as lines or points.

    Each edge between neighbouring points of unlike kinds is bisected, at slow motions only to a
    thousandth of the axis. The lines are written as NetCDF, which `stickslip plot MAP --boundaries
    FILE` draws, or as a table.
    """
    from sweeps.borders import BoundaryError, boundaries
    from sweeps.engine.existing import seal_note
    from sweeps.engine.signals import interruptible
    from sweeps.files.datasets import content_hash, open_result
    from sweeps.files.export import files_of
    from sweeps.files.outputs import Outputs
    from sweeps.points import version_differences

    target = output or file.with_name(f"{file.stem}-boundaries.nc")
    paths = [target] if target.suffix == ".nc" else files_of(target)
    ds = _at(open_result(file), at or [])
    if note := seal_note(file):
        say(f"warning: {note}")
    for note in version_differences(ds.attrs):
        say(f"note: {note}")
    request = {"map": content_hash(ds), "accuracy": accuracy, "kind": kind}
    with Outputs(paths, request, overwrite=overwrite, inputs=[file], like=file).held() as outputs:
        borders = outputs.recalled()
        if borders is None and not outputs.finished:
            borders = interruptible(
                lambda: boundaries(ds, accuracy, kind, workers=workers, progress=not no_progress),  # type: ignore[arg-type] # it is checked there
                "Interrupted; nothing was kept.",
                at_once=outputs.release,
            )
        if borders is not None and not borders.sizes["boundary_point"]:
            raise BoundaryError(f"{file} has no borders: all points with a result are of one kind")
        if borders is not None:
            _write(borders, outputs)
    print_names(outputs)
    if borders is not None:
        _summarise(borders)
        if (wide := int(borders.attrs.get("wide_brackets", 0))) > 0:
            brackets = counted(wide, "bracket")
            print(f"{brackets} wider than asked, at motions that close late, or never")


def _at(ds: xr.Dataset, at: list[str]) -> xr.Dataset:
    """Return the part of a result that some texts choose, such as `K=1000`."""
    from sweeps.charts.at import places_at

    try:
        return ds.isel(places_at(ds, at))
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)


def _write(borders: xr.Dataset, outputs: Outputs) -> None:
    from sweeps.files.export import tables

    is_table = outputs.main.suffix != ".nc"
    outputs.write(
        tables(borders, outputs.main) if is_table else {outputs.main: outputs.dataset(borders)}
    )


def _summarise(borders: xr.Dataset) -> None:
    """Print the borders of one axis; of a map how many lines there are between each two kinds."""
    from stickslip.variables import PARAMETERS

    axes = [name for name in PARAMETERS if f"{name}_bracket" in borders.variables]
    sides = list(zip(borders.kind_left.values, borders.kind_right.values, strict=True))
    is_fold = borders.type.values == 1
    if len(axes) == 1:
        for place, pair, fold in zip(borders[axes[0]].values, sides, is_fold, strict=True):
            value = f"{place:.8g} {PARAMETERS[axes[0]].unit}".rstrip()
            print(f"{axes[0]} {value}: {_between(*pair)}, {'fold' if fold else 'grazing'}")
        return
    for pair in dict.fromkeys(sides):
        own = [other == pair for other in sides]
        lines = len(set(borders.line.values[own]))
        folds = int(is_fold[own].sum())
        size = f"{counted(lines, 'line')}, {counted(sum(own), 'point')}"
        print(f"{_between(*pair)}: {size}, {folds} of them at folds")


def _between(left: int, right: int) -> str:
    from stickslip.regime import Regime

    return f"{Regime(left).name.lower()} | {Regime(right).name.lower()}"
