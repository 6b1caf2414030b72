"""Helpers for tests of progress: a clock, streams, counts of points, tasks, a real terminal."""

from __future__ import annotations

import io
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import threading
import time
from collections.abc import Callable
from fcntl import ioctl
from pathlib import Path

import numpy as np
import pytest

from stickslip import Options, Status
from stickslip.dispatch.task import Block, Task
from support.sweeps.processes import HANGS, default_signals, ends_with_its_test
from sweeps.engine.progress import Counts
from sweeps.files.result_rows import Memory

HIDDEN, VISIBLE = "\x1b[?25l", "\x1b[?25h"


class Clock:
    """Monotonic time that a test moves."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


def terminal_of(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Send messages to a terminal of 80 columns.

    To be called in the body of a test, since pytest would replace an earlier one.
    """
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    return terminal


class Log(io.StringIO):
    """A log that sets `there` when it has as many lines as wanted."""

    def __init__(self, wanted: int) -> None:
        super().__init__()
        self._wanted, self.there = wanted, threading.Event()

    def write(self, text: str) -> int:
        written = super().write(text)
        if self.getvalue().count("\n") >= self._wanted:
            self.there.set()
        return written


def found(**by_status: int) -> Memory:
    """A store with these counts of points by status."""
    store = Memory(0)
    for name, count in by_status.items():
        store.statuses[Status[name.upper()]] = count
    return store


def task(first: int, points: int) -> Task:
    """A task of some points; the first has the number `first`."""
    indices = np.arange(first, first + points)
    return Task(indices, np.zeros((points, 1)), Options(), "code")


def advanced(counts: Counts, store: Memory, seconds: float = 0.0, **by_status: int) -> None:
    """Finish a block: note its cost, and count its points in the store."""
    counts.costs.learn(sum(by_status.values()), seconds)
    store.statuses += found(**by_status).statuses


def block_of(task: Task) -> Block:
    """The block of a task."""
    return Block(task.indices, np.zeros((len(task.indices), 1)))


def plain(text: str) -> str:
    """A text without control sequences of terminals."""
    return re.sub(r"\x1b\[[\d;?]*\w", "", text)


class OnTerminal:
    """A Python process on a terminal of 80 columns, which ends with its test, whatever happens."""

    def __init__(self, code: str, *arguments: str, folder: Path) -> None:
        self.text = ""
        with default_signals():
            self._pid, self._handle = pty.fork()
            if self._pid == 0:  # still within: what is ignored here would be ignored there
                os.chdir(folder)
                os.environ |= {"TERM": "xterm", "COLUMNS": "80", "LINES": "24"}
                os.execv(sys.executable, [sys.executable, "-c", code, *arguments])
        ends_with_its_test(self)
        ioctl(self._handle, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))

    def shows(self, text: str) -> None:
        """Wait until the process has written a text, anywhere."""
        self._read_until(lambda: text in plain(self.text))
        assert text in plain(self.text), f"it has ended; it said {self.text!r}"

    def types(self, keys: bytes) -> None:
        os.write(self._handle, keys)

    def ended(self) -> int:
        """Wait for the end of the process; return its exit code."""
        self._read_until(lambda: False)
        return os.waitstatus_to_exitcode(self._left())

    def hung_up(self) -> int:
        """Close the terminal; return the exit code of the process."""
        return os.waitstatus_to_exitcode(self._left())

    def end(self) -> None:
        """Kill the process."""
        if self._pid:
            os.kill(self._pid, signal.SIGKILL)
            self._left()

    def _left(self) -> int:
        """Close the terminal, wait for the end of the process, and return its status."""
        os.close(self._handle)
        ended, status = 0, 0
        latest = time.monotonic() + HANGS
        while not ended:
            assert time.monotonic() < latest, "it hangs"
            time.sleep(0.02)
            ended, status = os.waitpid(self._pid, os.WNOHANG)
        self._pid = 0
        return status

    def _read_until(self, condition: Callable[[], bool]) -> None:
        """Read the output until the condition holds or the process has ended."""
        latest = time.monotonic() + HANGS
        while not condition():
            assert time.monotonic() < latest, f"it hangs; it said {self.text!r}"
            if not select.select([self._handle], [], [], 1.0)[0]:
                continue
            try:
                self.text += os.read(self._handle, 65536).decode(errors="replace")
            except OSError:  # the other end has closed
                return
