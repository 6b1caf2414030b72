"""The verbs that pass results on: export and merge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sweeps.cli.shared import print_names, say
from sweeps.exits import Exit


def export(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep, or a trajectory.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Table, .csv or .parquet. [default: FILE as .csv]"),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing table.")
    ] = False,
) -> None:
    """Write a result as a table, for programs that do not read NetCDF.

    The table has one row per point: its coordinates, then all result variables, in the units of the
    file, with status and regime as words. Missing values are empty cells. TABLE.columns.csv, beside
    TABLE.csv, lists units, meanings and the fixed parameters.
    """
    from sweeps.engine.existing import seal_note
    from sweeps.files.atomic import fingerprint
    from sweeps.files.datasets import open_result, readable
    from sweeps.files.export import files_of, refuse_other_data, tables
    from sweeps.files.outputs import Outputs

    target = output or file.with_suffix(".csv")
    paths, request = files_of(target), {"table": fingerprint(file)}
    outputs = Outputs(paths, request, overwrite=overwrite, inputs=[file], like=file)
    with outputs.held(), open_result(file, whole=False) as ds:
        refuse_other_data(ds, file)
        if note := seal_note(file):
            say(f"warning: {note}")
        with readable(file):
            outputs.write(tables(ds, target))
    print_names(outputs)


def merge(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="The parts of the result of one config.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Result file.")],
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing output.")
    ] = False,
    partial: Annotated[
        bool, typer.Option("--partial", help="Write the result even if points are missing.")
    ] = False,
) -> None:
    """Combine the parts of a sweep into the file that a single run would have written.

    Points that occur in several files must be equal. The parts are not changed.
    """
    from sweeps.cli.output import print_summary
    from sweeps.engine.merge import merge as merge_files

    outcome = merge_files(files, output, overwrite=overwrite, partial=partial)
    print_summary(outcome)
    if outcome.complete:
        say(f"{output} is complete, nothing to do")
    if outcome.failures:
        raise typer.Exit(Exit.FAILED_POINTS)
