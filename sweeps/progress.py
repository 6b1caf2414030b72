"""Progress of a sweep: a bar on a terminal, a plain line every few seconds in a log."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Protocol, Self

_SECONDS_BETWEEN_LINES = 5.0


class Progress(Protocol):
    """What a sweep reports to; used as a context manager."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    def advance(self, points: int, failures: int) -> None:
        """Take in that so many more points are done, and how many of them failed."""

    def stop(self) -> None:
        """Give the terminal back: the last state stays, the cursor shows again."""


def make_progress(total: int, *, wanted: bool = True) -> Progress:
    """The kind of progress that suits where the messages go (the standard error)."""
    if not wanted:
        return _Silent()
    return _Bar(total) if sys.stderr.isatty() else _Lines(total)


class _Silent:
    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None: ...

    def advance(self, points: int, failures: int) -> None: ...

    def stop(self) -> None: ...


class _Lines(_Silent):
    """One line every few seconds, without control characters."""

    def __init__(self, total: int) -> None:
        self._total, self._done, self._failed = total, 0, 0
        self._begun = self._said = time.monotonic()

    def advance(self, points: int, failures: int) -> None:
        self._done += points
        self._failed += failures
        now = time.monotonic()
        if now - self._said >= _SECONDS_BETWEEN_LINES:
            self._said = now
            rate = self._done / (now - self._begun)
            left = (self._total - self._done) / rate
            sys.stderr.write(
                f"{self._done}/{self._total} points, {self._failed} failed, "
                f"{rate:.1f} points/s, about {duration(left)} left\n"
            )
            sys.stderr.flush()


class _Bar(_Silent):
    """Rich's bar with points done, failures, rate and the time left."""

    def __init__(self, total: int) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        self._progress = RichProgress(
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("points, {task.fields[failed]} failed, {task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("left"),
            console=Console(stderr=True),
        )
        self._task = self._progress.add_task("points", total=total, failed=0, rate="")
        self._failed, self._done, self._begun = 0, 0, time.monotonic()

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        self._progress.stop()

    def advance(self, points: int, failures: int) -> None:
        self._done += points
        self._failed += failures
        rate = self._done / max(time.monotonic() - self._begun, 1e-9)
        self._progress.update(
            self._task, advance=points, failed=self._failed, rate=f"{rate:.1f} points/s"
        )


def duration(seconds: float) -> str:
    """A duration as people say it: `8.4 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
