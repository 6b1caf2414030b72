"""The verb that begins a config: new."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from sweeps.cli.shared import print_names, stop_with
from sweeps.exits import Exit


class Kind(StrEnum):
    """What a new config is for; each has a shipped file."""

    PAPER = "paper"
    LUBRICANT = "lubricant"
    MAP = "map"
    FIT = "fit"


def new(
    file: Annotated[Path, typer.Argument(help="Config to write.")],
    kind: Annotated[
        Kind,
        typer.Option(
            help="The paper's film against temperature, a lubricant of your own, a map of the "
            "kinds of motion, or the machine and the start of a fit."
        ),
    ] = Kind.PAPER,
) -> None:
    """Write a commented config to begin with."""
    from sweeps.config.paper import shipped_config
    from sweeps.files.outputs import Outputs

    if file.suffix not in (".yaml", ".yml"):
        stop_with(f"{file}: a config ends in .yaml", Exit.USAGE)
    text = shipped_config(f"new/{kind}").read_text(encoding="utf-8")
    text = text.replace("FILE", str(file)).replace("RESULT", f"results/{file.stem}")
    text = text.replace(f"results/{kind}.nc", f"results/{file.stem}.nc")
    with Outputs([file], {"config": text}, ways_out="choose another name").held() as outputs:
        outputs.write({file: text.encode()})
    print_names(outputs)
    verb = f"fit DATA.csv {file} --free k,gamma" if kind is Kind.FIT else f"sweep {file}"
    print(f"next: stickslip {verb}")
