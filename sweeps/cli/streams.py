"""The standard streams, whose loss decides nothing about a computation."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from io import TextIOWrapper
from typing import TextIO

from sweeps.human import Messages


@contextlib.contextmanager
def lasting_streams() -> Iterator[None]:
    """Streams for the time of a command.

    Where one of the three is closed, a file that is opened would take its number, and messages
    would be written into it: it is opened on nothing. Messages that cannot be written are lost.
    """
    for number in (0, 1, 2):
        _hold(number)
    sys.stdin = sys.stdin or os.fdopen(0)
    sys.stdout = sys.stdout or os.fdopen(1, "w")
    before = sys.stderr or os.fdopen(2, "w")
    if isinstance(sys.stdout, TextIOWrapper):  # names of files need not be text
        sys.stdout.reconfigure(errors="backslashreplace")
    sys.stderr = Messages(before)
    try:
        yield
    finally:
        sys.stderr.flush()
        sys.stderr = before


def lose(stream: TextIO) -> None:
    """Have a stream that cannot be written lead nowhere: the interpreter flushes it at its end."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _hold(number: int) -> None:
    """Open a standard stream that is closed on nothing."""
    try:
        os.fstat(number)
    except OSError:
        nowhere = os.open(os.devnull, os.O_RDWR)
        if nowhere != number:
            os.dup2(nowhere, number)
            os.close(nowhere)
