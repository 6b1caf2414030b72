"""Ending early: on Ctrl-C, on a signal of the batch system, or when the time granted is over.

Compiled code does not look for signals and cannot be stopped: it runs in a thread, while the main
thread listens.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from types import FrameType
from typing import TypeVar

from stickslip.dispatch import stop
from stickslip.dispatch.stop import in_thread
from sweeps.exits import Exit
from sweeps.human import Messages

_T = TypeVar("_T")

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_SECONDS = {"": 1.0, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_PART = re.compile(r"(\d+(?:\.\d+)?)\s*(s|min|m|h|d|)\s*")


def parse_duration(text: str) -> float:
    """Return the seconds of a duration: `2h`, `90 min`, `1h30m`, `45s`, a number of seconds.

    Raises ValueError.
    """
    parts = _PART.findall(text)
    rest, units = "".join(_PART.split(text)[::3]).strip(), [unit for _, unit in parts]
    if not parts or rest or (len(parts) > 1 and "" in units):
        raise ValueError(f"{text!r} is no duration; write for example 2h, 90min, 1h30m or 45s")
    seconds = sum(float(number) * _SECONDS[unit] for number, unit in parts)
    if seconds <= 0.0:
        raise ValueError("a duration must be longer than 0")
    return seconds


class Stop(stop.Stop):
    """A request to end a sweep early, with its reason and exit code.

    `at_a_stop` says what is finished first, and what is given up; an empty text where nothing is
    begun. A second signal ends the process where it `ends_process`, else it is a KeyboardInterrupt.
    """

    def __init__(self, max_runtime: float | None = None, *, ends_process: bool = True) -> None:
        super().__init__()
        self.ends_process = ends_process
        self._deadline = None if max_runtime is None else time.monotonic() + max_runtime
        self.code = Exit.STOPPED
        self.at_a_stop: Callable[[], str] = lambda: ""
        self.at_once: list[Callable[[], None]] = []

    @property
    def requested(self) -> bool:
        """True if no further block is to begin."""
        if not self.reason and self._deadline is not None and time.monotonic() >= self._deadline:
            self.request("the time of --max-runtime is over")
        return bool(self.reason)

    def request(self, reason: str, code: Exit = Exit.STOPPED) -> None:
        """End as the parent says, with an exit code."""
        if not self.reason:
            self.code = code
        super().request(reason)


@contextlib.contextmanager
def listening(stop: Stop) -> Iterator[None]:
    """Signals request a stop while this lasts; the second one ends the process.

    What stands in `stop.at_once` is called before that, the last first. Signals that are ignored,
    as under nohup, stay ignored; outside the main thread, where signals do not arrive, nothing is
    changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, _: FrameType | None) -> None:
        from_keyboard = number == signal.SIGINT
        code = Exit.INTERRUPTED if from_keyboard else Exit.STOPPED
        if stop.reason:
            for tidy in reversed(stop.at_once):
                tidy()
            if not stop.ends_process:
                raise KeyboardInterrupt
            _write("Ended at once; what was journaled is kept.")
            os._exit(code)
        stop.request("Ctrl-C" if from_keyboard else signal.Signals(number).name, code)
        happens = stop.at_a_stop()
        if happens.startswith("finishing"):
            again = "Ctrl-C" if from_keyboard else "signal"
            happens += f".\nAnother {again} ends at once and gives up what is in flight."
        _write(f"{stop.reason}: {happens or 'ending'}")

    heeded = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, handle) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _write(message: str) -> None:
    messages = Messages(sys.stderr)
    messages.write(f"\n{message}\n")  # the terminal has written ^C, or the bar a line
    messages.flush()


def interruptible(
    work: Callable[[], _T], message: str, *, at_once: Callable[[], None] = lambda: None
) -> _T:
    """Return the result of `work`, computed in a thread while the main thread listens for Ctrl-C.

    On Ctrl-C `at_once` is called, `message` is printed and the process ends with exit code 130:
    nothing else that would have to be tidied up may happen inside `work`. What `work` raises is
    raised here.
    """
    try:
        outcome = in_thread(work)
        while not _is_over(outcome):
            pass
    except KeyboardInterrupt:
        at_once()
        _write(message)
        sys.stdout.flush()
        os._exit(Exit.INTERRUPTED)
    return outcome.result()


def wait_for(work: Callable[[], None], stop: Stop) -> bool:
    """Do `work` in a thread; returns False, without waiting for it, when a stop is requested.

    What `work` raises is raised here.
    """
    outcome = in_thread(work)
    while not _is_over(outcome):
        if stop.requested:
            return False
    outcome.result()
    return True


def _is_over(outcome: Future[_T]) -> bool:
    """Return whether work is over after a moment, in which signals are heard."""
    wait([outcome], timeout=0.1)
    return outcome.done()
