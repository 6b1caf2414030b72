"""The verbs that make pages for a browser: explore serves one, report writes one."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweeps.cli.shared import (
    AtOption,
    BoundariesOption,
    NoProgressOption,
    OverwriteOption,
    WorkersOption,
    beside,
    checked_config,
    flag,
    is_config,
    output_option,
    print_names,
    say,
    stop_with,
    usage_errors,
    warn_of_seal,
)
from sweeps.exits import Exit

if TYPE_CHECKING:
    from sweeps.engine.progress import Compiling
    from sweeps.page.subject import Subject

_SECONDS_BETWEEN_LINES = 5.0


def explore(
    target: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE_OR_CONFIG]",
            help="Result file (click a point to open it), or a config. [default: the paper's]",
        ),
    ] = None,
    at: AtOption = None,
    boundaries: BoundariesOption = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port on this machine; 0 for a free one.")
    ] = 0,
    no_browser: Annotated[
        bool, flag("--no-browser", "Print the address without opening it.")
    ] = False,
) -> None:
    """Open a page with a slider for every parameter and the stationary orbit; Ctrl-C ends it."""
    from sweeps.page import require_bokeh
    from sweeps.page.explorer import server_of

    require_bokeh()
    server = server_of(_subject(target, at or (), boundaries), port)
    print(server.address)
    sys.stdout.flush()
    say("Press Ctrl-C to stop.")
    redirect = open_by_file(server.address) if not no_browser and has_display() else None

    def end() -> None:
        os.write(sys.stderr.fileno(), b"\n")  # the terminal has echoed ^C
        if redirect:
            shutil.rmtree(redirect.parent, ignore_errors=True)

    server.run_until_signal(end)


def _subject(target: Path | None, at: Sequence[str], boundaries: Path | None) -> Subject:
    """Return what the page shows at first; raises the errors of opening the files."""
    from sweeps.charts.choice import slice_at
    from sweeps.files.netcdf import open_result
    from sweeps.page import subject
    from sweeps.points import PointError

    if target is None or is_config(target):
        if boundaries is not None:
            stop_with("--boundaries are drawn on the map of a result file: give one", Exit.USAGE)
        if at:
            stop_with("--at takes a slice of a result file: give one", Exit.USAGE)
        if target is None:
            return subject.subject_of_paper()
        return subject.subject_of_config(checked_config(target, None), target.name)
    result = open_result(target)
    borders = None if boundaries is None else open_result(boundaries)
    note = warn_of_seal(target)
    with usage_errors():
        part, _ = slice_at(result, at)
    try:
        notes = (note,) if note else ()
        return subject.subject_of_result(part, target.name, notes, borders, at, result)
    except PointError as error:
        raise PointError(f"{target}: {error}") from None


def has_display() -> bool:
    """Return whether there is a display; without one a text browser would open."""
    return sys.platform == "darwin" or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


def open_by_file(address: str) -> Path:
    """Open the page in a browser through a file that nobody else can read; return the file.

    Everybody can read the command line of the browser in the list of processes, so it must not
    contain the token. The command of a browser without a window returns only when the browser
    ends, so a thread waits for it.
    """
    import webbrowser

    redirect = Path(tempfile.mkdtemp(prefix="stickslip-explore-")) / "open.html"
    redirect.write_text(f'<meta http-equiv="refresh" content="0; url={address}">\n')
    threading.Thread(target=webbrowser.open, args=[redirect.as_uri()], daemon=True).start()
    return redirect


def report(
    file: Annotated[Path, typer.Argument(help="Result file of a sweep.")],
    output: Annotated[Path | None, output_option("HTML file. [default: beside the result]")] = None,
    at: AtOption = None,
    orbits: Annotated[
        int,
        typer.Option(
            min=0, max=200, help="Number of points whose orbits are computed for the page."
        ),
    ] = 200,
    boundaries: BoundariesOption = None,
    workers: WorkersOption = None,
    overwrite: OverwriteOption = False,
    no_progress: NoProgressOption = False,
) -> None:
    """Write a result as one HTML page that any browser opens offline.

    The page has maps with a slider for each further axis, curves, orbits on a click, failures and
    provenance (docs/report.md shows one). It replaces an older page that stickslip wrote.
    """
    from sweeps.engine.progress import Compiling
    from sweeps.engine.signals import interruptible
    from sweeps.files.netcdf import open_result
    from sweeps.files.outputs import Outputs
    from sweeps.page import is_page_of_ours, require_bokeh
    from sweeps.page.document import page_of  # Bokeh takes long to import

    require_bokeh()
    page = output or beside(file, ".html")
    if page.suffix.lower() not in (".html", ".htm"):
        stop_with(f"{page}: the name of a page must end in .html", Exit.USAGE)
    borders = None if boundaries is None else open_result(boundaries)
    ds, note = open_result(file), warn_of_seal(file)
    compiling = Compiling(wanted=not no_progress)
    inputs = [file, *([boundaries] if boundaries else [])]
    outputs = Outputs([page], overwrite=overwrite, inputs=inputs, replaces=is_page_of_ours)
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
            compiling.stop,
            outputs.release,
            message="Interrupted; no page was written.",
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
