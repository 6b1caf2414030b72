"""The verb that writes a page about a result: report."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    BoundariesOption,
    NoProgressOption,
    OverwriteOption,
    WorkersOption,
    print_names,
    say,
    stop_with,
)
from sweeps.exits import Exit

if TYPE_CHECKING:
    from sweeps.engine.progress import Compiling

_SECONDS_BETWEEN_LINES = 5.0


def report(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="HTML file. [default: beside the result]"),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="Only the nearest point of an axis; SI units."),
    ] = None,
    orbits: Annotated[
        int, typer.Option(min=0, max=200, help="Points whose orbits are computed for the page.")
    ] = 200,
    boundaries: BoundariesOption = None,
    workers: WorkersOption = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Write a result as one HTML page that any browser opens offline.

    It has maps with a slider for each further axis, curves, orbits on a click, failures and
    provenance (docs/report.md shows one). An older page that stickslip wrote is replaced.
    """
    from sweeps.engine.existing import seal_note
    from sweeps.engine.progress import Compiling
    from sweeps.engine.signals import interruptible
    from sweeps.files.datasets import open_result
    from sweeps.files.outputs import Outputs
    from sweeps.page import is_page_of_ours, page_of, require_bokeh

    require_bokeh()
    page = output or file.with_name(file.name.removesuffix(".nc") + ".html")
    if page.suffix.lower() not in (".html", ".htm"):
        stop_with(f"{page}: a page ends in .html", Exit.USAGE)
    borders = None if boundaries is None else open_result(boundaries)
    ds = open_result(file)
    if note := seal_note(file):
        say(f"warning: {note}")
    compiling = Compiling(wanted=not no_progress)
    inputs = [file, *([boundaries] if boundaries else [])]
    outputs = Outputs([page], overwrite=overwrite, inputs=inputs, replaces=is_page_of_ours)

    def end() -> None:
        compiling.stop()
        outputs.release()

    with outputs.held(), ExitStack() as stack:
        on_orbit = _reporter(stack, compiling, wanted=not no_progress)
        content = interruptible(
            lambda: page_of(
                ds,
                name=file.name,
                at=at or (),
                orbits=orbits,
                workers=workers,
                warning=note,
                borders=borders,
                on_orbit=on_orbit,
            ),
            "Interrupted; no page was written.",
            at_once=end,
        )
        outputs.write({page: content})
    print_names(outputs)


def _reporter(
    stack: ExitStack, compiling: Compiling, *, wanted: bool
) -> Callable[[int, int], None]:
    """Return a function that reports every few seconds how many orbits are finished.

    Kernels are compiled before the first orbit.
    """
    last = time.monotonic()

    def report_orbits(done: int, total: int) -> None:
        nonlocal last
        if done == 0:
            stack.enter_context(compiling)
        elif done == 1:
            compiling.stop()
            last = time.monotonic()
        elif wanted and time.monotonic() - last > _SECONDS_BETWEEN_LINES:
            last = time.monotonic()
            say(f"orbits: {done} of {total}")

    return report_orbits
