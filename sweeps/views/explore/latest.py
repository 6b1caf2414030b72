"""Work in threads of its own, of which only the latest counts: what waits is passed over.

Compiled code cannot be stopped. A job that takes long goes on to its end in its thread, and the
next one begins beside it; its result comes too late and is dropped.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

_MOST = 3  # jobs at once: the one that is wanted, and two that were given up
_PATIENCE = 0.5  # seconds: a job that takes longer no longer keeps the next one waiting
_PAUSE = 0.04  # seconds between results: a browser draws no faster

Job = TypeVar("Job")
Result = TypeVar("Result")


class Latest(Generic[Job, Result]):
    """Does the latest of the jobs that are submitted, and hands out results no older than before.

    `work` is called in a thread; `deliver` too, with its result, and must be quick. `work` must
    not raise.
    """

    def __init__(self, work: Callable[[Job], Result], deliver: Callable[[Result], None]) -> None:
        self._work, self._deliver = work, deliver
        self._changed = threading.Condition()
        self._pending: tuple[int, Job] | None = None
        self._submitted = self._delivered = self._begun = 0
        self._since = self._next = 0.0
        self._closed = False
        self.threads = [threading.Thread(target=self._run, daemon=True) for _ in range(_MOST)]
        for thread in self.threads:
            thread.start()

    def submit(self, job: Job) -> None:
        """Do this job next, in the place of one that waits."""
        with self._changed:
            if self._submitted == self._delivered:
                self._since = time.monotonic()
            self._submitted += 1
            self._pending = self._submitted, job
            self._changed.notify_all()

    @property
    def waiting(self) -> float | None:
        """Seconds since a result is waited for; None where the latest is there."""
        with self._changed:
            done = self._submitted == self._delivered
            return None if done else time.monotonic() - self._since

    def close(self) -> None:
        """Begin nothing more and deliver nothing more; the threads end when their job does."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _run(self) -> None:
        while (taken := self._take()) is not None:
            number, job = taken
            result = self._work(job)
            with self._changed:
                self._finish(number, result)

    def _take(self) -> tuple[int, Job] | None:
        """The job that waits, once it may begin; None at the end."""
        with self._changed:
            while not self._closed:
                if self._pending is None:
                    self._changed.wait()
                elif (early := self._next - time.monotonic()) > 0.0:
                    self._changed.wait(early)
                else:
                    taken, self._pending = self._pending, None
                    self._begun = taken[0]
                    self._next = time.monotonic() + _PATIENCE
                    return taken
        return None

    def _finish(self, number: int, result: Result) -> None:
        if number == self._begun:
            self._next = time.monotonic() + _PAUSE
            self._changed.notify_all()
        if number > self._delivered and not self._closed:
            self._delivered = number
            self._since = time.monotonic()
            self._deliver(result)
