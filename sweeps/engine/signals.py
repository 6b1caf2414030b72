"""Ending early: on Ctrl-C, on a signal of the batch system, or when the granted time is over.

Compiled code does not check for signals and cannot be stopped, so it runs in a thread while the
main thread listens.
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
    """Return the seconds of a duration such as `2h`, `90 min`, `1h30m`, `45s` or `45`.

    Raises ValueError.
    """
    parts = _PART.findall(text)
    rest, units = "".join(_PART.split(text)[::3]).strip(), [unit for _, unit in parts]
    if not parts or rest or (len(parts) > 1 and "" in units):
        raise ValueError(f"{text!r} is not a duration; write, for example, 2h, 90min, 1h30m or 45s")
    seconds = sum(float(number) * _SECONDS[unit] for number, unit in parts)
    if seconds <= 0.0:
        raise ValueError("a duration must be longer than 0")
    return seconds


class Stop(stop.Stop):
    """A request to end a sweep early, with its reason and exit code.

    `at_a_stop` returns a text about what a stop finishes and what it gives up, empty if nothing is
    in flight. A second signal ends the process if `ends_process` is true, else it raises
    KeyboardInterrupt; in both cases the functions in `at_once` are called first. The first signal
    after a stop for another reason, such as the end of the granted time, ends nothing at once.
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
            self.request("the time allowed by --max-runtime is up")
        return bool(self.reason)

    def request(self, reason: str, code: Exit = Exit.STOPPED) -> None:
        """Request the stop as the base class does, with an exit code."""
        if not self.reason:
            self.code = code
        super().request(reason)


@contextlib.contextmanager
def listening(stop: Stop) -> Iterator[None]:
    """Let a signal request a stop; a second one ends the process or raises KeyboardInterrupt.

    Before that, the functions in `stop.at_once` are called, the last one first. Ignored signals,
    as under nohup, stay ignored, and handlers that are not Python's stay as they are. Outside the
    main thread, where no signals arrive, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    heard = False

    def handle(number: int, _: FrameType | None) -> None:
        nonlocal heard
        from_keyboard = number == signal.SIGINT
        code = Exit.INTERRUPTED if from_keyboard else Exit.STOPPED
        if heard:
            for tidy in reversed(stop.at_once):
                tidy()
            if not stop.ends_process:
                raise KeyboardInterrupt
            _write("Ended at once; points in the journal are kept.")
            os._exit(code)
        heard = True  # not `stop.reason`, which may be an earlier one
        stop.request("Ctrl-C" if from_keyboard else signal.Signals(number).name, code)
        happens = stop.at_a_stop()
        if happens.startswith("finishing"):
            again = "Ctrl-C" if from_keyboard else "signal"
            happens += f".\nAnother {again} ends the run at once and drops the points in flight."
        _write(f"{stop.reason}: {happens or 'ending'}")

    # A handler that was not installed from Python, as by R around Python, could not be put back.
    others = (signal.SIG_IGN, None)
    heeded = [number for number in _SIGNALS if signal.getsignal(number) not in others]
    before = {number: signal.signal(number, handle) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _write(message: str) -> None:
    messages = Messages(sys.stderr)
    messages.write(f"\n{message}\n")  # the line may already hold ^C or the bar
    messages.flush()


def interruptible(
    work: Callable[[], _T],
    *at_once: Callable[[], None],
    message: str = "Interrupted; nothing was kept.",
) -> _T:
    """Return the result of `work`, computed in a thread while the main thread listens for Ctrl-C.

    On Ctrl-C the functions of `at_once` are called in turn, `message` is printed and the process
    ends with exit code 130. So `work` must leave nothing else behind that needs tidying up. Errors
    of `work` are raised here.
    """
    try:
        outcome = in_thread(work)
        while not _is_over(outcome):
            pass
    except KeyboardInterrupt:
        for tidy in at_once:
            tidy()
        _write(message)
        sys.stdout.flush()
        os._exit(Exit.INTERRUPTED)
    return outcome.result()


def wait_for(work: Callable[[], None], stop: Stop) -> bool:
    """Do `work` in a thread; return False without waiting for it if a stop is requested.

    Errors of `work` are raised here.
    """
    outcome = in_thread(work)
    while not _is_over(outcome):
        if stop.requested:
            return False
    outcome.result()
    return True


def _is_over(outcome: Future[_T]) -> bool:
    """Wait a moment, in which signals are handled; return whether the work is over."""
    wait([outcome], timeout=0.1)
    return outcome.done()
