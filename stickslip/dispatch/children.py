"""Processes that a sweep starts: what they import, which signals they get, and when they end."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import warnings
from collections.abc import Iterator
from multiprocessing import resource_tracker
from typing import Any

_FROM_A_TERMINAL = {signal.SIGINT, signal.SIGHUP}

_SAFE_PATH = "PYTHONSAFEPATH"
_environment = threading.RLock()


@contextlib.contextmanager
def children_started() -> Iterator[None]:
    """Start processes meanwhile: deaf to the terminal, and without the current folder on the path.

    A terminal sends Ctrl-C, and its own end, to all processes of its foreground group, but the main
    process alone decides what ends. The signals are blocked (pthread_sigmask) before the fork,
    because a new process takes a second to import what it needs, and a handler that it installs
    after that comes too late.

    The current folder may be anybody's, and a `queue.py` of one's own there would end every worker.
    From where this process imports, its workers do too, by loky.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
    try:
        with _safe_path():
            # It lives as long as this process. Its start unblocks the signals, hence once more.
            resource_tracker.ensure_running()
            signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _safe_path() -> Iterator[None]:
    """Set the variable for children alone: what a user's script starts later keeps its path."""
    with _environment:
        before = os.environ.get(_SAFE_PATH)
        os.environ[_SAFE_PATH] = "1"
        try:
            yield
        finally:
            if before is None:
                del os.environ[_SAFE_PATH]
            else:
                os.environ[_SAFE_PATH] = before


def process_pool(workers: int) -> Any:
    """Return a pool of processes that end with this one; it is to be used in `children_started`."""
    from joblib.externals.loky import ProcessPoolExecutor

    # Its own thread starts processes too, in place of those that end.
    return ProcessPoolExecutor(
        workers, initializer=end_with_parent, initargs=(os.getpid(),), env={_SAFE_PATH: "1"}
    )


def end_with_parent(parent: int) -> None:
    """Make a new process end within a second of its parent, however the parent ended.

    The parent has already reported on the compiled-code cache.
    """
    warnings.filterwarnings("ignore", ".*compiled code", RuntimeWarning)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
