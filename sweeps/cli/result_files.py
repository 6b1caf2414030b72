"""The verbs that take a result file: boundary, export, info, cite."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sweeps.cli.shared import (
    NoProgressOption,
    OverwriteOption,
    WorkersOption,
    beside,
    flag,
    option,
    output_option,
    print_names,
    recalled_or_computed,
    say,
    stop_with,
    usage_errors,
    warn_of_seal,
)
from sweeps.exits import Exit


def boundary(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep over one axis or two.")],
    output: Annotated[
        Path | None,
        output_option("Output, .nc, .csv or .parquet. [default: FILE-boundaries.nc]"),
    ] = None,
    accuracy: Annotated[
        float, typer.Option(help="Width of the last bracket, as a fraction of the axis.")
    ] = 1e-6,
    kind: Annotated[
        str,
        option("regime|orbit", "What changes at a border: the regime alone, or the counts too."),
    ] = "regime",
    at: Annotated[
        list[str] | None,
        option("KEY=VALUE", "Point nearest to this value on a further axis; SI units."),
    ] = None,
    overwrite: OverwriteOption = False,
    workers: WorkersOption = None,
    no_progress: NoProgressOption = False,
) -> None:
    """Compute the borders between kinds of motion, as lines or points.

    The command bisects each edge between neighbouring points of different kinds, near slow motions
    only to a thousandth of the axis. It writes the lines as a table, or as NetCDF, which `stickslip
    plot MAP --boundaries FILE` draws.
    """
    from sweeps.borders import BoundaryError, boundaries
    from sweeps.charts.choice import places_at
    from sweeps.cli.summaries import print_borders
    from sweeps.files.export import files_of, tables
    from sweeps.files.netcdf import content_hash, open_result
    from sweeps.files.outputs import Outputs
    from sweeps.points import version_differences

    target = output or beside(file, "-boundaries.nc")
    is_table = target.suffix != ".nc"
    paths = files_of(target) if is_table else [target]
    ds = open_result(file)
    with usage_errors():
        ds = ds.isel(places_at(ds, at or []))
    warn_of_seal(file)
    for note in version_differences(ds.attrs):
        say(f"note: {note}")
    request = {"map": content_hash(ds), "accuracy": accuracy, "kind": kind}
    with Outputs(paths, request, overwrite=overwrite, inputs=[file], like=file).held() as outputs:
        borders = None
        if not (is_table and outputs.finished):  # a finished table is not computed again
            borders = recalled_or_computed(
                outputs,
                lambda: boundaries(ds, accuracy, kind, workers=workers, progress=not no_progress),  # type: ignore[arg-type] # it is checked there
            )
            if not borders.sizes["boundary_point"]:
                raise BoundaryError(
                    f"{file} has no borders: all points with a result are of one kind"
                )
            outputs.write(
                tables(borders, target) if is_table else {target: outputs.dataset(borders)}
            )
    print_names(outputs)
    if borders is not None:
        print_borders(borders)


def export(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep, or a trajectory.")],
    output: Annotated[
        Path | None, output_option("Table, .csv or .parquet. [default: FILE as .csv]")
    ] = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Write a result as a table, for programs that do not read NetCDF.

    The table has one row per point: its coordinates, then all result variables, in the units of the
    file, with status and regime as words. Missing values are empty cells. A second table beside
    TABLE.csv, TABLE.columns.csv, lists units, meanings and the fixed parameters.
    """
    from sweeps.files.atomic import fingerprint
    from sweeps.files.export import files_of, refuse_other_data, tables
    from sweeps.files.netcdf import open_result, readable
    from sweeps.files.outputs import Outputs

    target = output or beside(file, ".csv")
    paths, request = files_of(target), {"table": fingerprint(file)}
    outputs = Outputs(paths, request, overwrite=overwrite, inputs=[file], like=file)
    with outputs.held(), open_result(file, whole=False) as ds:
        refuse_other_data(ds, file)
        warn_of_seal(file)
        with readable(file):
            outputs.write(tables(ds, target))
    print_names(outputs)


def info(
    file: Annotated[Path | None, typer.Argument(help="Result file to describe.")] = None,
    hash_: Annotated[
        bool, flag("--hash", "Print only the SHA-256 of the file's contents.")
    ] = False,
) -> None:
    """Describe the installation, or a result file."""
    from sweeps.cli.summaries import describe_file, describe_installation
    from sweeps.files.netcdf import content_hash, open_result, readable

    if file is None:
        if hash_:
            stop_with("--hash needs a FILE", Exit.USAGE)
        describe_installation()
        return
    with readable(file), open_result(file, whole=False) as ds:
        if hash_:
            print(content_hash(ds))
        else:
            describe_file(ds)
    warn_of_seal(file)


def cite(
    file: Annotated[
        Path | None, typer.Argument(help="Cite the methods used for this file.")
    ] = None,
) -> None:
    """Print BibTeX entries of the program and the paper, and of the methods that a file used."""
    from sweeps.citations import bibtex

    if file is None:
        print(bibtex())
        return
    from sweeps.charts.choice import data_of
    from sweeps.files.netcdf import open_result, readable

    with readable(file), open_result(file, whole=False) as ds:
        print(bibtex(ds.attrs, data_of(ds)))
