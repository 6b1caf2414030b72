"""The exit codes of the command line, and the errors that end with them."""

from enum import IntEnum

from stickslip.dispatch.errors import ExecutorError


class Exit(IntEnum):
    """The exit codes of commands, for use in batch scripts."""

    DONE = 0
    UNEXPECTED = 1
    USAGE = 2
    FAILED_POINTS = 3
    STOPPED = 4
    STORAGE = 5
    INTERRUPTED = 130  # 128 + SIGINT, as shells count


class ExpectedError(Exception):
    """An error whose message says what to do; the command line prints it and exits with `code`."""

    code = Exit.USAGE


class StorageError(ExpectedError, OSError):
    """A file that cannot be read or written, or whose content differs from what was written."""

    code = Exit.STORAGE


EXPECTED = (ExpectedError, ExecutorError)
"""The errors whose message says what to do."""


def code_of(error: ExpectedError | ExecutorError) -> Exit:
    """Return the exit code of an expected error; a sweep that lost its workers can be resumed."""
    return error.code if isinstance(error, ExpectedError) else Exit.STOPPED
