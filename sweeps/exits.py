"""The exit codes of the command line, and the failures that end with one."""

from enum import IntEnum

from stickslip.dispatch.errors import ExecutorError


class Exit(IntEnum):
    """The exit codes of commands, for batch scripts."""

    DONE = 0
    UNEXPECTED = 1
    USAGE = 2
    FAILED_POINTS = 3
    STOPPED = 4
    STORAGE = 5
    INTERRUPTED = 130  # 128 + SIGINT, as shells count


class ExpectedError(Exception):
    """A failure whose message says what to do; the command line prints it and exits with `code`."""

    code = Exit.USAGE


class StorageError(ExpectedError, OSError):
    """A file that cannot be read or written, or does not read back as it was written."""

    code = Exit.STORAGE


EXPECTED = (ExpectedError, ExecutorError)
"""The failures whose message says what to do."""


def code_of(error: ExpectedError | ExecutorError) -> Exit:
    """Return the exit code of such a failure; where workers were lost, the rest can still come."""
    return error.code if isinstance(error, ExpectedError) else Exit.STOPPED
