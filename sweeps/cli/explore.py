"""The verb `explore`: a local page with a slider for every parameter."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import BoundariesOption, checked_config, say, stop_with
from sweeps.exits import Exit

if TYPE_CHECKING:
    from sweeps.page.beginning import Beginning


def explore(
    target: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE_OR_CONFIG]",
            help="Result file, whose points open on a click, or config. [default: the paper's]",
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="Only the nearest point of an axis; SI units."),
    ] = None,
    boundaries: BoundariesOption = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port on this machine; 0 for a free one.")
    ] = 0,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address without opening it.")
    ] = False,
) -> None:
    """Open a page with a slider for every parameter and the stationary orbit; Ctrl-C ends it."""
    from sweeps.page import require_bokeh
    from sweeps.page.explore import server_of

    require_bokeh()
    server = server_of(_beginning(target, at or (), boundaries), port)
    print(server.address)
    sys.stdout.flush()
    say("Press Ctrl-C to stop.")
    redirect = open_by_file(server.address) if not no_browser and has_display() else None

    def end() -> None:
        os.write(sys.stderr.fileno(), b"\n")  # the terminal has echoed ^C
        if redirect:
            shutil.rmtree(redirect.parent, ignore_errors=True)

    server.run_until_signal(end)


def _beginning(target: Path | None, at: Sequence[str], boundaries: Path | None) -> Beginning:
    """Return the initial content of the page; raises the errors of opening the files."""
    from sweeps.charts.at import slice_at
    from sweeps.engine.existing import seal_note
    from sweeps.files.datasets import open_result
    from sweeps.page import beginning
    from sweeps.points import PointError

    is_result = target is not None and target.suffix.lower() not in (".yaml", ".yml")
    if boundaries is not None and not is_result:
        stop_with("--boundaries are drawn on the map of a result file: name one", Exit.USAGE)
    if at and not is_result:
        stop_with("--at takes a slice of a result file: name one", Exit.USAGE)
    if target is None:
        return beginning.of_nothing()
    if not is_result:
        return beginning.of_config(checked_config(target, None), target.name)
    result, note = open_result(target), seal_note(target)
    borders = None if boundaries is None else open_result(boundaries)
    if note:
        say(f"warning: {note}")
    try:
        result, _ = slice_at(result, at)
    except ValueError as error:
        stop_with(str(error), Exit.USAGE)
    try:
        return beginning.of_result(result, target.name, (note,) if note else (), borders)
    except PointError as error:
        raise PointError(f"{target}: {error}") from None


def has_display() -> bool:
    """Tell whether there is a display; without one a text browser would open."""
    return sys.platform == "darwin" or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


def open_by_file(address: str) -> Path:
    """Open the page in a browser by way of a file that nobody else can read; returns it.

    The command of a browser stands in the list of processes, where the token must not. A browser
    without a window keeps its command waiting until it ends; so that is left to a thread.
    """
    import webbrowser

    redirect = Path(tempfile.mkdtemp(prefix="stickslip-explore-")) / "open.html"
    redirect.write_text(f'<meta http-equiv="refresh" content="0; url={address}">\n')
    threading.Thread(target=webbrowser.open, args=[redirect.as_uri()], daemon=True).start()
    return redirect
