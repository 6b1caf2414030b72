"""The processes that a sweep starts: what they import, which signals they get, when they end."""

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
    """Make new processes ignore the terminal and import nothing from the current folder.

    A terminal sends Ctrl-C and a hangup to all processes of its foreground group, but the main
    process alone decides what ends. We block the signals (pthread_sigmask) before the fork, because
    a new process takes a second to import its modules, and a handler that it installs then comes
    too late.

    The current folder may contain anything, and a user's `queue.py` there would end every worker.
    The workers still import from wherever this process does; loky sees to that.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
    try:
        with _safe_path():
            # The tracker lives as long as this process. Its start unblocks the signals, so we block
            # them again.
            resource_tracker.ensure_running()
            signal.pthread_sigmask(signal.SIG_BLOCK, _FROM_A_TERMINAL)
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _safe_path() -> Iterator[None]:
    """Set the variable only for now: a process that a user's script starts keeps its path."""
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
    """Return a pool of processes that end with this one, for use within `children_started`."""
    from joblib.externals.loky import ProcessPoolExecutor

    # A thread of the pool, outside `children_started`, replaces processes that end.
    return ProcessPoolExecutor(
        workers, initializer=_begin, initargs=(os.getpid(),), env={_SAFE_PATH: "1"}
    )


def _begin(parent: int) -> None:
    """Make this new process end within a second of its parent, however the parent ends.

    It repeats no warnings about the cache of compiled code, since the parent has given them.
    """
    warnings.filterwarnings("ignore", ".*compiled code", RuntimeWarning)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
