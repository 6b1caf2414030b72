"""The standard streams; losing them never affects a computation."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator
from io import TextIOWrapper
from typing import TextIO

from sweeps.human import Messages, printable


@contextlib.contextmanager
def lasting_streams() -> Iterator[None]:
    """Provide standard streams for the duration of a command.

    If one of the three is closed, the next file to be opened would take its number, and messages
    would be written into that: so it is opened on the null device. Messages that cannot be written
    are lost.
    """
    for number in (0, 1, 2):
        _open_if_closed(number)
    sys.stdin = sys.stdin or os.fdopen(0)
    sys.stdout = sys.stdout or os.fdopen(1, "w")
    stderr = sys.stderr or os.fdopen(2, "w")
    if isinstance(sys.stdout, TextIOWrapper):  # file names need not be valid text
        sys.stdout.reconfigure(errors="backslashreplace")
    sys.stderr = Messages(stderr)
    try:
        yield
    finally:
        sys.stderr.flush()
        sys.stderr = stderr


@contextlib.contextmanager
def plain_warnings() -> Iterator[None]:
    """Print warnings of Python as those of a command: a sentence, once, without a place in code."""
    said: set[str] = set()

    def show(message: Warning | str, *_: object) -> None:
        text = " ".join(str(message).split())
        if text not in said:
            said.add(text)
            print(printable(f"warning: {text}"), file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show  # type: ignore[assignment] # it is called by position
        yield


def discard(stream: TextIO) -> None:
    """Redirect a broken stream to the null device: the interpreter flushes it at exit."""
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, stream.fileno())
    os.close(null)


def _open_if_closed(number: int) -> None:
    """Open a closed standard stream on the null device."""
    try:
        os.fstat(number)
    except OSError:
        null = os.open(os.devnull, os.O_RDWR)
        if null != number:
            os.dup2(null, number)
            os.close(null)
