"""A request to end early, and threads that do not keep the process alive."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

_T = TypeVar("_T")

LONGEST_STOP = 20.0
"""Seconds that a stop waits; ordinary blocks take a few, and batch systems kill after thirty."""


class Stop:
    """A request to begin no further block, which any thread and any signal handler may make."""

    def __init__(self) -> None:
        self.reason = ""
        self._since = 0.0

    @property
    def requested(self) -> bool:
        """True if no further block is to begin."""
        return bool(self.reason)

    def request(self, reason: str) -> None:
        """Ask to end once the blocks in flight are finished or `is_over`; keep the first reason."""
        if not self.reason:
            self._since = time.monotonic()
            self.reason = reason

    @property
    def is_over(self) -> bool:
        """True if nobody waits for the blocks in flight any longer."""
        return bool(self.reason) and time.monotonic() - self._since >= LONGEST_STOP


def in_thread(work: Callable[[], _T]) -> Future[_T]:
    """Begin `work` in a thread that does not keep the process alive, and return its future."""
    outcome: Future[_T] = Future()

    def attempt() -> None:
        try:
            outcome.set_result(work())
        except BaseException as error:  # noqa: BLE001 - the future raises it
            outcome.set_exception(error)

    threading.Thread(target=attempt, daemon=True).start()
    return outcome


def run_interruptibly(work: Callable[[], _T]) -> _T:
    """Return the result of `work`; Ctrl-C is raised at once, and the work goes on in its thread.

    Compiled code neither notices Ctrl-C nor can be stopped.
    """
    return in_thread(work).result()
