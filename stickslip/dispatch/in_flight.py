"""The tasks that are being computed."""

from __future__ import annotations

import time

from stickslip.dispatch.task import Block, Task


class InFlight:
    """The tasks that workers are computing, and when each began.

    Other threads and signal handlers, which must not wait for a lock, may read this at any moment.
    Therefore every method changes or copies the table in one step.
    """

    def __init__(self) -> None:
        self._begun: dict[int, tuple[Task, float]] = {}

    def begin(self, task: Task) -> None:
        """Take note of a task that a worker gets."""
        self._begun[int(task.indices[0])] = task, time.monotonic()

    def end(self, answer: object) -> Task | None:
        """Take note of an answer, and return the task to which it seems to belong."""
        if not isinstance(answer, Block):
            return None
        try:
            task, _ = self._begun.pop(int(answer.indices[0]))
        except (TypeError, ValueError, LookupError, OverflowError):  # no number, or of no task
            return None
        return task

    def clear(self) -> list[Task]:
        """Forget all tasks, and return them."""
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
    def awaited(self) -> InFlight:
        """The tasks that a stop waits for."""
        part = InFlight()
        part._begun = {n: own for n, own in self._begun.copy().items() if not own[0].is_unlimited}
        return part
