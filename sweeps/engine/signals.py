"""Ending early: Ctrl-C, a signal of the batch system, the end of the time that was granted."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

from sweeps.engine.interrupt import INTERRUPTED, InThread

STOPPED = 4

_SECONDS = {"": 1.0, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_PART = re.compile(r"(\d+(?:\.\d+)?)\s*(s|min|m|h|d|)\s*")


def parse_duration(text: str) -> float:
    """Seconds of a duration such as `2h`, `90 min`, `1h30m`, `45s` or a number of seconds.

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


class Stop:
    """Whether a sweep is to end before it is done, why, and with which exit code."""

    def __init__(self, max_runtime: float | None = None) -> None:
        self._deadline = None if max_runtime is None else time.monotonic() + max_runtime
        self.reason = ""
        self.code = STOPPED
        self.at_once: list[Callable[[], None]] = []

    @property
    def requested(self) -> bool:
        """Whether no further block is to be begun."""
        if not self.reason and self._deadline is not None and time.monotonic() >= self._deadline:
            self.request("the time of --max-runtime is over")
        return bool(self.reason)

    def request(self, reason: str, code: int = STOPPED) -> None:
        """End when the blocks in flight are finished; the first reason counts."""
        if not self.reason:
            self.reason, self.code = reason, code


@contextlib.contextmanager
def listening(stop: Stop) -> Iterator[None]:
    """Signals request a stop while this lasts; the second one ends the process.

    What stands in `stop.at_once` is called before that, the last first. Outside the main thread,
    where signals do not arrive, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def heard(number: int, _: FrameType | None) -> None:
        name = signal.Signals(number).name
        code = INTERRUPTED if number == signal.SIGINT else STOPPED
        if stop.reason:
            for tidy in reversed(stop.at_once):
                tidy()
            sys.stderr.write("\nEnded at once; what was journaled is kept.\n")
            sys.stderr.flush()
            os._exit(code)
        stop.request("Ctrl-C" if number == signal.SIGINT else name, code)
        sys.stderr.write(
            f"\n{stop.reason}: finishing the blocks in flight; a second signal ends at once\n"
        )
        sys.stderr.flush()

    signals = [
        number
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        if signal.getsignal(number) is not signal.SIG_IGN  # as under nohup
    ]
    before = {number: signal.signal(number, heard) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def wait_for(work: Callable[[], None], stop: Stop) -> bool:
    """Do `work` in a thread; returns False, without waiting for it, when a stop is requested.

    For what compiled code or a compiler does for long without looking for signals. What `work`
    raises is raised here.
    """
    working = InThread(work)
    while not working.wait():
        if stop.requested:
            return False
    working.result  # noqa: B018 - raises what the work raised
    return True
