"""The blocks that were handed to workers and have not come back."""

from __future__ import annotations

import time

from sweeps.engine.executors.worker import Task
from sweeps.human import clock

_SOON = 5.0  # seconds in flight that are not worth a word


class InFlight:
    """The tasks in flight, and since when each of them is.

    Other threads and signal handlers, which must not wait for a lock, look at it at any moment:
    every method changes or copies the table in one step.
    """

    def __init__(self) -> None:
        self._begun: dict[int, tuple[Task, float]] = {}
        self._heard = time.monotonic()

    def begin(self, task: Task) -> None:
        """Take note of a task that is handed out."""
        self._begun[int(task.indices[0])] = task, time.monotonic()

    def end(self, first_point: int) -> Task | None:
        """The task that begins with this point, which has come back; None where there is none."""
        task, _ = self._begun.pop(first_point, (None, 0.0))
        self._heard = time.monotonic()
        return task

    def clear(self) -> list[Task]:
        """All tasks in flight, which are forgotten here."""
        begun, self._begun = self._begun, {}
        return [task for task, _ in begun.values()]

    @property
    def tasks(self) -> list[Task]:
        """The tasks in flight."""
        return [task for task, _ in list(self._begun.values())]

    @property
    def ages(self) -> list[tuple[int, float]]:
        """The points of each task and its seconds in flight, the oldest task first."""
        now = time.monotonic()
        return [(len(task.indices), now - begun) for task, begun in list(self._begun.values())]

    @property
    def points(self) -> int:
        """The number of points in flight."""
        return sum(points for points, _ in self.ages)

    @property
    def silence(self) -> float:
        """Seconds since a task came back."""
        return time.monotonic() - self._heard

    def __str__(self) -> str:
        """`512 points in flight, the oldest for 1:03`; nothing where none is."""
        ages = self.ages
        if not ages:
            return ""
        count, oldest = sum(points for points, _ in ages), ages[0][1]
        points = "1 point" if count == 1 else f"{count} points"
        waited = f", the oldest for {clock(oldest)}" if oldest >= _SOON else ""
        return f"{points} in flight{waited}"
