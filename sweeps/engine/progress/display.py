"""Shows how far a sweep is: a bar on a terminal, lines in a log."""

from __future__ import annotations

import os
import sys
import threading
from typing import TYPE_CHECKING, Self

from sweeps.engine.progress.counts import Counts

if TYPE_CHECKING:
    from IPython.display import HTML
    from rich.console import RenderableType
    from rich.live import Live

_SECONDS_BETWEEN_LINES = 5.0
_MOST_LINES_LEFT_OUT = 12  # where nothing is done: a line a minute

_FRAMES_PER_SECOND = 4.0  # so that elapsed seconds are not skipped


class Progress:
    """Shows how far a sweep is, as a context manager; this one shows nothing."""

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Take the terminal, at first or after a question."""

    def say(self, line: str) -> None:
        """Print a line without getting into the way of the bar."""

    def stop(self) -> None:
        """Give the terminal back: the last state stays, the cursor shows again."""


def make_progress(counts: Counts, *, wanted: bool = True) -> Progress:
    """The kind of progress that suits where the messages go (the standard error)."""
    if not wanted:
        return Progress()
    if _is_in_notebook():
        return _NotebookBar(counts)
    return _Bar(counts) if is_on_terminal() else _Lines(counts)


def _is_in_notebook() -> bool:
    """Whether an IPython kernel runs this, whose pages show HTML."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def is_on_terminal() -> bool:
    """Whether messages go to a terminal on which they can be replaced."""
    return sys.stderr.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")


class _Lines(Progress):
    """One line every few seconds, without control characters; fewer while nothing is done."""

    def __init__(self, counts: Counts) -> None:
        self._counts = counts

    def start(self) -> None:
        self._over = threading.Event()
        threading.Thread(target=self._keep_saying, args=(self._over,), daemon=True).start()

    def say(self, line: str) -> None:
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()

    def stop(self) -> None:
        self._over.set()

    def _keep_saying(self, over: threading.Event) -> None:
        done, silent, patience = self._counts.done, 0, 1
        while not over.wait(_SECONDS_BETWEEN_LINES):
            silent += 1
            if self._counts.done != done:
                done, patience = self._counts.done, 1
            elif silent < patience:
                continue
            else:
                patience = min(2 * patience, _MOST_LINES_LEFT_OUT)
            self.say(str(self._counts))
            silent = 0


class _Bar(Progress):
    """A bar with the counts, and a line with what is ahead; it draws itself anew all the time."""

    def __init__(self, counts: Counts) -> None:
        from rich.console import Console

        self._counts, self._console = counts, Console(stderr=True)
        self._live = self._new_live()

    def start(self) -> None:
        self._live = self._new_live()  # an old one would erase what was said since
        self._live.start(refresh=True)

    def say(self, line: str) -> None:
        self._console.print(line, highlight=False, markup=False)

    def stop(self) -> None:
        self._live.stop()

    def _new_live(self) -> Live:
        from rich.live import Live

        return Live(
            get_renderable=self._picture,
            console=self._console,
            refresh_per_second=_FRAMES_PER_SECOND,
        )

    def _picture(self) -> RenderableType:
        from rich.console import Group
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        counts = self._counts
        first = Table.grid(padding=(0, 1), expand=True)
        first.add_column(ratio=1)
        first.add_column(no_wrap=True)
        first.add_row(ProgressBar(counts.goal, counts.done), Text(counts.so_far))
        # Room for all of it in 80 columns.
        return Group(first, Text(counts.outlook.replace("about ", "")))


class _NotebookBar(Progress):
    """A bar with the counts, under the cell of a notebook."""

    def __init__(self, counts: Counts) -> None:
        self._counts = counts

    def start(self) -> None:
        from IPython.display import display

        self._over = threading.Event()
        self._shown = display(self._picture(), display_id=True)
        # A daemon: the interpreter may end before the sweep does.
        self._painter = threading.Thread(target=self._keep_drawing, daemon=True)
        self._painter.start()

    def say(self, line: str) -> None:
        sys.stderr.write(f"{line}\n")

    def stop(self) -> None:
        self._over.set()
        self._painter.join()
        self._shown.update(self._picture())

    def _keep_drawing(self) -> None:
        while not self._over.wait(1.0 / _FRAMES_PER_SECOND):
            self._shown.update(self._picture())

    def _picture(self) -> HTML:
        from IPython.display import HTML

        counts = self._counts
        bar = f'<progress value="{counts.done}" max="{counts.goal}" style="width: 20em"></progress>'
        return HTML(f"{bar} {counts.so_far}<br>{counts.outlook}")
