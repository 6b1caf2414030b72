"""The exit codes of the command line."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """How a command ended; batch scripts decide by these numbers."""

    DONE = 0
    UNEXPECTED = 1
    USAGE = 2
    FAILED_POINTS = 3
    STOPPED = 4
    STORAGE = 5
    INTERRUPTED = 130  # 128 + SIGINT, as shells count
