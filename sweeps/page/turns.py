"""Who computes when: few at a time, and of each tab only its latest request.

Compiled code cannot be stopped. Who has begun asks `check` between its parts.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

_TABS = 1000  # those that were not heard of for longest are forgotten


class Void(Exception):  # noqa: N818 - an outcome of a request, not an error of it
    """A later request of the same tab has arrived: nobody waits for this one's answer."""


@dataclass(frozen=True, eq=False)
class Turn:
    """A place to compute in, or the wait for one."""

    check: Callable[[], None]
    """Raises `Void` where a later request of the tab has arrived."""


class Turns:
    """Hands out `slots` places to compute in; any thread may ask."""

    def __init__(self, slots: int = 2) -> None:
        self._free = slots
        self._changed = threading.Condition()
        self._latest: dict[str, int] = {}  # the number of a tab's latest request
        self._waiting: list[Turn] = []  # the longest waiting first

    @contextmanager
    def take(
        self, tab: str, number: int, on_wait: Callable[[], None] = lambda: None
    ) -> Iterator[Turn]:
        """Wait for a place, and hold it in the context; raises `Void` if there is no more need.

        `on_wait` is called once if there is no place yet. It must be quick: who came later waits
        for it.
        """
        turn = Turn(lambda: self._check(tab, number))
        self._arrive(turn, tab, number)
        self._wait(turn, on_wait)
        try:
            yield turn
        finally:
            with self._changed:
                self._free += 1
                self._changed.notify_all()

    def _arrive(self, turn: Turn, tab: str, number: int) -> None:
        """Stand at the end of those that wait, and make earlier requests of the tab void."""
        with self._changed:
            self._latest[tab] = max(number, self._latest.pop(tab, number))  # at the end now
            if len(self._latest) > _TABS:
                del self._latest[next(iter(self._latest))]
            self._waiting.append(turn)
            self._changed.notify_all()

    def _wait(self, turn: Turn, on_wait: Callable[[], None]) -> None:
        """Take a place when it is free and nobody has waited longer."""
        try:
            if not self._may_begin(turn):
                on_wait()
            with self._changed:
                self._changed.wait_for(lambda: self._may_begin(turn))
                self._free -= 1
        finally:
            with self._changed:
                self._waiting.remove(turn)
                self._changed.notify_all()

    def _may_begin(self, turn: Turn) -> bool:
        with self._changed:
            turn.check()
            return self._free > 0 and self._waiting[0] is turn

    def _check(self, tab: str, number: int) -> None:
        with self._changed:
            if self._latest.get(tab, number) > number:
                raise Void
