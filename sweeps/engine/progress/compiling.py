"""A word while kernels are compiled: the first run of a version takes a minute for it."""

from __future__ import annotations

import sys
import threading
import time
from typing import Self

from sweeps.engine.progress.display import is_on_terminal
from sweeps.human import clock

_WORD = "compiling for this processor: about a minute, and kept for later runs"

# Loading what is compiled already takes less, and nothing flashes.
_MOMENT = 1.5  # seconds

_SECONDS_BETWEEN_LINES = 15.0
_FRAMES_PER_SECOND = 10.0

_GONE_SECONDS = 1.0  # a terminal that blocks is not waited for


class Compiling:
    """Says that compiling goes on, where it takes longer than a moment; a context manager.

    A spinner on a terminal, lines in a log, nothing where it is not `wanted`. `stop` takes it away
    at any time, for whoever ends the process.
    """

    def __init__(self, *, wanted: bool = True) -> None:
        self._wanted = wanted
        self._over = threading.Event()
        self._sign: threading.Thread | None = None
        self._begun = 0.0

    def __enter__(self) -> Self:
        if self._wanted:
            self._begun = time.monotonic()
            self._sign = threading.Thread(target=self._show, daemon=True)
            self._sign.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Give the terminal back, as it was before."""
        self._over.set()
        if self._sign is not None:
            self._sign.join(_GONE_SECONDS)

    def _show(self) -> None:
        if self._over.wait(_MOMENT):
            return
        if is_on_terminal():
            self._spin()
        else:
            self._keep_saying()

    def _spin(self) -> None:
        from rich.console import Console
        from rich.live import Live
        from rich.spinner import Spinner

        spinner = Spinner("line")  # of letters that every terminal has

        def turned() -> Spinner:
            spinner.update(text=f"{_WORD} ({self._elapsed()})")
            return spinner

        with Live(
            get_renderable=turned,
            console=Console(stderr=True),
            refresh_per_second=_FRAMES_PER_SECOND,
            transient=True,
        ):
            self._over.wait()

    def _keep_saying(self) -> None:
        line = _WORD
        while True:
            sys.stderr.write(f"{line}\n")
            sys.stderr.flush()
            if self._over.wait(_SECONDS_BETWEEN_LINES):
                return
            line = f"compiling, {self._elapsed()} elapsed"

    def _elapsed(self) -> str:
        return clock(time.monotonic() - self._begun)


SILENT = Compiling(wanted=False)
"""Says nothing."""
