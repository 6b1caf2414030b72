"""The verb `explore`: a local page with a slider for every parameter."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import threading
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import BoundariesOption, checked_config, say, stop_with
from sweeps.exits import Exit

if TYPE_CHECKING:
    from sweeps.views.explore.beginning import Beginning


def explore(
    target: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE_OR_CONFIG]",
            help="Result file, whose points open on a click, or config. [default: the paper's]",
        ),
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
    from sweeps.views import charts

    if missing := charts.bokeh_is_missing():
        stop_with(missing, Exit.USAGE)
    from sweeps.views.explore.page import Page
    from sweeps.views.explore.serving import PageServer

    beginning = _beginning(target)
    if boundaries is not None:
        beginning = _with_borders(beginning, boundaries)
    server = PageServer(lambda document: Page(beginning).open_in(document), port)
    print(server.address)
    sys.stdout.flush()
    say("Press Ctrl-C to stop.")
    redirect = open_by_file(server.address) if not no_browser and has_display() else None

    def end() -> None:
        os.write(sys.stderr.fileno(), b"\n")  # the terminal has echoed ^C
        if redirect:
            shutil.rmtree(redirect.parent, ignore_errors=True)

    server.run_until_signal(end)


def _beginning(target: Path | None) -> Beginning:
    """Return the initial content of the page; raises the errors of opening the file."""
    from sweeps.engine.existing import seal_note
    from sweeps.files.datasets import open_result
    from sweeps.points import PointError
    from sweeps.views.explore import beginning

    if target is None:
        return beginning.of_nothing()
    if target.suffix.lower() in (".yaml", ".yml"):
        return beginning.of_config(checked_config(target, None), target.name)
    result, note = open_result(target), seal_note(target)
    if note:
        say(f"warning: {note}")
    try:
        return beginning.of_result(result, target.name, (note,) if note else ())
    except PointError as error:
        raise PointError(f"{target}: {error}") from None


def _with_borders(beginning: Beginning, file: Path) -> Beginning:
    """Return the beginning with the borders of a file; ends if they are not of its result."""
    from stickslip.symbols import plain
    from sweeps.charts.borders import require_borders_of
    from sweeps.files.datasets import open_result

    if beginning.result is None:
        stop_with("--boundaries are drawn on the map of a result file: name one", Exit.USAGE)
    borders = open_result(file)
    try:
        require_borders_of(beginning.result, borders)
    except ValueError as error:
        stop_with(f"{file}: {plain(str(error))}", Exit.USAGE)
    return replace(beginning, borders=borders)


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
