"""Ctrl-C during compiled code, which does not look for signals and cannot be stopped."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

_T = TypeVar("_T")

INTERRUPTED = 130


class InThread(Generic[_T]):
    """`work`, begun in a thread that does not keep the process alive."""

    def __init__(self, work: Callable[[], _T]) -> None:
        self._outcome: list[_T] = []
        self._error: BaseException | None = None

        def attempt() -> None:
            try:
                self._outcome.append(work())
            except BaseException as error:  # noqa: BLE001 - handed over to the main thread
                self._error = error

        self._thread = threading.Thread(target=attempt, daemon=True)
        self._thread.start()

    def wait(self) -> bool:
        """Wait for a moment in which signals are heard; returns whether the work is over."""
        self._thread.join(0.1)
        return not self._thread.is_alive()

    @property
    def result(self) -> _T:
        """What the work returned; what it raised is raised here."""
        if self._error is not None:
            raise self._error
        return self._outcome[0]


def interruptible(
    work: Callable[[], _T], message: str, *, tidy: Callable[[], None] | None = None
) -> _T:
    """The result of `work`, computed in a thread while the main thread listens for Ctrl-C.

    On Ctrl-C `tidy` is called, `message` is printed and the process ends at once with exit code
    130: nothing else that would have to be tidied up may happen inside `work`. What `work` raises
    is raised here.
    """
    try:
        working = InThread(work)
        while not working.wait():
            pass
    except KeyboardInterrupt:
        if tidy is not None:
            tidy()
        sys.stderr.write(f"\n{message}\n")
        sys.stderr.flush()
        sys.stdout.flush()
        os._exit(INTERRUPTED)
    return working.result
