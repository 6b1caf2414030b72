"""Progress of a sweep: a bar on a terminal, a plain line every few seconds in a log."""

from __future__ import annotations

import sys
import threading
import time
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status

_SECONDS_BETWEEN_LINES = 5.0


class Tally:
    """How far a sweep is: points found and computed, by status, and how fast that goes."""

    def __init__(self, total: int, statuses: NDArray[np.int64]) -> None:
        self.total = total
        self.found = int(statuses.sum())
        self.computed = 0
        self._statuses = statuses  # the journal's own: it counts along
        self._begun = time.monotonic()

    def begin(self) -> None:
        """Compiling is over: the clock of the rate starts."""
        self._begun = time.monotonic()

    def advance(self, points: int) -> None:
        """Take in that so many more points are done."""
        self.computed += points

    @property
    def done(self) -> int:
        """Points that are finished, by this run or before."""
        return self.found + self.computed

    @property
    def left(self) -> int:
        """Points that are not finished."""
        return self.total - self.done

    @property
    def failed(self) -> int:
        """Finished points that are not ok."""
        return int(self._statuses[1:].sum())

    @property
    def seconds(self) -> float:
        """Since this run began to compute."""
        return time.monotonic() - self._begun

    @property
    def rate(self) -> float:
        """Points a second, of this run."""
        return self.computed / max(self.seconds, 1e-9)

    @property
    def seconds_left(self) -> float | None:
        """The time for the rest at this rate; None while nothing is known."""
        return self.left / self.rate if self.computed else None

    def as_dict(self) -> dict[str, Any]:
        """The same for a heartbeat."""
        named = {s.name.lower(): int(self._statuses[s]) for s in Status if s != Status.PENDING}
        left = self.seconds_left
        return {
            "points": self.total,
            "done": self.done,
            "failed": self.failed,
            "pending": self.left,
            "computed": self.computed,
            "statuses": {name: count for name, count in named.items() if count},
            "seconds": round(self.seconds, 3),
            "points_per_second": round(self.rate, 3),
            "seconds_left": None if left is None else round(left, 1),
        }

    def __str__(self) -> str:
        """A line of a log."""
        left = self.seconds_left
        ahead = "" if left is None else f", about {duration(left)} left"
        done = f"{self.done}/{self.total} points, {self.failed} failed"
        return f"{done}, {self.rate:.1f} points/s{ahead}"


class Progress(Protocol):
    """What shows how far a sweep is; used as a context manager."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None: ...

    def refresh(self) -> None:
        """Something is done: show it."""

    def say(self, line: str) -> None:
        """Print a line without getting into the way of the bar."""

    def pause(self) -> None:
        """Leave the terminal to a question."""

    def resume(self) -> None:
        """Take the terminal back."""

    def stop(self) -> None:
        """Give the terminal back for good: the last state stays, the cursor shows again."""


def make_progress(tally: Tally, *, wanted: bool = True) -> Progress:
    """The kind of progress that suits where the messages go (the standard error)."""
    if not wanted:
        return _Silent()
    return _Bar(tally) if sys.stderr.isatty() else _Lines(tally)


class _Silent:
    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def refresh(self) -> None: ...

    def say(self, line: str) -> None: ...

    def pause(self) -> None: ...

    def resume(self) -> None: ...

    def stop(self) -> None: ...


class _Lines(_Silent):
    """One line every few seconds, without control characters, whether something is done or not."""

    def __init__(self, tally: Tally) -> None:
        self._tally = tally
        self._over = threading.Event()
        self._clock = threading.Thread(target=self._keep_saying, daemon=True)

    def __enter__(self) -> Self:
        self._clock.start()
        return self

    def say(self, line: str) -> None:
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()

    def stop(self) -> None:
        self._over.set()

    def _keep_saying(self) -> None:
        while not self._over.wait(_SECONDS_BETWEEN_LINES):
            self.say(str(self._tally))


class _Bar(_Silent):
    """Rich's bar with points done, failures, rate and the time left."""

    def __init__(self, tally: Tally) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as RichProgress
        from rich.table import Column

        self._tally = tally
        self._progress = RichProgress(
            BarColumn(bar_width=None, table_column=Column(ratio=1)),
            TextColumn(
                "{task.completed}/{task.total} points, {task.fields[failed]} failed, "
                "{task.fields[rate]}{task.fields[left]}",
                table_column=Column(no_wrap=True),
            ),
            console=Console(stderr=True),
            expand=True,
        )
        self._task = self._progress.add_task(
            "points", total=tally.total, completed=tally.done, failed=tally.failed, rate="", left=""
        )

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def refresh(self) -> None:
        tally, left = self._tally, self._tally.seconds_left
        self._progress.update(
            self._task,
            completed=tally.done,
            failed=tally.failed,
            rate=f"{tally.rate:.1f} points/s",
            left="" if left is None else f", {duration(left)} left",
        )

    def say(self, line: str) -> None:
        self._progress.console.print(line, highlight=False, markup=False)

    def pause(self) -> None:
        self._progress.stop()

    def resume(self) -> None:
        self._progress.start()

    def stop(self) -> None:
        self._progress.stop()


def duration(seconds: float) -> str:
    """A duration as people say it: `8.4 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds < 59.95:  # what is said is rounded
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
