"""The verbs that hand results on: export and merge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sweeps.cli.shared import say, stop_with
from sweeps.exits import Exit


def export(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep, or a trajectory.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Table, .csv or .parquet; left out, FILE as .csv."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing table.")
    ] = False,
) -> None:
    """Write a result as a table, for programs that read no NetCDF.

    A row for each point: its coordinates, then all result variables, in the units of the file,
    status and regime as words; what a point lacks is an empty cell. Beside TABLE.csv stands
    TABLE.columns.csv with units, meanings and the parameters that are fixed.
    """
    from sweeps.engine.existing import seal_note
    from sweeps.files.datasets import open_result, readable
    from sweeps.files.export import export as write_table
    from sweeps.files.export import files_of, refuse_other_data

    target = output or file.with_suffix(".csv")
    for path in files_of(target):
        _refuse_table(path, file, overwrite=overwrite)
    with open_result(file, whole=False) as ds:
        refuse_other_data(ds, file)
        if note := seal_note(file):
            say(f"warning: {note}")
        with readable(file):
            for path in write_table(ds, target, file):
                print(path)


def _refuse_table(path: Path, file: Path, *, overwrite: bool) -> None:
    """End the command where a table would replace what is not to be replaced."""
    from sweeps.files.atomic import refuse_odd_output

    refuse_odd_output(path)
    if path.exists() and file.exists() and path.samefile(file):
        stop_with(f"{path} is the result itself; -o names the table", Exit.USAGE)
    if path.exists() and not overwrite:
        stop_with(
            f"{path} exists already; --overwrite replaces it, -o writes elsewhere", Exit.USAGE
        )


def merge(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Results of one config, its parts.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Result file.")],
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing output.")
    ] = False,
    partial: Annotated[
        bool, typer.Option("--partial", help="Write what there is, though points are missing.")
    ] = False,
) -> None:
    """Put the parts of a sweep together: the file that one run would have written.

    Points that several files hold must be equal; the files stay as they are.
    """
    from sweeps.cli.output import print_summary
    from sweeps.engine.merge import merge as merge_files
    from sweeps.engine.outcome import Outcome

    written = merge_files(files, output, overwrite=overwrite, partial=partial)
    outcome = Outcome(output, written.statuses, written.worst_error)
    print_summary(outcome)
    if outcome.failures:
        raise typer.Exit(Exit.FAILED_POINTS)
