"""Processes that tests start, with default signals, readable output, and waits that end."""

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
    """A process that a test can end at once."""

    def end(self) -> None: ...


_started: list[Ending] = []


def ends_with_its_test(process: Ending) -> None:
    """Register a process, which `end_all` ends whatever happens."""
    _started.append(process)


@contextlib.contextmanager
def default_signals() -> Iterator[None]:
    """Give signals their default action in this process and in processes started meanwhile.

    In the background of a shell, or under nohup, the suite ignores some signals, and its child
    processes inherit that.
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
    """Wait until the condition holds; fail if it takes too long, or `still` no longer holds."""
    latest = time.monotonic() + HANGS
    while not condition():
        assert still() or condition(), "it has ended"
        assert time.monotonic() < latest, "it hangs"
        time.sleep(0.02)


class Running:
    """A Python process with default signals, which ends with its test, whatever happens."""

    def __init__(self, *arguments: str, session: bool = False, **settings: Any) -> None:
        files = self._files = contextlib.ExitStack()
        # `end` closes them.
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
        """The standard output so far."""
        return _text(self._out)

    @property
    def err(self) -> str:
        """The standard error so far."""
        return _text(self._err)

    def is_alive(self) -> bool:
        return self.process.poll() is None

    def says(self, text: str, times: int = 1) -> None:
        """Wait until the process has written a text this many times."""
        try:
            wait_until(lambda: (self.out + self.err).count(text) >= times, self.is_alive)
        except AssertionError as error:
            raise AssertionError(f"{error}; it said {self.out + self.err!r}") from error

    def signal(self, number: int) -> None:
        self.process.send_signal(number)

    def ended(self) -> tuple[int, str, str]:
        """Wait for the end; return the exit code and the whole output."""
        code = self.process.wait(HANGS)
        return code, self.out, self.err

    def end(self) -> None:
        """Kill the process and drop its output."""
        self.process.kill()
        self.process.wait(HANGS)
        self._files.close()


def end_all() -> None:
    """Kill the processes that a test has left running."""
    while _started:
        _started.pop().end()


def _text(file: IO[bytes]) -> str:
    # The process shares the position of the file, which must stay where it writes.
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0).decode()
