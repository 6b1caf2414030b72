"""Processes that tests start: default signals, output to be read at any time, waits that end."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import IO, Any, Protocol

HANGS = 120.0  # seconds: longer than anything takes, on any machine

_SIGNALS = (signal.SIGINT, signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT)


class Ending(Protocol):
    """What ends at once when it is told to."""

    def end(self) -> None: ...


_started: list[Ending] = []


def ends_with_its_test(process: Ending) -> None:
    """Have `end_all` end it, whatever happens."""
    _started.append(process)


@contextlib.contextmanager
def default_signals() -> Iterator[None]:
    """Signals act meanwhile, here and in processes that are started.

    In the background of a shell, or under nohup, the suite ignores some of them, and a process
    hands down what it ignores.
    """
    ignored = [number for number in _SIGNALS if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


def wait_until(condition: Callable[[], object], still: Callable[[], bool] = lambda: True) -> None:
    """Wait until the condition holds; fail when it takes for ever, or `still` does not hold."""
    latest = time.monotonic() + HANGS
    while not condition():
        assert still() or condition(), "it has ended"
        assert time.monotonic() < latest, "it hangs"
        time.sleep(0.02)


class Running:
    """A Python process, begun with default signals; whatever happens, it ends with its test."""

    def __init__(self, *arguments: str, session: bool = False, **settings: Any) -> None:
        files = self._files = contextlib.ExitStack()
        # They are closed by `end`.
        self._out = files.enter_context(tempfile.TemporaryFile())  # noqa: SIM115
        self._err = files.enter_context(tempfile.TemporaryFile())  # noqa: SIM115
        with default_signals():
            self.process = subprocess.Popen(
                [sys.executable, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=self._out,
                stderr=self._err,
                start_new_session=session,
                **settings,
            )
        ends_with_its_test(self)

    @property
    def pid(self) -> int:
        return self.process.pid

    @property
    def out(self) -> str:
        """What it has written to the standard output so far."""
        return _text(self._out)

    @property
    def err(self) -> str:
        """What it has written to the standard error so far."""
        return _text(self._err)

    def is_alive(self) -> bool:
        return self.process.poll() is None

    def says(self, text: str, times: int = 1) -> None:
        """Wait until it has written this, so many times."""
        try:
            wait_until(lambda: (self.out + self.err).count(text) >= times, self.is_alive)
        except AssertionError as error:
            raise AssertionError(f"{error}; it said {self.out + self.err!r}") from error

    def signal(self, number: int) -> None:
        self.process.send_signal(number)

    def ended(self) -> tuple[int, str, str]:
        """Its exit code and all that it has written; waits for its end."""
        code = self.process.wait(HANGS)
        return code, self.out, self.err

    def end(self) -> None:
        """Kill it; its output is gone."""
        self.process.kill()
        self.process.wait(HANGS)
        self._files.close()


def end_all() -> None:
    """Kill what a test has left running."""
    while _started:
        _started.pop().end()


def _text(file: IO[bytes]) -> str:
    # The process shares the position of the file, which must stay where it writes.
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0).decode()
