"""How far a sweep is and how long the rest takes; a bar on a terminal, lines in a log."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from sweeps.engine.order.product import Costs
from sweeps.files.columns import failures
from sweeps.human import duration

_SECONDS_BETWEEN_LINES = 5.0


class Counts:
    """How far a sweep of `total` points is, by status, and how long the rest takes.

    `statuses` (128,), the journal's own, which counts along, has the points finished before.
    """

    def __init__(self, total: int, statuses: NDArray[np.int64]) -> None:
        self.total = total
        self.found = int(statuses.sum())
        self.costs = Costs()
        self._statuses = statuses
        self._expected = total
        self._begun = time.monotonic()
        self._slots: Callable[[], int] = lambda: 1

    def begin(self, slots: Callable[[], int]) -> None:
        """Start the clock, after compiling; `slots` tells how many workers there are now."""
        self._slots = slots
        if not self.computed:
            self._begun = time.monotonic()

    def expect(self, points: int) -> None:
        """Say how many points are computed next: all that are left, but where a grid is refined."""
        self._expected = self.done + points

    def fill(self, points: int) -> None:
        """Count so many points as there without having been computed."""
        self.found += points

    def lose(self, points: int) -> None:
        """Count so many finished points as not there any more."""
        self.found -= points

    @property
    def computed(self) -> int:
        """Points that this run has finished."""
        return self.costs.points

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
        return failures(self._statuses)

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
        """The time for the rest on the workers of now; None while nothing is known."""
        due = self._expected - self.done
        return self.costs.estimate(due, self._slots()) if self.computed else None

    def as_dict(self) -> dict[str, Any]:
        """The same for a heartbeat."""
        statuses, left = self._statuses.copy(), self.seconds_left
        statuses[Status.PENDING] = self.total - statuses.sum()
        return tally(statuses) | {
            "computed": self.computed,
            "seconds": round(self.seconds, 3),
            "points_per_second": round(self.rate, 3),
            "seconds_left": None if left is None else round(left, 1),
            "slots": self._slots(),
        }

    def __str__(self) -> str:
        """A line of a log."""
        left = self.seconds_left
        ahead = "" if left is None else f", about {duration(left)} left"
        done = f"{self.done}/{self.total} points, {self.failed} failed"
        return f"{done}, {self.rate:.1f} points/s{ahead}"


def tally(statuses: NDArray[np.int64]) -> dict[str, Any]:
    """How many points of which status there are, by name; `statuses` (128,) counts them."""
    named = {s.name.lower(): int(statuses[s]) for s in Status if statuses[s]}
    pending, points = named.pop("pending", 0), int(statuses.sum())
    return {
        "points": points,
        "done": points - pending,
        "failed": failures(statuses),
        "pending": pending,
        "statuses": named,
    }


class Progress:
    """Shows how far a sweep is, as a context manager; this one shows nothing."""

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Take the terminal, at first or after a question."""

    def refresh(self) -> None:
        """Something is done: show it."""

    def say(self, line: str) -> None:
        """Print a line without getting into the way of the bar."""

    def stop(self) -> None:
        """Give the terminal back: the last state stays, the cursor shows again."""


def make_progress(counts: Counts, *, wanted: bool = True) -> Progress:
    """The kind of progress that suits where the messages go (the standard error)."""
    if not wanted:
        return Progress()
    return _Bar(counts) if sys.stderr.isatty() else _Lines(counts)


class _Lines(Progress):
    """One line every few seconds, without control characters, whether something is done or not."""

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
        while not over.wait(_SECONDS_BETWEEN_LINES):
            self.say(str(self._counts))


class _Bar(Progress):
    """Rich's bar with points done, failures, rate and the time left."""

    def __init__(self, counts: Counts) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as RichProgress
        from rich.table import Column

        self._counts = counts
        self._progress = RichProgress(
            BarColumn(bar_width=None, table_column=Column(ratio=1)),
            TextColumn("{task.description}", table_column=Column(no_wrap=True)),
            console=Console(stderr=True),
            expand=True,
        )
        self._task = self._progress.add_task("", total=counts.total)
        self.refresh()

    def start(self) -> None:
        self._progress.start()

    def refresh(self) -> None:
        line = str(self._counts).replace("about ", "")  # room for the bar in 80 columns
        self._progress.update(self._task, completed=self._counts.done, description=line)

    def say(self, line: str) -> None:
        self._progress.console.print(line, highlight=False, markup=False)

    def stop(self) -> None:
        self._progress.stop()
