"""Processes that a sweep starts: which signals they get, and that they end when it ends."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Iterator
from multiprocessing import resource_tracker

_FROM_A_TERMINAL = {signal.SIGINT, signal.SIGHUP}


@contextlib.contextmanager
def terminal_signals_blocked() -> Iterator[None]:
    """Processes that are started meanwhile do not get Ctrl-C, nor the end of the terminal.

    A terminal sends both to all processes of its foreground group, but the main process alone
    decides what ends. The signals are blocked (pthread_sigmask) before the fork, because a new
    process takes a second to import what it needs, and a handler that it installs after that comes
    too late.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
    try:
        # It lives as long as this process. Its start unblocks the signals, hence once more.
        resource_tracker.ensure_running()
        signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent(parent: int) -> None:
    """In a new process: end within a second of its parent, whatever ended that one."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
