"""The verbs that inspect without computing: check, schema, info."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    ConfigArgument,
    OutputOption,
    SetOption,
    checked_config,
    output_of,
    say,
    stop_with,
)
from sweeps.exits import Exit

if TYPE_CHECKING:
    from sweeps.grid import Grid


def check(file: ConfigArgument, output: OutputOption = None, set_: SetOption = None) -> None:
    """Validate a config and show what a sweep of it would compute, or why it would not."""
    import numpy as np

    from sweeps.engine.resume import intention
    from sweeps.grid import Grid

    config = checked_config(file, set_)
    path = output_of(config, file, output)
    there = int(np.count_nonzero(intention(config, path).there))
    grid = Grid.from_config(config)
    axes = [f"{dim} {length}" for dim, length in zip(grid.dims, grid.shape, strict=True)]
    method = ", ".join(f"{key} {value}" for key, value in config.integrator.used().items())
    print(f"{file}: valid")
    points = f"points: {grid.size}" + (f" ({' x '.join(axes)})" if axes else "")
    print(points + (f", {there} already computed" if there else ""))
    print(f"parameters: {_described(grid)}")
    print(f"integrator: {method}")
    print(f"output: {path}")


def _described(grid: Grid) -> str:
    """Return a list of the parameters that differ from the paper's."""
    from stickslip.variables import PARAMETERS

    changed = []
    for name, variable in PARAMETERS.items():
        values = grid.values(name)
        low, high = values[0], values[-1]
        if low < high:
            changed.append(f"{variable.symbol} {low:g} to {high:g} {variable.unit}".rstrip())
        elif low != variable.default:
            changed.append(f"{variable.symbol} {low:g} {variable.unit}".rstrip())
    rest = "the others as in the paper" if changed else "as in the paper"
    return ", ".join([*changed, rest])


def schema() -> None:
    """Print the JSON Schema of a config, for editors."""
    from sweeps.config.json_schema import json_schema_text

    print(json_schema_text(), end="")


def info(
    file: Annotated[Path | None, typer.Argument(help="Result file to describe.")] = None,
    hash_: Annotated[
        bool, typer.Option("--hash", help="Print only the SHA-256 of the file's contents.")
    ] = False,
) -> None:
    """Describe the installation, or a result file."""
    from sweeps.cli.output import describe_file, describe_installation
    from sweeps.engine.existing import seal_note
    from sweeps.files.datasets import content_hash, open_result, readable

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
    if note := seal_note(file):
        say(f"warning: {note}")
